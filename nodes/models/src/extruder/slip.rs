//! Slip of the drive gear.

use serde::Deserialize;

use crate::params::{ParamError, in_range};

/// Slip law. Built only from valid [`RawSlip`]. Our assumption (model book 1.2).
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawSlip")]
pub struct SlipParams(RawSlip);

read_only!(SlipParams(RawSlip));

/// The `slip` block of a plant file as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSlip {
    /// Slip without load s0 `[-]`, in `[0, 0.5]`.
    pub base: f64,
    /// Slip at the reference force from creep of the teeth `[-]`, in `[0, 1]`.
    pub creep: f64,
    /// Reference force of the creep `[N]`, above 0.
    pub creep_force_n: f64,
    /// Slip per overload force beyond F_max `[-]`, 0 or more.
    pub overload: f64,
    /// Force over which that much slip is added `[N]`, above 0.
    pub overload_force_n: f64,
    /// Highest slip `[-]`, in `[0, 1)`.
    pub cap: f64,
}

impl TryFrom<RawSlip> for SlipParams {
    type Error = ParamError;

    fn try_from(raw: RawSlip) -> Result<Self, ParamError> {
        in_range("base", raw.base, "-", (0.0, 0.5))?;
        in_range("creep", raw.creep, "-", (0.0, 1.0))?;
        in_range("creep_force_n", raw.creep_force_n, "N", (0.1, 1e4))?;
        in_range("overload", raw.overload, "-", (0.0, 10.0))?;
        in_range("overload_force_n", raw.overload_force_n, "N", (0.1, 1e4))?;
        in_range("cap", raw.cap, "-", (0.0, 0.999))?;
        Ok(Self(raw))
    }
}

impl SlipParams {
    /// Share of the motor's feed that is lost `[-]`, in `[0, cap]`:
    /// `s = s0 + s_dist + 0.02 (F/40 N)^2 + 0.5 max(0, F - F_max)/10 N`.
    #[must_use]
    pub fn slip(&self, force_n: f64, force_max_n: f64, disturbance: f64) -> f64 {
        let creep = self.creep * (force_n / self.creep_force_n).powi(2);
        let overload = self.overload * (force_n - force_max_n).max(0.0) / self.overload_force_n;
        (self.base + disturbance + creep + overload).clamp(0.0, self.cap)
    }
}
