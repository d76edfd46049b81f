//! Numbers of the check on swinging corrections.

use models::params::{ParamError, positive};
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
            flow: positive("flow", raw.flow, "-")?,
            speed: positive("speed", raw.speed, "-")?,
            setpoint_k: positive("setpoint_k", raw.setpoint_k, "K")?,
            turns: raw.turns,
        })
    }
}
