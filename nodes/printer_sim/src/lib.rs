//! A simulated printer: executes real slicer files on a plant that knows its own truth.
//!
//! ```text
//! G-code -> Job (models) -> Executor -> Extruder drive -> Plant -> sensors -> outputs
//!                              ^            ^               ^
//!                            trims        trims           faults
//!                              +--- DeadMan <--- permit     +--- Scenario
//! ```
//! One call of [`Simulator::step`] advances everything by one millisecond or less. What a real printer would show
//! comes out of [`Simulator::poll`]; the truth is in [`Simulator::truth`], for reports and tests alone.
//!
//! The plant's parameters (`config/plants/`) deviate from those the estimator and the controller use
//! (`config/printers/`, `config/materials/`) as section 1.5 of the model book says. All its figures are simulated.

#![forbid(unsafe_code)]

pub mod camera;
#[cfg(feature = "ros")]
#[doc(hidden)] // for `fdm sim --bag`, which says what the node does
pub mod convert;
pub mod drive;
pub mod executor;
pub mod fan;
pub mod faults;
mod heaters;
pub mod imu;
pub mod job;
#[cfg(feature = "ros")]
pub mod load;
#[cfg(feature = "ros")]
pub mod node;
pub mod output;
pub mod pace;
pub mod params;
pub mod plant;
pub mod run_params;
pub mod scenario;
pub mod score;
pub mod sensors;
pub mod simulator;
pub mod sliced;
pub mod structure;
pub mod toolhead;
pub mod wire;

/// A demand, or a trim of a coming move, with an older stamp, or one as far ahead, is refused: four times a permit's validity.
pub const PERMIT_STAMP_LIMIT: models::units::Seconds = models::units::Seconds(1.0);

pub use output::{Output, Truth};
pub use params::Params;
pub use scenario::Scenario;
pub use simulator::{JobSource, Simulator, Unscheduled};
