//! Numbers of the checks of readings and inputs: steps, noise, drift, fan, stop contact.

use models::params::{ParamError, in_range, ordered};
use serde::Deserialize;

use super::thermal::count;
use crate::checks::noise::WINDOW_MAX;

/// S10: a step that no block makes.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JumpParams {
    /// Smallest step `[K]`.
    pub step_k: f64,
    /// Fastest change of a sound reading `[K/s]`.
    pub rate_max_k_s: f64,
    /// Readings in a row that must agree `[-]`.
    pub samples: u32,
    /// Longest time over which a step is judged `[s]`.
    pub gap_max_s: f64,
}

impl JumpParams {
    /// # Errors
    /// A number outside its range.
    pub(super) fn check(&self) -> Result<(), ParamError> {
        in_range("hotend_step.step_k", self.step_k, "K", (2.0, 100.0))?;
        in_range("hotend_step.rate_max_k_s", self.rate_max_k_s, "K/s", (0.1, 50.0))?;
        count("hotend_step.samples", self.samples, 50)?;
        in_range("hotend_step.gap_max_s", self.gap_max_s, "s", (0.2, 10.0)).map(|_| ())
    }
}

/// S4: readings that jump about.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseParams {
    /// Distance from the median of five from which a reading is off `[K]`.
    pub gate_k: f64,
    /// Readings over which the share is taken `[-]`.
    pub window: usize,
    /// Largest share that may be off `[-]`.
    pub share_max: f64,
    /// Newest readings that decide whether fast verdicts wait `[-]`.
    pub suspect_window: usize,
    /// So many of them off make them wait `[-]`.
    pub suspect_count: usize,
}

impl NoiseParams {
    /// # Errors
    /// A number outside its range.
    pub(super) fn check(&self) -> Result<(), ParamError> {
        in_range("noise.gate_k", self.gate_k, "K", (0.01, 100.0))?;
        in_range("noise.share_max", self.share_max, "-", (0.01, 0.9))?;
        for (name, readings) in [("noise.window", self.window), ("noise.suspect_window", self.suspect_window)]
        {
            in_range(name, readings as f64, "-", (1.0, WINDOW_MAX as f64))?;
        }
        // More than there are would never be off.
        let most = self.suspect_window as f64;
        in_range("noise.suspect_count", self.suspect_count as f64, "-", (1.0, most)).map(drop)
    }
}

/// S3: a reading that drifts away from its block.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DriftParams {
    /// Heat capacity of block and nozzle `[J/K]`.
    pub capacity_j_k: f64,
    /// How late the balance is known `[s]`.
    pub lag_s: f64,
    /// Time until the usual power is known `[s]`.
    pub learn_s: f64,
    /// Time over which a small lasting change becomes usual `[s]`.
    pub usual_time_s: f64,
    /// Largest usual power: what errors of the balance's constants and the air come to `[W]`.
    pub usual_max_w: f64,
    /// Largest warming power that counts as steady `[W]`.
    pub steady_w: f64,
    /// Change that is no drift, whatever its cause `[W]`.
    pub allowance_w: f64,
    /// Energy beyond the allowance from which nothing is learnt `[J]`.
    pub doubt_j: f64,
    /// What the hot end feels of the air over what the bed feels of it `[-]`.
    pub air_share: f64,
    /// How far above the air the bed must be to tell of it `[K]`.
    pub bed_above_air_k: f64,
    /// Residual that degrades `[K]`.
    pub degraded_k: f64,
    /// Residual that switches the heaters off `[K]`.
    pub safe_off_k: f64,
}

impl DriftParams {
    /// # Errors
    /// A number outside its range.
    pub(super) fn check(&self) -> Result<(), ParamError> {
        in_range("drift.capacity_j_k", self.capacity_j_k, "J/K", (0.1, 1e5))?;
        in_range("drift.lag_s", self.lag_s, "s", (0.0, 60.0))?;
        in_range("drift.learn_s", self.learn_s, "s", (1.0, 600.0))?;
        in_range("drift.usual_time_s", self.usual_time_s, "s", (10.0, 3600.0))?;
        in_range("drift.usual_max_w", self.usual_max_w, "W", (0.0, 100.0))?;
        in_range("drift.steady_w", self.steady_w, "W", (0.1, 100.0))?;
        in_range("drift.allowance_w", self.allowance_w, "W", (0.1, 100.0))?;
        in_range("drift.doubt_j", self.doubt_j, "J", (0.0, 1000.0))?;
        in_range("drift.air_share", self.air_share, "-", (0.0, 10.0))?;
        in_range("drift.bed_above_air_k", self.bed_above_air_k, "K", (1.0, 100.0))?;
        in_range("drift.degraded_k", self.degraded_k, "K", (0.5, 100.0))?;
        in_range("drift.safe_off_k", self.safe_off_k, "K", (0.5, 100.0))?;
        ordered(("drift.degraded_k", self.degraded_k), ("drift.safe_off_k", self.safe_off_k))
    }
}

