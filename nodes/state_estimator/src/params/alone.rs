//! Where no encoder tells of the slip, widths do.

use crate::channel::Step;
use models::params::{ParamError, in_range};
use serde::Deserialize;

/// What holds instead of the ordinary noises and gates while widths alone tell of slip, flow and gain.
///
/// A frame shows the product of flow and gain. Noise of the flow takes what is a slip's, frames that are left out miss it: both
/// are less than beside an encoder, and a slip that changes at once is told as a step.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawWidthsAlone {
    /// Slip gained per `process.reference_period_s` `[-]`.
    pub slip: f64,
    /// Largest slip that is believed `[-]`.
    pub slip_most: f64,
    /// Gain gained per `process.reference_period_s` `[-]`: a spool's, which wanders less.
    pub gain: f64,
    /// Uncertainty of the lag, relative `[-]`.
    pub lag_rel: f64,
    /// Share of the flow's recent imbalance by which a width may be off `[-]`.
    pub imbalance: f64,
    /// The path's speed is looked at from this long before the exposure on `[s]`.
    pub steady_s: f64,
    /// Spread of the path speed around the exposure up to which a width is looked at even so, where the printer's reports are
    /// close `[-]`.
    pub unsteady_spread: f64,
    /// Standard deviation of such a width, relative, over that spread and a quarter more, which reports do not show `[-]`.
    pub unsteady_noise: f64,
    /// Widths whose normalised squared innovation is above are rejected `[-]`.
    pub gate: f64,
    /// Innovation, over its own deviation, beyond which a width is given so much more noise that it is off by no more `[-]`.
    pub outlier: f64,
    /// Innovations looked at for a step of the slip.
    pub step_samples: u32,
    /// Bound of their sum over the root of their number, above which a step is taken as given `[-]`.
    pub step_threshold: f64,
    /// Added to the slip when it steps, and to the flow what that takes, a standard deviation `[-]`.
    pub step_std: f64,
    /// Share of it that the flow has followed when the step is told `[-]`.
    pub followed: f64,
    /// Most by which gain and slip are taken for one another, a standard deviation `[-]`.
    pub parted_std: f64,
}

impl RawWidthsAlone {
    /// What tells of a step of the slip. No fading tells of a transient there: nobody vouches for the feed.
    pub(crate) fn step(&self) -> Step {
        Step { samples: self.step_samples as usize, threshold: self.step_threshold, fade: 0.0 }
    }

    pub(super) fn check(&self) -> Result<(), ParamError> {
        in_range("widths_alone.slip", self.slip, "-", (1e-6, 1.0))?;
        in_range("widths_alone.slip_most", self.slip_most, "-", (0.05, 1.0))?;
        in_range("widths_alone.gain", self.gain, "-", (1e-6, 1.0))?;
        in_range("widths_alone.lag_rel", self.lag_rel, "-", (0.0, 2.0))?;
        in_range("widths_alone.imbalance", self.imbalance, "-", (0.0, 5.0))?;
        in_range("widths_alone.steady_s", self.steady_s, "s", (0.0, 2.0))?;
        in_range("widths_alone.unsteady_spread", self.unsteady_spread, "-", (0.0, 1.0))?;
        in_range("widths_alone.unsteady_noise", self.unsteady_noise, "-", (0.01, 1.0))?;
        in_range("widths_alone.gate", self.gate, "-", (1.0, 1e6))?;
        in_range("widths_alone.outlier", self.outlier, "-", (0.5, 100.0))?;
        in_range("widths_alone.step_samples", f64::from(self.step_samples), "samples", (1.0, 20.0))?;
        in_range("widths_alone.step_threshold", self.step_threshold, "-", (1.0, 100.0))?;
        in_range("widths_alone.step_std", self.step_std, "-", (0.0, 1.0))?;
        in_range("widths_alone.followed", self.followed, "-", (0.0, 1.0))?;
        in_range("widths_alone.parted_std", self.parted_std, "-", (0.0, 1.0))?;
        Ok(())
    }
}
