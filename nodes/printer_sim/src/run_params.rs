//! The `run` block: what the node prints, and how fast.

use models::params::{ParamError, in_range};
use serde::Deserialize;
use std::path::PathBuf;

/// What the simulated machine does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProcessKind {
    /// Extrudes filament as a G-code file says.
    #[default]
    Fdm,
    /// Lays a wall of metal wire drop by drop: [`crate::wire`].
    Wire,
}

/// The kind of process alone, whatever else stands in its `run` block.
#[derive(Debug, Clone, Copy, Deserialize)]
pub struct Chosen {
    /// Which process.
    #[serde(default)]
    pub process: ProcessKind,
}

/// What is printed and how fast. Built only from a valid [`RawRun`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawRun")]
pub struct RunParams(RawRun);

impl std::ops::Deref for RunParams {
    type Target = RawRun;
    fn deref(&self) -> &RawRun {
        &self.0
    }
}

/// The `run` block as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawRun {
    /// Which process; of the others the `run` block is another one.
    #[serde(default)]
    pub process: ProcessKind,
    /// File to print.
    pub gcode: PathBuf,
    /// Print the first layers only `[-]`; 0 for all.
    pub layers: u32,
    /// Start with hot end and bed at the file's set-points.
    pub warm: bool,
    /// Scenario file; empty for none.
    pub scenario: PathBuf,
    /// Seed of all noise.
    pub seed: u64,
    /// Simulated over wall time `[-]`.
    pub speed: f64,
    /// Stamps are of the host's clock, as a real printer's, and nothing is told on `/clock`; needs a speed of 1.
    pub host_clock: bool,
    /// The material file's set-points instead of the G-code file's.
    pub material_set_points: bool,
    /// Text of the configuration of the whole graph; empty for this node's own.
    pub config_file: PathBuf,
    /// Serve `printer_sim/inject_fault`.
    pub allow_fault_injection: bool,
}

impl TryFrom<RawRun> for RunParams {
    type Error = ParamError;
    fn try_from(raw: RawRun) -> Result<Self, ParamError> {
        in_range("speed", raw.speed, "-", (0.1, 20.0))?;
        if raw.host_clock {
            in_range("speed beside host_clock", raw.speed, "-", (1.0, 1.0))?;
        }
        Ok(Self(raw))
    }
}
