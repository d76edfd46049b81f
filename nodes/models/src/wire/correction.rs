//! Feed and head speed from a measured height, within limits (model book 3.3).
//!
//! Two facts of the paper's Tables 1 and 2, found by regression, make the law: the section that is laid is linear in
//! the height error, `r = 1 + g (h0 - h)/h0`, and `v_head + kappa v_wire` stays constant with
//! `kappa = s v_h0/v_w0`, s = 2/3. Hence
//! ```text
//! v_h = v_h0 (1 + s) / (1 + s r)        v_w = r (v_w0/v_h0) v_h
//! ```
//! From layer to layer the height error shrinks by `1 - g`: stable for `0 < g < 2`.

use serde::Deserialize;

use crate::params::{ParamError, in_range, ordered};

/// Which speeds the law moves; each way lays the same section.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Both: the time per millimetre stays within bounds.
    Both,
    /// The wire alone: `v_w = r v_w0`.
    Wire,
    /// The head alone: `v_h = v_h0/r`.
    Head,
}

/// The correction law. Built only from a valid [`RawLaw`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawLaw")]
pub struct Law(RawLaw);

read_only!(Law(RawLaw));

/// The `law` block of `config/wire/process.yaml` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLaw {
    /// Height of a layer as planned h0 `[m]`, above 0.
    pub height_m: f64,
    /// Speed of the wire at that height v_w0 `[m/s]`, above 0.
    pub wire_m_s: f64,
    /// Speed of the head at that height v_h0 `[m/s]`, above 0.
    pub head_m_s: f64,
    /// Gain g `[-]`, in `[0, 4]`; the loop over layers is stable in (0, 2).
    pub gain: f64,
    /// Part s of kappa `[-]`, in `[0, 10]`: how the correction is split between wire and head.
    pub split: f64,
    /// Least section relative to the planned one `[-]`, in `[0.01, 1]`.
    pub ratio_low: f64,
    /// Largest section relative to the planned one `[-]`, in `[1, 10]`.
    pub ratio_high: f64,
}

/// Gains that a law may have `[-]`.
pub const GAIN_RANGE: (f64, f64) = (0.0, 4.0);
/// From layer to layer the height error shrinks by `1 - g`: beyond this gain it grows `[-]`.
pub const GAIN_STABLE_BELOW: f64 = 2.0;

impl TryFrom<RawLaw> for Law {
    type Error = ParamError;

    fn try_from(raw: RawLaw) -> Result<Self, ParamError> {
        in_range("height_m", raw.height_m, "m", (1e-6, 0.1))?;
        in_range("wire_m_s", raw.wire_m_s, "m/s", (1e-6, 10.0))?;
        in_range("head_m_s", raw.head_m_s, "m/s", (1e-6, 10.0))?;
        in_range("gain", raw.gain, "-", GAIN_RANGE)?;
        in_range("split", raw.split, "-", (0.0, 10.0))?;
        in_range("ratio_low", raw.ratio_low, "-", (0.01, 1.0))?;
        in_range("ratio_high", raw.ratio_high, "-", (1.0, 10.0))?;
        Ok(Self(raw))
    }
}

/// What wire drive, laser and head can do. Built only from valid [`RawLimits`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawLimits")]
pub struct Limits(RawLimits);

read_only!(Limits(RawLimits));

/// The `limits` block of `config/wire/process.yaml` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLimits {
    /// Slowest wire `[m/s]`, above 0.
    pub wire_low_m_s: f64,
    /// Fastest wire, what the laser can melt `[m/s]`.
    pub wire_high_m_s: f64,
    /// Slowest head `[m/s]`, above 0.
    pub head_low_m_s: f64,
    /// Fastest head `[m/s]`.
    pub head_high_m_s: f64,
}

impl TryFrom<RawLimits> for Limits {
    type Error = ParamError;

    fn try_from(raw: RawLimits) -> Result<Self, ParamError> {
        in_range("wire_low_m_s", raw.wire_low_m_s, "m/s", (1e-6, 10.0))?;
        in_range("wire_high_m_s", raw.wire_high_m_s, "m/s", (1e-6, 10.0))?;
        in_range("head_low_m_s", raw.head_low_m_s, "m/s", (1e-6, 10.0))?;
        in_range("head_high_m_s", raw.head_high_m_s, "m/s", (1e-6, 10.0))?;
        ordered(("wire_low_m_s", raw.wire_low_m_s), ("wire_high_m_s", raw.wire_high_m_s))?;
        ordered(("head_low_m_s", raw.head_low_m_s), ("head_high_m_s", raw.head_high_m_s))?;
        Ok(Self(raw))
    }
}

