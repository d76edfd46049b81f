//! Brain and drivers of the inertial unit: batches of accelerations in, checked and thinned ones or counted refusals
//! out.
//!
//! Nothing passes before the unit has shown, over one window, that it measures gravity in m/s2 along the configured
//! axis at the configured rate (S11); see [`window`]. Saturated samples pass and are counted: a knock saturates.

#![forbid(unsafe_code)]

pub mod accelerometer;
pub mod axis;
#[cfg(feature = "ros")]
mod convert;
#[cfg(test)]
mod live_tests;
#[cfg(feature = "ros")]
pub mod node;
pub mod params;
pub mod scan;
mod thin;
pub mod window;

pub use accelerometer::{Accelerometer, Checked, Refusal, Refusals, Report};
pub use params::{Driver, Params};
pub use thin::Thinned;
