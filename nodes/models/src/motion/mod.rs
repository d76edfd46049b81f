//! From instructions to timed moves: trapezoids under per-axis limits with bounded look-ahead.
//!
//! ```text
//! bytes -> gcode::read (lines) -> gcode::interpret (modal state) -> planner (look-ahead) -> Step
//! ```
//! [`Job`] is that chain as an iterator. SI units throughout.

mod block;
mod job;
mod junction;
mod params;
mod planner;
mod segment;
mod trapezoid;

#[cfg(test)]
mod tests;
#[cfg(test)]
pub(crate) mod tests_support;

pub use job::{Job, Totals};
pub use junction::junction_speed_m_s;
pub use params::{Cornering, Limits, MotionParams, RawMotionParams, ReadParams, axis};
pub use planner::{Planner, Waypoint};
pub use segment::{Action, MoveKind, Role, Segment, Step};
pub use trapezoid::{PathState, Trapezoid};
