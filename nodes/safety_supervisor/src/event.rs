//! What goes into the supervisor and what comes out of it.

use models::command::{Command, ControlHealth, EstimateHealth, Mode, Permit, Refusal, Trims};
use models::status::{JobPhase, PrinterStatus};
use models::units::{Celsius, Seconds};

use crate::attention::Level;
use crate::cause::Cause;

mod evidence;
mod stream;
mod vision;

pub use evidence::Evidence;
pub use stream::{Stream, Worker};
pub use vision::{Defect, VisionReport};

/// What a person asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Operator {
    /// Pause the job.
    Pause,
    /// End a pause.
    Resume,
    /// Heaters off, job stopped.
    Stop,
    /// Emergency stop.
    Estop,
    /// End a latched mode whose cause is gone.
    Acknowledge,
    /// Set the mode: observe, advise or act.
    SetMode(Mode),
    /// Approve the correction that is waiting in advise.
    Approve,
}

/// The part of the printer's state that the supervisor judges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrinterReport {
    /// Time of validity on the node's clock.
    pub stamp: Seconds,
    /// Where the job stands.
    pub phase: JobPhase,
    /// Layer from 0, where it is known.
    pub layer: Option<u32>,
    /// Filament the motor was told to push since start `[m]`.
    pub motor_position_m: f64,
    /// Filament wanted since start `[m]`.
    pub wanted_position_m: f64,
    /// Hot end heater duty `[0, 1]`.
    pub hotend_duty: f64,
    /// Bed heater duty `[0, 1]`.
    pub bed_duty: f64,
    /// Hot end set-point in force.
    pub hotend_target: Celsius,
    /// Hot end set-point of the file.
    pub hotend_sliced_target: Celsius,
    /// Bed set-point in force.
    pub bed_target: Celsius,
    /// Part fan `[0, 1]`.
    pub fan: f64,
    /// Trims in force.
    pub trims: Trims,
    /// Path speed `[m/s]`.
    pub path_speed_m_s: f64,
    /// Run-out switch; `None` where none is fitted.
    pub filament_present: Option<bool>,
    /// All axes know their place.
    pub homed: bool,
    /// The mains relay feeds the heaters.
    pub mains_on: bool,
    /// Revolutions of the part fan `[1/s]`; `None` where it has no tachometer.
    pub part_fan_speed_1_s: Option<f64>,
    /// The stop contact is open; `None` where none is fitted.
    pub stop_input: Option<bool>,
}

impl From<&PrinterStatus> for PrinterReport {
    fn from(status: &PrinterStatus) -> Self {
        Self {
            stamp: status.stamp,
            phase: status.phase,
            layer: status.layer,
            motor_position_m: status.motor_position_m,
            wanted_position_m: status.wanted_position_m,
            hotend_duty: status.hotend_duty,
            bed_duty: status.bed_duty,
            hotend_target: status.hotend_target,
            hotend_sliced_target: status.hotend_sliced_target,
            bed_target: status.bed_target,
            fan: status.fan,
            trims: status.trims,
            path_speed_m_s: status.path_speed_m_s,
            filament_present: status.filament_present,
            homed: status.homed,
            mains_on: status.mains_on,
            part_fan_speed_1_s: status.part_fan_speed_1_s,
            stop_input: status.stop_input,
        }
    }
}

