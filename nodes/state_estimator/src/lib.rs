//! Estimates what no sensor of the printer sees: nozzle temperature, outlet flow, slip and bead gain.
//!
//! | module | what |
//! |---|---|
//! | [`engine`] | the form of the filter behind one parameter, apart from any model |
//! | [`ukf`] [`square_root`] [`extended`] | the forms |
//! | [`printer_model`] | six states and three channels of the printer (model book 1.2, 1.5) |
//! | [`params`] | `config/state_estimator.param.yaml` |
//!
//! The filter is brought to the newest status of the printer at every tick, since only there the motor's count is
//! known; late samples are compared with what was commanded at their own stamps. Slip and gain are learned while
//! road is deposited. Nothing that is refused, rejected or reset passes unseen: an [`Estimate`] carries the counts.

#![forbid(unsafe_code)]

mod adaptation;
mod channel;
#[cfg(feature = "ros")]
#[doc(hidden)] // for `fdm replay`, which reads and says what the node does
pub mod convert;
pub mod engine;
mod estimator;
pub mod extended;
mod filter;
mod health;
mod history;
mod input;
mod intervals;
pub mod live;
mod measurement;
mod melt_lag;
#[cfg(feature = "ros")]
pub mod node;
#[cfg(feature = "ros")]
mod pace;
pub mod params;
pub mod printer_model;
mod small;
pub mod square_root;
pub mod ukf;

pub use channel::{CHANNELS, Channel, WINDOW, Window};
pub use estimator::{Estimate, Estimator};
pub use input::{Event, Refusals, Refused};
pub use params::Params;
pub use printer_model::{PrinterModel, Setting, State, state};
