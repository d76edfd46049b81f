//! Corrects feed, speed, set-point and slip while a print runs, always as trims on the slicer's own values.
//!
//! | module | what |
//! |---|---|
//! | [`qp`] | receding-horizon problem on Clarabel (model book 1.7) |
//! | [`trims`] | integral action on the measured width between solves ([QC] (23)) |
//! | [`reference`] | what the slicer's set-point means for the nozzle |
//! | [`wire`] | profile of the wire process: feed and head speed from layer heights |
//! | [`advance`] | which pressure advance is sent, when it may change, what is learnt of it |
//! | [`params`] | `config/mpc_controller.param.yaml` |
//!
//! A plan is made at every tick; a command leaves with every estimate, since a slip must act within 0.1 s. When an
//! input is too old nothing is sent: the last command lapses and the printer is back at the slicer's values.

#![forbid(unsafe_code)]

pub mod advance;
mod base;
mod catch_up;
mod clog;
mod controller;
#[cfg(feature = "ros")]
#[doc(hidden)] // for `fdm replay`, which reads and says what the node does
pub mod convert;
mod deadband;
mod fallback;
mod flow_error;
mod input;
#[cfg(feature = "ros")]
pub mod node;
mod nominal;
pub mod params;
mod pending;
pub mod qp;
pub mod reference;
mod roads;
mod saturation;
mod shortfall;
mod slowing;
pub mod trims;
pub mod wire;

pub use controller::{Controller, Report};
pub use input::{Coming, Estimate, Event, Refusals, Refused};
pub use params::{Level, Params};