/// P4: part fan.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartFanParams {
    /// Revolutions at full duty `[1/s]`.
    pub full_1_s: f64,
    /// Duty from which it must turn `[-]`.
    pub duty_min: f64,
    /// Share of the speed of its duty that is enough; below it a fan is told to be weak `[-]`.
    pub share_min: f64,
    /// Share below which it as good as stands, a fault; below `share_min` `[-]`.
    pub share_standing: f64,
    /// How long it may be slower `[s]`.
    pub persist_s: f64,
}

impl PartFanParams {
    /// # Errors
    /// A number outside its range.
    pub(super) fn check(&self) -> Result<(), ParamError> {
        in_range("part_fan.full_1_s", self.full_1_s, "1/s", (1.0, 2000.0))?;
        in_range("part_fan.duty_min", self.duty_min, "-", (0.01, 1.0))?;
        in_range("part_fan.share_min", self.share_min, "-", (0.05, 0.95))?;
        in_range("part_fan.share_standing", self.share_standing, "-", (0.01, 0.9))?;
        ordered(("part_fan.share_standing", self.share_standing), ("part_fan.share_min", self.share_min))?;
        in_range("part_fan.persist_s", self.persist_s, "s", (0.1, 60.0)).map(|_| ())
    }
}

/// P13: stop contact.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StopInputParams {
    /// Reports that must say open, with no rest of closed ones between `[-]`.
    pub reports: u32,
}

impl StopInputParams {
    /// # Errors
    /// A number outside its range.
    pub(super) fn check(self) -> Result<(), ParamError> {
        count("stop_input.reports", self.reports, 10).map(|_| ())
    }
}

/// P3: a fall no heater shows.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawDetachedParams")]
pub struct DetachedParams {
    /// Fastest credible fall `[K/s]`.
    pub fall_k_s: f64,
    /// Longest span of four samples that is judged `[s]`.
    pub span_max_s: f64,
    /// Spans in a row until it trips; above 4, so that one spike cannot `[-]`.
    pub samples: u32,
}

/// As [`DetachedParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawDetachedParams {
    /// Fastest credible fall `[K/s]`.
    pub fall_k_s: f64,
    /// Longest span of four samples that is judged `[s]`.
    pub span_max_s: f64,
    /// Spans in a row until it trips; above 4, so that one spike cannot `[-]`.
    pub samples: u32,
}

impl TryFrom<RawDetachedParams> for DetachedParams {
    type Error = ParamError;

    fn try_from(raw: RawDetachedParams) -> Result<Self, ParamError> {
        Ok(Self {
            fall_k_s: in_range("fall_k_s", raw.fall_k_s, "K/s", (1.0, 50.0))?,
            span_max_s: in_range("span_max_s", raw.span_max_s, "s", (0.1, 10.0))?,
            samples: count("samples", raw.samples, 20)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_out_of_range_are_refused_by_name() {
        assert!(StopInputParams { reports: 2 }.check().is_ok());
        let told = |checked: Result<(), ParamError>| checked.unwrap_err().to_string();
        let none = StopInputParams { reports: 0 };
        assert_eq!(told(none.check()), "stop_input.reports = 0 (no unit): must be in [1, 10]");
        let fan = PartFanParams {
            full_1_s: 83.0,
            duty_min: 0.3,
            share_min: 0.6,
            share_standing: 0.2,
            persist_s: f64::NAN,
        };
        assert_eq!(told(fan.check()), "part_fan.persist_s = NaN s: must be in [0.1, 60]");
        let step = JumpParams { step_k: 12.0, rate_max_k_s: 4.0, samples: 8, gap_max_s: 0.0 };
        assert_eq!(told(step.check()), "hotend_step.gap_max_s = 0 s: must be in [0.2, 10]");
        let noise =
            NoiseParams { gate_k: 1.0, window: 1000, share_max: 0.2, suspect_window: 20, suspect_count: 2 };
        assert_eq!(told(noise.check()), "noise.window = 1000 (no unit): must be in [1, 128]");
        let never = NoiseParams { window: 50, suspect_count: 21, ..noise };
        assert_eq!(
            never.check().unwrap_err().to_string(),
            "noise.suspect_count = 21 (no unit): must be in [1, 20]"
        );
    }
}
