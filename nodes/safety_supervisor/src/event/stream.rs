//! Who is listened to.

/// A stream the supervisor listens to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stream {
    /// Hot end temperature.
    Hotend,
    /// Bed temperature.
    Bed,
    /// Filament encoder.
    Encoder,
    /// Printer state.
    Printer,
    /// Controller commands.
    Command,
    /// State estimate.
    Estimate,
    /// Accelerations of the tool.
    Imu,
    /// What the camera's judge says.
    Vision,
}

impl Stream {
    /// Every stream.
    pub const ALL: [Self; 8] = [
        Self::Hotend,
        Self::Bed,
        Self::Encoder,
        Self::Printer,
        Self::Command,
        Self::Estimate,
        Self::Imu,
        Self::Vision,
    ];
}

/// A process whose heart is listened to: its own messages come too rarely, or come of somebody else, to tell a hang.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Worker {
    /// `filament_encoder`.
    Encoder,
    /// `state_estimator`.
    Estimator,
    /// `mpc_controller`.
    Controller,
    /// `camera`.
    Camera,
    /// `defect_classifier`.
    Judge,
}

impl Worker {
    /// Every one.
    pub const ALL: [Self; 5] = [Self::Encoder, Self::Estimator, Self::Controller, Self::Camera, Self::Judge];
}
