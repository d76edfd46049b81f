//! The `run` block: what the node prints, and how fast.

use models::params::{ParamError, in_range};
use serde::Deserialize;
use std::path::PathBuf;

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
        Ok(Self(raw))
    }
}
