//! Numbers of streams, filament, attention and modes.

use models::params::{ParamError, in_range, ordered};
use models::units::Seconds;
use serde::Deserialize;

use super::thermal::count;
use crate::checks::bad_values::COUNT_MAX;

/// Passes an absent value, or one inside the range.
fn optional(name: &'static str, value: Option<f64>, range: (f64, f64)) -> Result<Option<f64>, ParamError> {
    value.map(|value| in_range(name, value, "s", range)).transpose()
}

/// S7: ages of a stream; an absent step is never taken.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawStaleParams")]
pub struct StaleParams {
    /// Age that degrades `[s]`.
    pub degraded_s: f64,
    /// Age that pauses `[s]`.
    pub pause_s: Option<f64>,
    /// Age that switches the heaters off `[s]`.
    pub safe_off_s: Option<f64>,
}

impl StaleParams {
    /// Oldest stamp that is taken. Deadlines run on receipts: what comes late, but before its absence would pause the
    /// print, is heard.
    #[must_use]
    pub fn oldest_stamp(&self) -> Seconds {
        Seconds(self.pause_s.unwrap_or(self.degraded_s))
    }
}

/// As [`StaleParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawStaleParams {
    /// Age that degrades `[s]`.
    pub degraded_s: f64,
    /// Age that pauses `[s]`.
    pub pause_s: Option<f64>,
    /// Age that switches the heaters off `[s]`.
    pub safe_off_s: Option<f64>,
}

impl TryFrom<RawStaleParams> for StaleParams {
    type Error = ParamError;

    fn try_from(raw: RawStaleParams) -> Result<Self, ParamError> {
        let steps =
            [("degraded_s", Some(raw.degraded_s)), ("pause_s", raw.pause_s), ("safe_off_s", raw.safe_off_s)];
        let taken: Vec<_> = steps.into_iter().filter_map(|(name, age_s)| Some((name, age_s?))).collect();
        taken.windows(2).try_for_each(|pair| ordered(pair[0], pair[1]))?;
        Ok(Self {
            degraded_s: in_range("degraded_s", raw.degraded_s, "s", (0.05, 60.0))?,
            pause_s: optional("pause_s", raw.pause_s, (0.05, 60.0))?,
            safe_off_s: optional("safe_off_s", raw.safe_off_s, (0.05, 60.0))?,
        })
    }
}

/// So many occurrences within a span.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawBurstParams")]
pub struct BurstParams {
    /// Occurrences `[-]`.
    pub count: usize,
    /// Span `[s]`.
    pub span_s: f64,
}

/// As [`BurstParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawBurstParams {
    /// Occurrences `[-]`.
    pub count: usize,
    /// Span `[s]`.
    pub span_s: f64,
}

impl TryFrom<RawBurstParams> for BurstParams {
    type Error = ParamError;

    fn try_from(raw: RawBurstParams) -> Result<Self, ParamError> {
        Ok(Self {
            count: in_range("count", raw.count as f64, "-", (1.0, COUNT_MAX as f64)).map(|_| raw.count)?,
            span_s: in_range("span_s", raw.span_s, "s", (0.01, 60.0))?,
        })
    }
}

/// P6, P7: encoder against motor.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawFilamentParams")]
pub struct FilamentParams {
    /// Way of the motor over which slip is taken `[m]`.
    pub window_m: f64,
    /// Play of drive gear and tube `[m]`.
    pub play_m: f64,
    /// Slip that pauses `[-]`.
    pub slip_max: f64,
    /// What an encoder may read beyond the motor's way `[-]`.
    pub surplus_max: f64,
}

/// As [`FilamentParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawFilamentParams {
    /// Way of the motor over which slip is taken `[m]`.
    pub window_m: f64,
    /// Play of drive gear and tube `[m]`.
    pub play_m: f64,
    /// Slip that pauses `[-]`.
    pub slip_max: f64,
    /// What an encoder may read beyond the motor's way `[-]`.
    pub surplus_max: f64,
}

impl TryFrom<RawFilamentParams> for FilamentParams {
    type Error = ParamError;

    fn try_from(raw: RawFilamentParams) -> Result<Self, ParamError> {
        Ok(Self {
            window_m: in_range("window_m", raw.window_m, "m", (0.001, 0.1))?,
            play_m: in_range("play_m", raw.play_m, "m", (0.0, 0.005))?,
            slip_max: in_range("slip_max", raw.slip_max, "-", (0.05, 0.99))?,
            surplus_max: in_range("surplus_max", raw.surplus_max, "-", (0.05, 10.0))?,
        })
    }
}

/// P7: run-out switch.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawRunOutParams")]
pub struct RunOutParams {
    /// How long the switch must see nothing `[s]`.
    pub debounce_s: f64,
}

/// As [`RunOutParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawRunOutParams {
    /// How long the switch must see nothing `[s]`.
    pub debounce_s: f64,
}

impl TryFrom<RawRunOutParams> for RunOutParams {
    type Error = ParamError;

    fn try_from(raw: RawRunOutParams) -> Result<Self, ParamError> {
        Ok(Self { debounce_s: in_range("debounce_s", raw.debounce_s, "s", (0.0, 5.0))? })
    }
}

/// Model book 1.6: soft and hard states.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawAttentionParams")]
pub struct AttentionParams {
    /// Soft threshold `[-]`.
    pub soft: f64,
    /// Hard threshold `[-]`.
    pub hard: f64,
    /// Below the soft threshold by this much is calm `[-]`.
    pub hysteresis: f64,
    /// In a row until soft `[-]`.
    pub n_soft: u32,
    /// In a row until hard `[-]`.
    pub n_hard: u32,
    /// In a row until soft ends `[-]`.
    pub n_off: u32,
}

