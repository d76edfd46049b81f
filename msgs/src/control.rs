//! Commands. The definitions in `msg/` and `srv/` are the truth.

use crate::definition::{Definition, RosType};
use crate::standard::Header;
use serde::{Deserialize, Serialize};

/// Corrections on the slicer's own values with a validity: the controller's wish (topic
/// control/command) and what the supervisor allows (topic safety/command).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ControlCommand {
    /// stamp [s]: time of sending on the node's clock; deadlines run on receipt, not on it
    pub header: Header,
    /// Random id of the publisher's run.
    pub session_id: u64,
    /// Counts up within a session.
    pub sequence: u64,
    /// ] How long the command counts after receipt `[s]`. Range `(0, inf)`.
    pub validity_s: f64,
    /// One of MODE_*; MODE_INIT in a controller's wish. Range `[0, 7]`.
    pub mode: u8,
    /// One of REQUEST_*; REQUEST_RUN in a controller's wish. Range `[0, 4]`.
    pub request: u8,
    /// Filament per path length relative to the slicer's. Range `[0, inf)`.
    pub flow_factor: f64,
    /// ] Path speed relative to the slicer's. Range `(0, inf)`.
    pub speed_factor: f64,
    /// Offset on the file's hot end set-point `[K]`.
    pub nozzle_setpoint_offset_k: f64,
    /// Whether advance_s counts; false keeps the file's own.
    pub set_advance: bool,
    /// Pressure advance `[s]`. Range `[0, inf)`; invalid where set_advance is false.
    pub advance_s: f64,
    /// Whether slip_compensation counts, in a loop on the encoder where one is fitted; false leaves it open.
    pub close_extruder_loop: bool,
    /// Share of the motor's feed lost in the drive gear. Range `[0, 1)`; invalid where
    /// close_extruder_loop is false.
    pub slip_compensation: f64,
    /// One of HEALTH_*; HEALTH_SOUND in a permit. Range `[0, 4]`.
    pub health: u8,
}

impl ControlCommand {
    /// `MODE_INIT` of the definition.
    pub const MODE_INIT: u8 = 0;
    /// `MODE_OBSERVE` of the definition.
    pub const MODE_OBSERVE: u8 = 1;
    /// `MODE_ADVISE` of the definition.
    pub const MODE_ADVISE: u8 = 2;
    /// `MODE_ACT` of the definition.
    pub const MODE_ACT: u8 = 3;
    /// `MODE_DEGRADED` of the definition.
    pub const MODE_DEGRADED: u8 = 4;
    /// `MODE_PAUSED` of the definition.
    pub const MODE_PAUSED: u8 = 5;
    /// `MODE_SAFE_OFF` of the definition.
    pub const MODE_SAFE_OFF: u8 = 6;
    /// `MODE_ESTOP` of the definition.
    pub const MODE_ESTOP: u8 = 7;
    /// `REQUEST_RUN` of the definition.
    pub const REQUEST_RUN: u8 = 0;
    /// `REQUEST_PAUSE` of the definition.
    pub const REQUEST_PAUSE: u8 = 1;
    /// `REQUEST_STANDBY` of the definition.
    pub const REQUEST_STANDBY: u8 = 2;
    /// `REQUEST_HEATERS_OFF` of the definition.
    pub const REQUEST_HEATERS_OFF: u8 = 3;
    /// `REQUEST_EMERGENCY_STOP` of the definition.
    pub const REQUEST_EMERGENCY_STOP: u8 = 4;
    /// `HEALTH_SOUND` of the definition.
    pub const HEALTH_SOUND: u8 = 0;
    /// `HEALTH_SATURATED` of the definition.
    pub const HEALTH_SATURATED: u8 = 1;
    /// `HEALTH_LATE` of the definition.
    pub const HEALTH_LATE: u8 = 2;
    /// `HEALTH_INFEASIBLE` of the definition.
    pub const HEALTH_INFEASIBLE: u8 = 3;
    /// `HEALTH_NOT_FINITE` of the definition.
    pub const HEALTH_NOT_FINITE: u8 = 4;
}

impl RosType for ControlCommand {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "ControlCommand",
        text: include_str!("../msg/ControlCommand.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// Corrections attached to one coming move: the controller's wish (topic control/schedule) and what the supervisor
/// lets through (topic safety/schedule).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct MotionTrim {
    /// stamp [s]: time of sending on the node's clock; deadlines run on receipt, not on it
    pub header: Header,
    /// Random id of the publisher's run: of its commands or permits too, and counts only beside them.
    pub session_id: u64,
    /// Counts up within a session.
    pub sequence: u64,
    /// How long after receipt the move must have begun; then the trim lapses `[s]`. Range `[0.001, 60]`.
    pub validity_s: f64,
    /// Number of the move, as in printer/coming and printer/motion. Range `[1, inf)`.
    pub segment: u64,
    /// Filament per path length relative to the slicer's. Range `[0, 10]`.
    pub flow_factor: f64,
    /// Path speed relative to the slicer's. Range `[0, 10]`.
    pub speed_factor: f64,
    /// Pressure advance that does not depend on the feed `[s]`. Range `[0, 10]`.
    pub advance_linear_s: f64,
    /// Scale of the melt's part, which falls as the feed rises `[m (s/m)^index]`. Range `[0, 10]`.
    pub advance_shear_m: f64,
    /// Flow index of the melt; above 0. Range `[0, 1]`.
    pub advance_index: f64,
    /// Filament held compressed that no advance pushed: taken off the advance at every feed `[m]`. Range `[0, 0.01]`.
    pub advance_carried_m: f64,
}

impl RosType for MotionTrim {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "MotionTrim",
        text: include_str!("../msg/MotionTrim.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}
