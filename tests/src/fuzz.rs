//! Bytes that nobody means to send, one function for each way in: what is let through keeps its laws, and nothing
//! panics, hangs or takes memory without bound.
//!
//! Each function is called twice: by libFuzzer, which looks for bytes that reach new code (`tests/fuzz/run.sh`), and by
//! `tests/tests/fuzz.rs`, with seeds and mutations of them, in every run of the tests.
#![allow(
    clippy::unwrap_used,
    reason = "a target panics where a law is broken; its own parameters are the shipped ones"
)]

mod arguments;
mod bag;
mod cdr;
mod cdr_seeds;
mod gcode;
mod gcode_order;
mod jpeg;
mod laws;
pub mod parameters;
mod serial_line;
mod shipped;
mod supervisor;
mod supervisor_print;
mod values;

pub use arguments::arguments;
pub use bag::bag;
pub use cdr::cdr;
pub use gcode::gcode;
pub use gcode_order::gcode_order;
pub use jpeg::jpeg;
pub use parameters::parameters;
pub use serial_line::serial_line;
pub use supervisor::supervisor;

/// A way in.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Its name, of the fuzz target too.
    pub name: &'static str,
    /// What reads the bytes.
    pub run: fn(&[u8]),
    /// Sound bytes, to begin with.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Cases of a bounded run, so many that each target has its share of the time.
    pub cases: u32,
}

/// All of them.
pub const TARGETS: [Target; 9] = [
    Target { name: "arguments", run: arguments, seeds: arguments::seeds, cases: 20_000 },
    Target { name: "bag", run: bag, seeds: bag::seeds, cases: 600 },
    Target { name: "cdr", run: cdr, seeds: cdr_seeds::seeds, cases: 25_000 },
    Target { name: "gcode", run: gcode, seeds: gcode::seeds, cases: 4000 },
    Target { name: "gcode_order", run: gcode_order, seeds: gcode_order::seeds, cases: 50_000 },
    Target { name: "jpeg", run: jpeg, seeds: jpeg::seeds, cases: 30_000 },
    Target { name: "parameters", run: parameters, seeds: parameters::seeds, cases: 1500 },
    Target { name: "serial_line", run: serial_line, seeds: serial_line::seeds, cases: 30_000 },
    Target { name: "supervisor", run: supervisor, seeds: supervisor::seeds, cases: 1200 },
];
