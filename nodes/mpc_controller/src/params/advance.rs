//! The block `advance`.

use super::Level;
use models::params::{ParamError, in_range, ordered};
use serde::Deserialize;

/// Where the pressure advance comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AdvanceSource {
    /// No advance at all.
    None,
    /// The file's own (`M900`, `SET_PRESSURE_ADVANCE`).
    File,
    /// The material's constant.
    Material,
    /// The law of melt and filament, attached to coming moves; the material's constant where a host cannot do that.
    Planned,
    /// The advance predictor; without a word of it the file's own.
    Predicted,
}

impl AdvanceSource {
    /// Whether it gives coming moves a law each, where a host executes those.
    pub(crate) const fn plans_corners(self) -> bool {
        matches!(self, Self::Planned | Self::Predicted)
    }
}

/// Pressure advance.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawAdvance {
    /// Where it comes from.
    pub source: AdvanceSource,
    /// An older prediction is not used `[s]`.
    pub age_limit_s: f64,
    /// Largest half width of the interval that is used, over the prediction `[-]`.
    pub doubt_max: f64,
    /// Lowest advance sent `[s]`.
    pub low_s: f64,
    /// Highest advance sent `[s]`.
    pub high_s: f64,
    /// Highest advance of a law of a coming move `[s]`, at `law_feed_m_s`: below the supervisor's.
    pub law_high_s: f64,
    /// Feed of the filament at which that is taken `[m/s]`.
    pub law_feed_m_s: f64,
    /// Change while a road is laid `[s/s]`: the relative width error that it makes.
    pub straight_slew_s_s: f64,
    /// Change while a turn is foreseen `[s/s]`.
    pub turn_slew_s_s: f64,
    /// A turn farther ahead is not yet acted on `[s]`.
    pub turn_lead_s: f64,
    /// How long a trim of a coming move counts `[s]`.
    pub schedule_validity_s: f64,
    /// Learning from widths.
    pub learning: RawLearning,
}

/// Learning from widths.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLearning {
    /// Largest correction, relative to the prediction `[-]`; 0 learns nothing.
    pub reach: f64,
    /// The same of the law that is planned from the material's own melt `[-]`; its factor is one on the melt's force, too.
    pub planned_reach: f64,
    /// Largest correction of the index of a planned law `[-]`; 0 leaves the material's.
    pub index_reach: f64,
    /// Largest further correction of the melt's part in a nozzle that has narrowed `[-]`; 0 leaves what its dip told.
    pub narrowed_reach: f64,
    /// How fast the correction follows `[1/s]`: times K it is the relative width error of a straight.
    pub slew_1_s: f64,
    /// Scatter of widths that no advance explains, relative `[-]`.
    pub width_noise: f64,
    /// Frames that are remembered `[-]`.
    pub frames: f64,
    /// Wait after the start of a road `[s]`.
    pub settle_s: f64,
    /// Wait after the end of a ramp `[s]`.
    pub calm_s: f64,
    /// Status and frame further apart are no pair `[s]`.
    pub pairing_s: f64,
    /// Smaller levers count as none: what the loop's own trims do `[-]`.
    pub lever_min: f64,
    /// Larger levers are left out: next to rest the lag is not linear `[-]`.
    pub lever_max: f64,
    /// Larger width errors count as this one `[-]`.
    pub error_max: f64,
}

impl RawAdvance {
    /// Learning as it counts for the source at a level: a planned law asks more of the drive than nominal only where the plan
    /// can slow the print, and of any other law nothing is learnt but its factor.
    pub(crate) fn learning_at(&self, level: Level) -> RawLearning {
        let alone = RawLearning { index_reach: 0.0, narrowed_reach: 0.0, ..self.learning };
        match (self.source, level) {
            (AdvanceSource::Planned, Level::Mpc) => {
                RawLearning { reach: self.learning.planned_reach, ..self.learning }
            }
            (AdvanceSource::Planned, _) => RawLearning { reach: 0.0, ..alone },
            _ => alone,
        }
    }

    pub(super) fn check(&self) -> Result<(), ParamError> {
        in_range("advance.age_limit_s", self.age_limit_s, "s", (0.01, 600.0))?;
        in_range("advance.doubt_max", self.doubt_max, "-", (0.0, 1.0))?;
        in_range("advance.low_s", self.low_s, "s", (0.0, 5.0))?;
        in_range("advance.high_s", self.high_s, "s", (0.0, 5.0))?;
        ordered(("advance.low_s", self.low_s), ("advance.high_s", self.high_s))?;
        in_range("advance.law_high_s", self.law_high_s, "s", (0.0, 5.0))?;
        in_range("advance.law_feed_m_s", self.law_feed_m_s, "m/s", (1e-5, 0.1))?;
        in_range("advance.straight_slew_s_s", self.straight_slew_s_s, "s/s", (1e-4, 10.0))?;
        in_range("advance.turn_slew_s_s", self.turn_slew_s_s, "s/s", (self.straight_slew_s_s, 10.0))?;
        in_range("advance.turn_lead_s", self.turn_lead_s, "s", (0.0, 5.0))?;
        in_range("advance.schedule_validity_s", self.schedule_validity_s, "s", (0.05, 60.0))?;
        let learning = &self.learning;
        in_range("advance.learning.reach", learning.reach, "-", (0.0, 0.5))?;
        in_range("advance.learning.planned_reach", learning.planned_reach, "-", (0.0, 0.5))?;
        in_range("advance.learning.index_reach", learning.index_reach, "-", (0.0, 0.3))?;
        in_range("advance.learning.narrowed_reach", learning.narrowed_reach, "-", (0.0, 2.0))?;
        in_range("advance.learning.slew_1_s", learning.slew_1_s, "1/s", (1e-5, 10.0))?;
        in_range("advance.learning.width_noise", learning.width_noise, "-", (0.001, 1.0))?;
        in_range("advance.learning.frames", learning.frames, "-", (2.0, 1e5))?;
        in_range("advance.learning.settle_s", learning.settle_s, "s", (0.0, 10.0))?;
        in_range("advance.learning.calm_s", learning.calm_s, "s", (0.0, 10.0))?;
        in_range("advance.learning.pairing_s", learning.pairing_s, "s", (1e-3, 1.0))?;
        in_range("advance.learning.lever_min", learning.lever_min, "-", (0.0, 1.0))?;
        in_range("advance.learning.lever_max", learning.lever_max, "-", (0.01, 10.0))?;
        ordered(
            ("advance.learning.lever_min", learning.lever_min),
            ("advance.learning.lever_max", learning.lever_max),
        )?;
        in_range("advance.learning.error_max", learning.error_max, "-", (0.01, 10.0))?;
        Ok(())
    }
}
