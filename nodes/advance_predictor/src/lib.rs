//! Brain of the advance predictor: `K_A` for what is printed, and turns that the buffer does not show yet.
//!
//! | module | what |
//! |---|---|
//! | [`compensation`] | `K_A` by an ensemble inside the hull of its data, by physics outside; data, training, figures |
//! | `speeds` | the lag over the changes of speed that are printed, against the test line's |
//! | [`turn`] | turns by the buffer, by memory of the layers below and by a small network |
//! | [`network`] | the small network itself, its file and its fit |
//! | [`predictor`] | both together, event by event |

#![forbid(unsafe_code)]

pub mod compensation;
#[cfg(feature = "ros")]
#[doc(hidden)] // for `fdm replay`, which reads and says what the node does
pub mod convert;
pub mod network;
#[cfg(feature = "ros")]
pub mod node;
pub mod params;
pub mod predictor;
mod speeds;
pub mod turn;

pub use params::Params;
pub use predictor::{AdvancePredictor, Event, Output};
