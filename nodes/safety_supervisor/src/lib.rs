//! Brain of the safety supervisor: gates every command, trips, latches.
//!
//! Of `models` it uses commands, units, parameter checks and job phases alone: no estimator, no controller, no
//! plant model, so that an error there is not repeated here. Its own checks carry their own constants.
//!
//! While it is active none of its parameters may change, not even to the tighter side. The limits were tested as a set
//! (`faults.md`), a check compares what it has seen over minutes with them, and a tighter one may end a sound print at
//! once. Who changes one deactivates the supervisor first: its last permit carries the slicer's own values, the printer's
//! dead-man stands in, and the checks start anew with limits that were checked as a whole.
//!
//! ```text
//!  INIT -> OBSERVE (default) -> ADVISE | ACT        as set by a person
//!             any of them    -> DEGRADED            a cause holds: trims ramp to neutral, the print goes on
//!             any of them    -> PAUSED              once per cause; ends with resume: homed, hot, filament present
//!             any of them    -> SAFE_OFF -> ESTOP   latched; end with acknowledge, the cause gone
//! ```
//!
//! | part | what |
//! |---|---|
//! | [`event`] | what goes in and comes out |
//! | [`supervisor`] | [`Supervisor`]: takes events, yields permits |
//! | [`modes`] | the mode machine |
//! | [`cause`] | why it acted, and what a person should do |
//! | [`checks`] | one fault, one file |
//! | [`envelope`] | commands: session, order, age, range, slew |
//! | [`schedule`] | trims of coming moves: the same for what is attached to a move |
//! | [`attention`] | soft and hard states of the fused confidence |
//! | [`params`] | every number |

#![forbid(unsafe_code)]

pub mod attention;
pub mod cause;
pub mod checks;
#[cfg(feature = "ros")]
#[doc(hidden)] // for `fdm replay`, which reads and says what the node does
pub mod convert;
pub mod envelope;
pub mod event;
pub mod modes;
#[cfg(feature = "ros")]
pub mod node;
pub mod params;
pub mod schedule;
pub mod supervisor;

pub use cause::{Cause, Reaction};
pub use event::{
    Decision, Defect, Event, Evidence, Operator, Output, PrinterReport, SafetyState, Stream, VisionReport,
    What, Worker,
};
pub use modes::{Latch, Standing};
pub use params::Params;
pub use supervisor::Supervisor;
