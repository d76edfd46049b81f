//! Commands: what may be corrected, within what limits, for how long.
//!
//! The same code stands in the supervisor's gate, in a bridge and in the simulator. Every correction is a trim on
//! the slicer's own values with a validity time; when it lapses the printer is back at the slicer's values.
//!
//! | part | what |
//! |---|---|
//! | [`Limits`] | range, slew and validity of trims, the ramp back to the slicer's values |
//! | [`Gate`] | one publisher at a time, rising sequence, validity from the time of receipt; a permit's from its stamp |
//! | [`DeadMan`] | what a printer does with permits, and without them |
//! | [`MotionTrim`] [`Scheduled`] | trims attached to a coming move, and as they are sent |
//! | [`ScheduleGate`] | whose scheduled trims count |
//! | [`AdvanceHandover`] | how the pressure advance passes from file to permit and back without a jump |
//! | [`EstimateHealth`] [`ControlHealth`] | what estimator and controller say of their own work |

mod dead_man;
mod gate;
mod handover;
mod health;
mod limits;
mod schedule;

pub use dead_man::{DeadMan, DeadManParams, InForce, OnLoss, RawDeadManParams};
pub use gate::{Dated, Gate, Refusal, Refusals};
pub use handover::{AdvanceHandover, AdvanceOf};
pub use health::{ControlHealth, EstimateHealth};
pub use limits::{Changed, Clamped, Limits, NotFinite, RawLimits};
pub use schedule::{AdvanceLaw, MotionTrim, ScheduleGate, Scheduled};

use crate::units::Seconds;

/// Corrections on the slicer's own values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trims {
    /// Filament per path length relative to the slicer's `[-]` (what `M221` scales).
    pub flow: f64,
    /// Path speed relative to the slicer's `[-]` (what `M220` scales).
    pub speed: f64,
    /// Offset on the file's hot end set-point `[K]`.
    pub setpoint_offset_k: f64,
    /// Pressure advance `[s]`; `None` keeps the file's own.
    pub advance_s: Option<f64>,
    /// Share of the motor's feed that is lost in the drive gear `[-]`, to be made up for; `None` leaves the
    /// extruder loop open. A native host closes its encoder loop around this value, others divide the feed by
    /// one minus it.
    pub slip: Option<f64>,
}

impl Trims {
    /// The slicer's own values.
    pub const NEUTRAL: Self =
        Self { flow: 1.0, speed: 1.0, setpoint_offset_k: 0.0, advance_s: None, slip: None };

    /// Whether every value is finite. A trim that is not is refused whole, never mended.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        [
            self.flow,
            self.speed,
            self.setpoint_offset_k,
            self.advance_s.unwrap_or(0.0),
            self.slip.unwrap_or(0.0),
        ]
        .iter()
        .all(|value| value.is_finite())
    }
}

/// Mode of the safety supervisor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Mode {
    /// Starting; nothing is sent.
    Init = 0,
    /// Watches and publishes, sends no correction.
    Observe = 1,
    /// Corrections wait for approval.
    Advise = 2,
    /// Corrections are sent.
    Act = 3,
    /// Corrections ramp back to the slicer's values; the print goes on.
    Degraded = 4,
    /// Firmware pause and park.
    Paused = 5,
    /// Heaters off, motion stopped; latched.
    SafeOff = 6,
    /// Emergency stop, mains relay open; latched.
    Estop = 7,
}

/// What the supervisor asks the printer to do beyond trims.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum Request {
    /// Print on.
    Run = 0,
    /// Pause motion and park; heaters held.
    Pause = 1,
    /// Pause with the hot end at standby.
    Standby = 2,
    /// Heater targets to zero, motion stopped.
    HeatersOff = 3,
    /// As `HeatersOff`, and the mains relay opened.
    EmergencyStop = 4,
}

/// A controller's wish.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// Random id of the publisher's run.
    pub session: u64,
    /// Counts up within a session.
    pub sequence: u64,
    /// How long the command counts after receipt.
    pub validity: Seconds,
    /// The wished corrections.
    pub trims: Trims,
}

/// What the supervisor allows now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Permit {
    /// Random id of the supervisor's run.
    pub session: u64,
    /// Counts up within a session.
    pub sequence: u64,
    /// How long the permit counts: from its stamp, and never longer than that after receipt ([`Permit::arrived`]).
    pub validity: Seconds,
    /// Mode of the supervisor.
    pub mode: Mode,
    /// Demand beyond trims.
    pub request: Request,
    /// The allowed corrections.
    pub trims: Trims,
}

impl Permit {
    /// The permit with what is left of its validity, `age` after its stamp; `None` where nothing is left. A correction
    /// outlives its stamp by no more than its validity, however long the permit was on its way. A demand keeps its own
    /// whatever its age, and a validity that is no time is the [`Gate`]'s to refuse.
    #[must_use]
    pub fn arrived(self, age: Seconds) -> Option<Self> {
        let timed = self.validity.0.is_finite() && self.validity.0 > 0.0;
        if self.request != Request::Run || !timed {
            return Some(self);
        }
        let left = Seconds(self.validity.0 - age.0.max(0.0));
        (left.0 > 0.0).then_some(Self { validity: left, ..self })
    }
}
