//! What a printer says of itself, whoever drives it: the simulator or a bridge.

use crate::command::Trims;
use crate::units::{Celsius, Seconds};

/// Where a job stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum JobPhase {
    /// Nothing to print.
    Idle = 0,
    /// Homing, heating, waiting for a temperature.
    Preparing = 1,
    /// Moves are executed.
    Printing = 2,
    /// Stopped on request, to be resumed.
    Paused = 3,
    /// The file has ended.
    Done = 4,
    /// Stopped for good.
    Failed = 5,
}

/// The pace a host sets for corrections; see the table of host profiles in `nodes/README.md`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum HostProfile {
    /// The firmware closes the extruder loop at 100 Hz.
    Native = 0,
    /// We stream the file and attach trims to segments.
    Serial = 1,
    /// Moonraker over HTTP: state at 4 Hz, a trim acts 0.5 to 2 s later.
    Moonraker = 2,
    /// `OctoPrint` over HTTP: state at 2 Hz, a trim acts 0.3 to 1 s later.
    Octoprint = 3,
}

impl HostProfile {
    /// Whether trims that are attached to coming moves are executed with them: its corners are planned.
    #[must_use]
    pub const fn executes_schedules(self) -> bool {
        matches!(self, Self::Native | Self::Serial)
    }

    /// Whether a trim of a move that has not begun stands for the one before: a native host plans a move as it begins, others have
    /// sent it on with what it was sent with.
    #[must_use]
    pub const fn takes_trims_anew(self) -> bool {
        matches!(self, Self::Native)
    }
}

/// State of printer and job at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrinterStatus {
    /// Time of validity on the node's clock.
    pub stamp: Seconds,
    /// Where the job stands.
    pub phase: JobPhase,
    /// Who executes trims, and how fast.
    pub host: HostProfile,
    /// Share of the file's filament already commanded `[0, 1]`.
    pub progress: f64,
    /// Layer from 0; `None` before the first layer mark or first extrusion.
    pub layer: Option<u32>,
    /// Line of the G-code file being executed, from 1; 0 before the first.
    pub line: u64,
    /// Commanded tool position in the bed frame `[m]`.
    pub position_m: [f64; 3],
    /// Executed path speed `[m/s]`, speed trim included.
    pub path_speed_m_s: f64,
    /// The planned path speed at this point `[m/s]`, before the speed trim: the slicer's own, or what a trim attached to the
    /// move has made of it.
    pub planned_speed_m_s: f64,
    /// The filament feed at this point at the planned speed `[m/s]`, before every trim in force; negative in a retraction.
    pub planned_feed_m_s: f64,
    /// Filament the extruder motor was told to push since start `[m]`: every trim and compensation included.
    pub motor_position_m: f64,
    /// Filament that ought to have passed the drive gear since start `[m]`: the slicer's times the flow trim plus the
    /// advance displacement, without slip compensation. Where nothing slips the encoder reads the same.
    pub wanted_position_m: f64,
    /// Time along the slicer's own plan `[s]`: advances at the speed trim while moves are executed.
    pub path_time_s: f64,
    /// Whether the move deposits a road: tool and filament both advance.
    pub depositing: bool,
    /// Width of the road the slicer asked for `[m]`; `None` while no road is deposited.
    pub target_width_m: Option<f64>,
    /// Height of the road `[m]`; `None` while no road is deposited.
    pub layer_height_m: Option<f64>,
    /// Hot end set-point in force, offset included.
    pub hotend_target: Celsius,
    /// Hot end set-point of the file.
    pub hotend_sliced_target: Celsius,
    /// Bed set-point in force.
    pub bed_target: Celsius,
    /// Hot end heater duty `[0, 1]`.
    pub hotend_duty: f64,
    /// Bed heater duty `[0, 1]`.
    pub bed_duty: f64,
    /// Part fan `[0, 1]`.
    pub fan: f64,
    /// Trims in force; [`Trims::NEUTRAL`] when the printer runs on the slicer's values.
    pub trims: Trims,
    /// Advance in force `[s]`: the file's own or the commanded one, or between the two while it changes hands.
    pub advance_s: f64,
    /// All axes know their place.
    pub homed: bool,
    /// The mains relay feeds the heaters.
    pub mains_on: bool,
    /// The run-out switch sees filament; `None` where no switch is fitted.
    pub filament_present: Option<bool>,
    /// Revolutions of the part fan `[1/s]`; `None` where it has no tachometer.
    pub part_fan_speed_1_s: Option<f64>,
    /// The stop contact is open: an emergency-stop button pressed, a door open; `None` where none is fitted.
    pub stop_input: Option<bool>,
}
