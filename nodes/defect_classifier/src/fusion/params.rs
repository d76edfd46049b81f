//! Parameters of the fusion.

use super::{RawEvidence, chi_square_point};
use models::params::{ParamError, in_range};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Degrees of freedom of one window of the estimator (model book 1.6): the scale where none came yet.
const WINDOW: f64 = 20.0;

/// Why a fusion could not be set up.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FusionError {
    /// A rule for a class that the network does not tell, or evidence on one.
    #[error("fusion.{place}: the network does not know the class '{class}'; it knows {known}")]
    UnknownClass {
        /// Where the class is named.
        place: &'static str,
        /// The class.
        class: String,
        /// Classes of the network.
        known: String,
    },
}

/// When a cause is confirmed: `in_favour` of the last `frames` frames name it, each with `probability_min`.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConfirmRule {
    /// Frames looked back on, 1 to 1000.
    pub frames: u32,
    /// Frames that must agree, 1 to `frames`.
    pub in_favour: u32,
    /// Least probability of a frame that counts `[0, 1]`.
    pub probability_min: f64,
}

/// Parameters of the fusion. Built only from a valid [`RawFusionParams`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawFusionParams")]
pub struct FusionParams(RawFusionParams);

impl std::ops::Deref for FusionParams {
    type Target = RawFusionParams;

    fn deref(&self) -> &RawFusionParams {
        &self.0
    }
}

/// The `fusion` block of `config/defect_classifier.param.yaml` as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawFusionParams {
    /// beta, share of the residuals in the confidence `[-]`, 0 to 1.
    pub residual_share: f64,
    /// Normal point of the quantile of tau_a `[-]`, 0 to 6; 2.326 is 99 %.
    pub residual_normal_quantile: f64,
    /// Older residuals do not count `[s]`, above 0.
    pub residual_age_max_s: f64,
    /// Memory of the smoothing `[s]`, above 0.
    pub smoothing_s: f64,
    /// After a longer gap between frames the past is forgotten `[s]`, above 0.
    pub gap_max_s: f64,
    /// Frames that soon after start or resume do not count `[s]`, 0 to 3600.
    pub grace_s: f64,
    /// What a measurement says of a class.
    pub evidence: RawEvidence,
    /// Rule per class; a class without one is never confirmed.
    pub confirm: BTreeMap<String, ConfirmRule>,
}

impl TryFrom<RawFusionParams> for FusionParams {
    type Error = ParamError;

    fn try_from(raw: RawFusionParams) -> Result<Self, ParamError> {
        in_range("residual_share", raw.residual_share, "-", (0.0, 1.0))?;
        in_range("residual_normal_quantile", raw.residual_normal_quantile, "-", (0.0, 6.0))?;
        in_range("residual_age_max_s", raw.residual_age_max_s, "s", (0.01, 3600.0))?;
        in_range("smoothing_s", raw.smoothing_s, "s", (0.01, 3600.0))?;
        in_range("gap_max_s", raw.gap_max_s, "s", (0.01, 3600.0))?;
        in_range("grace_s", raw.grace_s, "s", (0.0, 3600.0))?;
        raw.evidence.check()?;
        for rule in raw.confirm.values() {
            in_range("frames", f64::from(rule.frames), "frames", (1.0, 1000.0))?;
            in_range("in_favour", f64::from(rule.in_favour), "frames", (1.0, f64::from(rule.frames)))?;
            in_range("probability_min", rule.probability_min, "-", (0.0, 1.0))?;
        }
        Ok(Self(raw))
    }
}

impl FusionParams {
    /// An offset of the layers counts from what the machine's own kinematics explains on `[m]`, 0 or more.
    #[must_use]
    pub fn with_machine_error(mut self, error_m: f64) -> Self {
        self.0.evidence.machine_error_m = error_m;
        self
    }

    /// A rule or none per class, in their order.
    pub(super) fn rules_of(&self, classes: &[String]) -> Result<Vec<Option<ConfirmRule>>, FusionError> {
        let ruled = self.confirm.keys().map(|class| ("confirm", class));
        let measured = self.evidence.measured_only.iter().map(|class| ("evidence.measured_only", class));
        if let Some((place, class)) = ruled.chain(measured).find(|(_, class)| !classes.contains(class)) {
            let (class, known) = (class.clone(), classes.join(", "));
            return Err(FusionError::UnknownClass { place, class, known });
        }
        Ok(classes.iter().map(|class| self.confirm.get(class).copied()).collect())
    }

    /// tau_a of one window, where the estimator said nothing.
    pub(super) fn idle_limit(&self) -> f64 {
        chi_square_point(WINDOW, self.residual_normal_quantile)
    }
}
