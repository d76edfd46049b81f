//! Serial lines: a thread that reads and connects again, lines cut from its bytes, a node's end of it.
//!
//! What a line says is for its node: here are bytes between line ends and the time at which they were complete.
//! The port is opened for this process alone. Opening raises DTR, which restarts many printer boards.

mod line;
mod port;
#[cfg(feature = "pty")]
pub mod pty;
mod reader;

pub use line::LineBuffer;
pub use models::params::SerialParams;
pub use port::SerialLine;
pub use reader::{PortEvent, SerialReader};
