//! Brain of the bridge to a real printer: lines of a firmware in, temperatures, state and questions out. Read only.
//!
//! What Marlin tells over a serial line, and what becomes of the rest of `printer/state`:
//!
//! | known | from |
//! |---|---|
//! | temperatures | `T:` and `B:` of M155 reports and of `ok T:`; as they are, the thermistor node judges them |
//! | targets, duties | the numbers after `/`, and `@:`, `B@:` |
//! | position | M114, asked only while no job is known to run: old Marlins empty their planner for it, which marks a print |
//! | job | M27 and `Done printing file` for prints from the card, `// action:`, fatal errors and restarts |
//! | run-out | `// action:out_of_filament`; whether a switch is fitted is not told |
//!
//! | not known | sent |
//! |---|---|
//! | job before the first word on it, heating before a print | phase idle |
//! | layer, road width and height, run-out switch | flagged as unknown |
//! | line, progress (until the end), path speed and time, feed, motor and wanted filament, fan, advance | 0; not depositing |
//! | trims | neutral: this bridge sets none, and nobody else is asked |
//! | homed | no |
//! | mains relay | closed, while the firmware talks |
//!
//! Where nothing has been heard for [`MarlinParams::stale_after_s`](params::MarlinParams::stale_after_s) no state is
//! sent: old values with new stamps would be a lie. Answers are told by what they say, never by their place: reports
//! come between a question and its `ok` as they like. `ok` only opens the line for the next question.

#![forbid(unsafe_code)]

pub mod asking;
pub mod commands;
#[cfg(feature = "ros")]
mod convert;
pub mod event;
pub mod firmware;
pub mod job;
pub mod line;
pub mod marlin;
#[cfg(feature = "ros")]
pub mod node;
pub mod note;
pub mod params;

pub use event::{Event, Link, Output, Refusals, Report};
pub use marlin::Marlin;
pub use note::{Note, Severity};
pub use params::{Host, Params};
