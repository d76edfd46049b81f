//! What goes into the executor and what comes out of it.

use crate::drive::Feed;
use models::command::Trims;
use models::status::HostProfile;
use models::units::Celsius;

/// Settings of the host and the firmware's motion; from `config/printer_sim.param.yaml`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Who executes trims.
    pub host: HostProfile,
    /// Moves that a serial host keeps in the firmware's buffer `[-]`.
    pub serial_buffer_moves: usize,
    /// Time that a serial host keeps in the firmware's buffer `[s]`.
    pub serial_buffer_s: f64,
    /// Longest piece that it cuts a move into `[s]`.
    pub serial_piece_s: f64,
    /// Moves that a firmware which plans the file itself knows ahead, at most `[-]`.
    pub plan_moves: usize,
    /// Time that it knows ahead `[s]`.
    pub plan_s: f64,
    /// Highest advance that a scheduled move may have `[s]`.
    pub schedule_advance_max_s: f64,
    /// Longest validity of a scheduled trim that is accepted `[s]`.
    pub schedule_validity_max_s: f64,
    /// Time to stop for a pause and to get going again `[s]`.
    pub pause_ramp_s: f64,
    /// Time that homing takes `[s]`.
    pub homing_s: f64,
    /// How near the set-point counts as reached `[K]`.
    pub reached_band_k: f64,
}

/// Set-points and switches that the file controls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sliced {
    /// Hot end set-point of the file.
    pub hotend: Celsius,
    /// Bed set-point of the file.
    pub bed: Celsius,
    /// Part fan `[0, 1]`.
    pub fan: f64,
    /// Pressure advance `[s]`.
    pub advance_s: f64,
    /// Path speed factor of the file (`M220`) `[-]`.
    pub speed_factor: f64,
    /// Filament factor of the file (`M221`) `[-]`.
    pub flow_factor: f64,
}

impl Sliced {
    /// Everything off.
    pub const OFF: Self = Self {
        hotend: Celsius(0.0),
        bed: Celsius(0.0),
        fan: 0.0,
        advance_s: 0.0,
        speed_factor: 1.0,
        flow_factor: 1.0,
    };
}

/// What the machine must know of the world around it in one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surroundings {
    /// Trims in force.
    pub trims: Trims,
    /// Lowest speed that a move's own trim may plan it at `[-]`; `None` where what is attached to moves does not act.
    pub slowest_attached: Option<f64>,
    /// A pause is asked for.
    pub hold: bool,
    /// Hot end as the firmware reads it.
    pub hotend: Celsius,
    /// Bed as the firmware reads it.
    pub bed: Celsius,
}

/// Motion over one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Motion {
    /// Filament asked of the drive.
    pub feed: Feed,
    /// Trims that count for the current move.
    pub trims: Option<Trims>,
    /// Tool speed along its path `[m/s]`, trim included.
    pub path_speed_m_s: f64,
    /// Commanded velocity of the tool `[m/s]`: mean over the step, so that a corner's jump is spread over one.
    pub velocity_m_s: [f64; 3],
    /// Axes X, Y, Z that begin to home in this step.
    pub homing: [bool; 3],
    /// Speed at this point as it is planned, by the move's own trim too `[m/s]`.
    pub planned_speed_m_s: f64,
    /// The file's own speed at this point, without any trim `[m/s]`.
    pub sliced_speed_m_s: f64,
}
