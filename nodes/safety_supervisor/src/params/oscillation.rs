//! Numbers of the check on swinging corrections.

use models::params::{ParamError, in_range};
use serde::Deserialize;

use super::BurstParams;

/// K7: turns of the corrections.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawOscillationParams")]
pub struct OscillationParams {
    /// Change of flow from which a change of direction counts `[-]`.
    pub flow: f64,
    /// The same of speed `[-]`.
    pub speed: f64,
    /// The same of the set-point's offset `[K]`.
    pub setpoint_k: f64,
    /// Turns that degrade.
    pub turns: BurstParams,
}

/// As [`OscillationParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawOscillationParams {
    /// Change of flow from which a change of direction counts `[-]`.
    pub flow: f64,
    /// The same of speed `[-]`.
    pub speed: f64,
    /// The same of the set-point's offset `[K]`.
    pub setpoint_k: f64,
    /// Turns that degrade.
    pub turns: BurstParams,
}

impl TryFrom<RawOscillationParams> for OscillationParams {
    type Error = ParamError;

    fn try_from(raw: RawOscillationParams) -> Result<Self, ParamError> {
        Ok(Self {
            flow: in_range("flow", raw.flow, "-", (0.001, 10.0))?,
            speed: in_range("speed", raw.speed, "-", (0.001, 10.0))?,
            setpoint_k: in_range("setpoint_k", raw.setpoint_k, "K", (0.01, 100.0))?,
            turns: raw.turns,
        })
    }
}