/// Speeds for a measured height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corrected {
    /// Speed of the wire `[m/s]`.
    pub wire_m_s: f64,
    /// Speed of the head `[m/s]`.
    pub head_m_s: f64,
    /// Section that these speeds lay, relative to the planned one `[-]`.
    pub section_ratio: f64,
    /// Whether a limit took something away from the law.
    pub limited: bool,
}

impl Law {
    /// Section wanted for a measured height, relative to the planned one, and whether the law's own range cut it.
    ///
    /// # Errors
    /// [`ParamError::OutOfRange`] for a height that is not finite.
    pub fn ratio(&self, height_m: f64) -> Result<(f64, bool), ParamError> {
        in_range("measured_height_m", height_m, "m", (f64::MIN, f64::MAX))?;
        let wanted = 1.0 + self.gain * (self.height_m - height_m) / self.height_m;
        let cut = wanted.clamp(self.ratio_low, self.ratio_high);
        Ok((cut, (cut - wanted).abs() > 0.0))
    }

    /// Speeds for a measured height without limits of the machine.
    ///
    /// # Errors
    /// [`ParamError::OutOfRange`] for a height that is not finite.
    pub fn correct(&self, mode: Mode, height_m: f64) -> Result<Corrected, ParamError> {
        let (ratio, limited) = self.ratio(height_m)?;
        let (wire, head) = match mode {
            Mode::Both => {
                let head = (1.0 + self.split) / (1.0 + self.split * ratio);
                (ratio * head, head)
            }
            Mode::Wire => (ratio, 1.0),
            Mode::Head => (1.0, 1.0 / ratio),
        };
        Ok(self.corrected((self.wire_m_s * wire, self.head_m_s * head), limited))
    }

    /// Speeds within the machine's limits. Where one speed stops at its limit the other one takes over, as far as it
    /// may: the section is what the next layer needs. In the modes of one speed the other one stays as it is.
    ///
    /// # Errors
    /// [`ParamError::OutOfRange`] for a height that is not finite.
    pub fn correct_within(
        &self,
        mode: Mode,
        limits: &Limits,
        height_m: f64,
    ) -> Result<Corrected, ParamError> {
        let free = self.correct(mode, height_m)?;
        let wire_of = |wire_m_s: f64| wire_m_s.clamp(limits.wire_low_m_s, limits.wire_high_m_s);
        let head_of = |head_m_s: f64| head_m_s.clamp(limits.head_low_m_s, limits.head_high_m_s);
        let mut wire_m_s = wire_of(free.wire_m_s);
        let mut head_m_s = head_of(free.head_m_s);
        if mode == Mode::Both {
            let wire_per_head = free.section_ratio * self.wire_m_s / self.head_m_s;
            head_m_s = head_of(wire_m_s / wire_per_head);
            wire_m_s = wire_of(head_m_s * wire_per_head);
        }
        let moved = (wire_m_s / free.wire_m_s - 1.0).abs().max((head_m_s / free.head_m_s - 1.0).abs());
        // Beyond the rounding of a division and its inverse.
        Ok(self.corrected((wire_m_s, head_m_s), free.limited || moved > 1e-12))
    }

    fn corrected(&self, (wire_m_s, head_m_s): (f64, f64), limited: bool) -> Corrected {
        let section_ratio = (wire_m_s / head_m_s) / (self.wire_m_s / self.head_m_s);
        Corrected { wire_m_s, head_m_s, section_ratio, limited }
    }

    /// The law with another gain.
    ///
    /// # Errors
    /// [`ParamError::OutOfRange`] as for the law itself.
    pub fn with_gain(&self, gain: f64) -> Result<Self, ParamError> {
        Self::try_from(RawLaw { gain, ..self.0 })
    }

    /// Whether a height error fades from layer to layer: `0 < g < 2`.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.gain > 0.0 && self.gain < GAIN_STABLE_BELOW
    }

    /// The height at which the law lays the section of a pair of speeds `[m]`; none at a gain of 0.
    #[must_use]
    pub fn height_of(&self, wire_m_s: f64, head_m_s: f64) -> Option<f64> {
        let ratio = (wire_m_s / head_m_s) / (self.wire_m_s / self.head_m_s);
        (self.gain > 0.0).then(|| self.height_m * (1.0 - (ratio - 1.0) / self.gain))
    }
}

#[cfg(test)]
mod tests;
