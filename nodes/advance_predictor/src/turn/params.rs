//! Settings of the foresight: block `turn` of `config/advance_predictor.param.yaml`.

use models::params::{ParamError, in_range};
use serde::Deserialize;

/// What counts as a turn, how far is looked ahead, what is remembered. Built only from a valid [`RawTurnParams`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawTurnParams")]
pub struct TurnParams(RawTurnParams);

impl std::ops::Deref for TurnParams {
    type Target = RawTurnParams;
    fn deref(&self) -> &RawTurnParams {
        &self.0
    }
}

/// The block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTurnParams {
    /// A sharper change of direction is a turn `[rad]`.
    pub threshold_rad: f64,
    /// Way within which a turn is to be foreseen `[m]`.
    pub horizon_m: f64,
    /// Time within which a turn is to be foreseen, where that is farther `[s]`.
    pub horizon_s: f64,
    /// Points of the path that are remembered.
    pub memory_points: u32,
    /// Distance within which a remembered point is the same `[m]`.
    pub memory_reach_m: f64,
    /// Difference of direction within which it is.
    pub memory_turn_rad: f64,
    /// Newest points that are not matched with themselves.
    pub memory_gap: u32,
}

impl TryFrom<RawTurnParams> for TurnParams {
    type Error = ParamError;

    fn try_from(raw: RawTurnParams) -> Result<Self, ParamError> {
        in_range("turn.threshold_rad", raw.threshold_rad, "rad", (0.05, 3.0))?;
        in_range("turn.horizon_m", raw.horizon_m, "m", (1e-4, 0.1))?;
        in_range("turn.horizon_s", raw.horizon_s, "s", (1e-3, 5.0))?;
        in_range("turn.memory_points", f64::from(raw.memory_points), "-", (16.0, 1e6))?;
        in_range("turn.memory_reach_m", raw.memory_reach_m, "m", (1e-5, 1e-2))?;
        in_range("turn.memory_turn_rad", raw.memory_turn_rad, "rad", (0.01, 3.2))?;
        in_range("turn.memory_gap", f64::from(raw.memory_gap), "-", (2.0, 1e4))?;
        Ok(Self(raw))
    }
}