/// As [`AttentionParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawAttentionParams {
    /// Soft threshold `[-]`.
    pub soft: f64,
    /// Hard threshold `[-]`.
    pub hard: f64,
    /// Below the soft threshold by this much is calm `[-]`.
    pub hysteresis: f64,
    /// In a row until soft `[-]`.
    pub n_soft: u32,
    /// In a row until hard `[-]`.
    pub n_hard: u32,
    /// In a row until soft ends `[-]`.
    pub n_off: u32,
}

impl TryFrom<RawAttentionParams> for AttentionParams {
    type Error = ParamError;

    fn try_from(raw: RawAttentionParams) -> Result<Self, ParamError> {
        ordered(("soft", raw.soft), ("hard", raw.hard))?;
        Ok(Self {
            soft: in_range("soft", raw.soft, "-", (0.0, 1.0))?,
            hard: in_range("hard", raw.hard, "-", (0.0, 1.0))?,
            // A level that no confidence lies below would never let attention go.
            hysteresis: in_range("hysteresis", raw.hysteresis, "-", (0.0, raw.soft))?,
            n_soft: count("n_soft", raw.n_soft, 100)?,
            n_hard: count("n_hard", raw.n_hard, 100)?,
            n_off: count("n_off", raw.n_off, 100)?,
        })
    }
}

/// Times of the mode machine.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawModeParams")]
pub struct ModeParams {
    /// Ramp back to the slicer's values `[s]`.
    pub ramp_s: f64,
    /// How long a cause must be gone until the set mode returns `[s]`.
    pub hold_s: f64,
    /// Pause until the hot end goes to standby `[s]`.
    pub standby_after_s: f64,
    /// Longest pause; then the heaters go off `[s]`.
    pub pause_max_s: f64,
    /// How far below its set-point the hot end may be at a resume `[K]`.
    pub hot_margin_k: f64,
    /// How long the printer may be paused without our request until we take the pause over `[s]`.
    pub adopt_s: f64,
    /// How long it may take to go on after a resume `[s]`.
    pub take_up_s: f64,
    /// Longest wait for hot end and printer after the start `[s]`.
    pub startup_s: f64,
    /// Gap of the tick from which the supervisor itself stood still `[s]`.
    pub stall_s: f64,
    /// After a stall no other one is forgiven for so long `[s]`.
    pub stall_forgiven_s: f64,
    /// Corrections that were taken back come back for so long before raised attention holds them `[s]`.
    pub return_s: f64,
    /// Layers after a resume in which the camera pauses nothing for what the pause was for `[-]`.
    pub grace_layers: u32,
}

/// As [`ModeParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawModeParams {
    /// Ramp back to the slicer's values `[s]`.
    pub ramp_s: f64,
    /// How long a cause must be gone until the set mode returns `[s]`.
    pub hold_s: f64,
    /// Pause until the hot end goes to standby `[s]`.
    pub standby_after_s: f64,
    /// Longest pause; then the heaters go off `[s]`.
    pub pause_max_s: f64,
    /// How far below its set-point the hot end may be at a resume `[K]`.
    pub hot_margin_k: f64,
    /// How long the printer may be paused without our request until we take the pause over `[s]`.
    pub adopt_s: f64,
    /// How long it may take to go on after a resume `[s]`.
    pub take_up_s: f64,
    /// Longest wait for hot end and printer after the start `[s]`.
    pub startup_s: f64,
    /// Gap of the tick from which the supervisor itself stood still `[s]`.
    pub stall_s: f64,
    /// After a stall no other one is forgiven for so long `[s]`.
    pub stall_forgiven_s: f64,
    /// Corrections that were taken back come back for so long before raised attention holds them `[s]`.
    pub return_s: f64,
    /// Layers after a resume in which the camera pauses nothing for what the pause was for `[-]`.
    pub grace_layers: u32,
}

impl TryFrom<RawModeParams> for ModeParams {
    type Error = ParamError;

    fn try_from(raw: RawModeParams) -> Result<Self, ParamError> {
        // Corrections that come back meet the slicer's values, not the way to them.
        ordered(("ramp_s", raw.ramp_s), ("hold_s", raw.hold_s))?;
        Ok(Self {
            ramp_s: in_range("ramp_s", raw.ramp_s, "s", (0.05, 2.0))?,
            hold_s: in_range("hold_s", raw.hold_s, "s", (0.0, 60.0))?,
            standby_after_s: in_range("standby_after_s", raw.standby_after_s, "s", (1.0, 3600.0))?,
            pause_max_s: in_range("pause_max_s", raw.pause_max_s, "s", (10.0, 86400.0))?,
            hot_margin_k: in_range("hot_margin_k", raw.hot_margin_k, "K", (0.0, 50.0))?,
            adopt_s: in_range("adopt_s", raw.adopt_s, "s", (0.1, 30.0))?,
            take_up_s: in_range("take_up_s", raw.take_up_s, "s", (0.1, 60.0))?,
            startup_s: in_range("startup_s", raw.startup_s, "s", (0.5, 120.0))?,
            stall_s: in_range("stall_s", raw.stall_s, "s", (0.05, 5.0))?,
            stall_forgiven_s: in_range("stall_forgiven_s", raw.stall_forgiven_s, "s", (0.0, 600.0))?,
            return_s: in_range("return_s", raw.return_s, "s", (0.0, 60.0))?,
            grace_layers: in_range("grace_layers", f64::from(raw.grace_layers), "-", (0.0, 100.0))
                .map(|_| raw.grace_layers)?,
        })
    }
}

#[cfg(test)]
#[path = "rest_tests.rs"]
mod tests;
