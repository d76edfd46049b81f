//! Brain and drivers of the filament encoder: counts in, checked positions or counted refusals out.

#![forbid(unsafe_code)]

#[cfg(feature = "ros")]
mod convert;
pub mod encoder;
#[cfg(test)]
mod live_tests;
#[cfg(feature = "ros")]
pub mod node;
pub mod params;
pub mod serial_line;

pub use encoder::{Encoder, Refusal, Refusals, Sample};
pub use params::{Driver, Params};
