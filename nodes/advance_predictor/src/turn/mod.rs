//! Turns foreseen before the buffer shows them (model book 2.5).
//!
//! A firmware knows the next few moves. Where they are short, a turn lies behind the last of them: what is known then is
//! the path so far, and what the path did when it was here on a layer below.

pub mod assess;
mod carried;
pub mod curves;
mod file;
mod memory;
mod params;
mod path;
mod samples;
mod splines;
#[cfg(test)]
pub(crate) mod tests;
pub mod training;
mod walls;
mod watcher;

pub use file::TurnNetwork;
pub use params::{RawTurnParams, TurnParams};
pub use path::Piece;
pub use watcher::{Basis, Foresight, Watcher};
