//! Brain and drivers of the thermistors: raw reports in, checked samples or counted refusals out.
//!
//! What a firmware's table gives for a broken circuit passes: it is evidence for the supervisor (S1). Refused is
//! what no table can give, what is not finite, and what comes late, twice or out of order.

#![forbid(unsafe_code)]

pub mod channel;
#[cfg(feature = "ros")]
mod convert;
#[cfg(feature = "ros")]
pub mod node;
pub mod params;
pub mod serial_line;

pub use channel::{Channel, Refusal, Refusals, Sample};
pub use params::{Driver, Params};
