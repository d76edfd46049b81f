//! What is learnt of noise and lag, and when the estimate is not to be trusted.

use models::params::{ParamError, in_range};
use serde::Deserialize;

/// Scale of the variances behind a channel, from its own innovations.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawAdaptation {
    /// Smallest scale `[-]`.
    pub low: f64,
    /// Largest scale `[-]`.
    pub high: f64,
    /// Mean of the normalised innovations squared that is aimed at `[-]`.
    pub aim: f64,
    /// Share of the windowed mean's logarithm that a sample moves the scale's by `[-]`; 0 learns nothing.
    pub rate: f64,
    /// Innovations in the window.
    pub samples: u32,
}

/// A factor on the melt's lag, from widths behind changes of speed.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawMeltLag {
    /// Largest correction of the factor `[-]`; 0 learns nothing.
    pub reach: f64,
    /// Scatter of widths that no lag explains `[-]`.
    pub width_noise: f64,
    /// Frames over which is remembered.
    pub frames: f64,
    /// Smaller effects of the lag on a relative width count as none `[-]`.
    pub lever_min: f64,
    /// Larger relative errors of a width count as this one `[-]`.
    pub error_max: f64,
}

/// When the estimate is not to be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawHealth {
    /// Normalised innovation squared that speaks against the filter `[-]`.
    pub row_bound: f64,
    /// So many of them more than those that speak for it reset the filter.
    pub row: u32,
    /// How long a reset is told `[s]`.
    pub hold_s: f64,
    /// A second reset within this time is more than one `[s]`.
    pub again_s: f64,
    /// The model has not fitted for so long: another printer `[s]`.
    pub mismatch_s: f64,
    /// Bead gain that far from one does not fit `[-]`.
    pub gain_error: f64,
    /// Sum of a window's normalised innovations squared above which the channel does not fit `[-]`.
    pub window_bound: f64,
}

impl RawAdaptation {
    pub(super) fn check(&self) -> Result<(), ParamError> {
        in_range("width.adaptation.low", self.low, "-", (1e-3, 1.0))?;
        in_range("width.adaptation.high", self.high, "-", (1.0, 1e3))?;
        in_range("width.adaptation.aim", self.aim, "-", (0.3, 1.5))?;
        in_range("width.adaptation.rate", self.rate, "-", (0.0, 0.5))?;
        in_range("width.adaptation.samples", f64::from(self.samples), "samples", (2.0, 100.0))?;
        // integral action behind a window: the rate has to leave it time
        in_range("width.adaptation.rate", self.rate, "-", (0.0, 1.0 / f64::from(self.samples)))?;
        Ok(())
    }
}

impl RawMeltLag {
    pub(super) fn check(&self) -> Result<(), ParamError> {
        in_range("melt_lag.reach", self.reach, "-", (0.0, 0.5))?;
        in_range("melt_lag.width_noise", self.width_noise, "-", (1e-3, 1.0))?;
        in_range("melt_lag.frames", self.frames, "-", (2.0, 1e5))?;
        in_range("melt_lag.lever_min", self.lever_min, "-", (0.0, 1.0))?;
        in_range("melt_lag.error_max", self.error_max, "-", (0.01, 10.0))?;
        Ok(())
    }
}

impl RawHealth {
    pub(super) fn check(&self) -> Result<(), ParamError> {
        in_range("health.row_bound", self.row_bound, "-", (1.0, 1e3))?;
        in_range("health.row", f64::from(self.row), "samples", (2.0, 100.0))?;
        in_range("health.hold_s", self.hold_s, "s", (0.1, 60.0))?;
        in_range("health.again_s", self.again_s, "s", (1.0, 600.0))?;
        in_range("health.mismatch_s", self.mismatch_s, "s", (1.0, 600.0))?;
        in_range("health.gain_error", self.gain_error, "-", (0.01, 1.0))?;
        in_range("health.window_bound", self.window_bound, "-", (1.0, 1e6))?;
        Ok(())
    }
}
