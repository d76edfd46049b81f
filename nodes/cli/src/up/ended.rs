//! How a print ended, and what the truth had come to by then.

use printer_sim::score::Integrals;

/// How a print ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ended {
    /// The file has ended.
    Done,
    /// The job was given up.
    Failed,
    /// A person stopped the print (`fdm stop`, `fdm estop`, the printer's own stop input).
    Stopped,
    /// A person ended the graph.
    Interrupted,
    /// The printer went silent.
    Lost,
}

/// What the truth said at chosen moments.
#[derive(Debug, Clone, Copy, Default)]
pub struct Marks {
    /// Two seconds after the first onset.
    pub settled: Option<Integrals>,
    /// Last.
    pub last: Integrals,
    /// Time of the last `[s]`: simulated, or on the host's clock since the first.
    pub last_s: f64,
    /// What the host's clock showed first `[s]`; 0 of simulated time.
    pub begin_s: Option<f64>,
}
