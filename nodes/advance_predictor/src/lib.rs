//! Brain of the advance predictor: `K_A` for what is printed, and turns that the buffer does not show yet.

#![forbid(unsafe_code)]

pub mod compensation;
pub mod network;
#[cfg(feature = "ros")]
pub mod node;
pub mod params;

pub use params::Params;