/// What goes in.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// Hot end temperature.
    Hotend {
        /// Time of measurement on the node's clock.
        stamp: Seconds,
        /// Temperature.
        temp: Celsius,
    },
    /// Bed temperature.
    Bed {
        /// Time of measurement on the node's clock.
        stamp: Seconds,
        /// Temperature.
        temp: Celsius,
    },
    /// Filament encoder.
    Encoder {
        /// Time of measurement on the node's clock.
        stamp: Seconds,
        /// Filament seen since start `[m]`.
        position_m: f64,
    },
    /// Printer state.
    Printer(PrinterReport),
    /// A controller's wish.
    Command(Command),
    /// The estimator has done work.
    EstimateHeartbeat {
        /// Time of validity on the node's clock.
        stamp: Seconds,
    },
    /// What the estimator says of its own work, beside every estimate.
    EstimateHealth(EstimateHealth),
    /// What the controller says of its own work, beside every wish.
    ControlHealth(ControlHealth),
    /// Accelerations of the tool, evenly spaced.
    Imu {
        /// Time of the first sample on the node's clock.
        first: Seconds,
        /// Time between two samples.
        period: Seconds,
        /// Samples, gravity included `[m/s2]`.
        samples: Vec<[f64; 3]>,
    },
    /// What one frame says.
    Vision(VisionReport),
    /// A person asks.
    Operator(Operator),
    /// Somebody else publishes permits; the printer believes one alone, which may not be this one.
    RivalPermit,
    /// A second process publishes a stream whose owner still does; what it said is refused.
    RivalSample,
    /// The heart of a process was heard.
    Beat {
        /// Whose.
        worker: Worker,
        /// Units of work that it has done since its start.
        work: u64,
    },
    /// All hearts that could be heard were told, as every [`LOOK_S`](crate::checks::hearts::LOOK_S).
    Look,
    /// The shell refused a value of this stream: NaN, out of range or stale.
    Refused {
        /// Whose value it was.
        stream: Stream,
    },
    /// Time goes on, 50 times a second.
    Tick {
        /// The node's clock.
        now: Seconds,
    },
}

/// What the supervisor decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// The mode changed.
    ModeChanged,
    /// The cause of the mode changed.
    CauseChanged,
    /// Another cause was found beside the one that the mode rests on.
    AlsoRaised,
    /// What stood when the former run ended still stands.
    Remembered,
    /// A command lay outside of its limits and was clamped.
    CommandClamped,
    /// A command was refused.
    CommandRefused(Refusal),
    /// A person's request was carried out.
    Granted(Operator),
    /// A person's request was refused.
    Denied(Operator),
    /// An impulse at the tool that no move commands; the camera decides what came of it.
    Impulse,
    /// The part fan turns slower than told, which takes no correction back.
    PartFanSlow,
    /// The supervisor itself stood still; the silence of others in the meantime is not counted.
    StoodStill,
}

/// One decision, for the log of events.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decision {
    /// What.
    pub what: What,
    /// Why, for people.
    pub why: &'static str,
    /// The cause that `why` is the text of or speaks of, and the number it rests on.
    pub cause: Option<(Cause, Option<Evidence>)>,
    /// Mode before.
    pub before: Mode,
    /// Mode after.
    pub after: Mode,
}

impl Decision {
    /// Why, of a request that was carried out at once.
    pub const ON_REQUEST: &'static str = "on request";
}

/// The supervisor's state, for people and for `safety/state`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SafetyState {
    /// Mode in force.
    pub mode: Mode,
    /// Mode as set by a person.
    pub set_mode: Mode,
    /// Why the mode is not the one that was set.
    pub cause: Option<Cause>,
    /// The number that the cause rested on when it was found.
    pub evidence: Option<Evidence>,
    /// Since when the mode is in force.
    pub since: Seconds,
    /// What a person should do; empty if nothing.
    pub what_to_do: &'static str,
    /// Attention the print needs.
    pub attention: Level,
    /// Refused values of all streams so far.
    pub refused_values: u64,
    /// Refused commands so far.
    pub refused_commands: u64,
    /// Commands so far that lay outside of their limits.
    pub clamped_commands: u64,
    /// Trims of coming moves so far: sent on.
    pub scheduled: u64,
    /// Trims of coming moves so far: refused.
    pub refused_schedule: u64,
    /// Trims of coming moves so far: outside of their limits.
    pub clamped_schedule: u64,
    /// Impulses at the tool so far.
    pub impulses: u64,
    /// Whether the part fan turns slower than told.
    pub part_fan_slow: bool,
    /// Power balance of the hot end `[W]`, positive for heat that nobody ordered.
    pub hotend_excess_w: f64,
    /// Power balance of the bed `[W]`, positive for heat that nobody ordered.
    pub bed_excess_w: f64,
    /// How far the hot end's reading seems to have drifted from its block `[K]`.
    pub drift_k: f64,
    /// Slip over the encoder check's window `[-]`.
    pub slip: Option<f64>,
}

/// What comes out.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// What the printer may do now.
    pub permit: Permit,
    /// State to publish.
    pub state: SafetyState,
    /// Decisions since the last output.
    pub events: Vec<Decision>,
}
