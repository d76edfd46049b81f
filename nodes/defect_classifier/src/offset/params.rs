//! Parameters of the registration.

use models::params::{ParamError, in_range, ordered};
use serde::Deserialize;

/// How offsets are found. Built only from a valid [`RawOffset`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawOffset")]
pub struct OffsetParams(RawOffset);

/// The `offset` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawOffset {
    /// Lower corner of what can be printed on, x and y `[m]`.
    pub bed_low_m: [f64; 2],
    /// Upper corner of it `[m]`.
    pub bed_high_m: [f64; 2],
    /// What lies deeper below the newest road is dark and out of focus and may look like bed `[m]`.
    pub depth_m: f64,
    /// Roads of the layer under way count as laid before from this age on `[s]`.
    pub old_s: f64,
    /// What is nearer to newer roads does not count `[m]`.
    pub beside_new_m: f64,
    /// Largest offset looked for, each way `[m]`.
    pub range_m: f64,
    /// Between two offsets looked at `[m]`.
    pub step_m: f64,
    /// Farther inside the outline than this all is part, farther outside all is bed `[m]`.
    pub sure_m: f64,
    /// Least number of coarse pixels of part and of bed to learn their looks from.
    pub samples_min: u32,
    /// Least separation of part and bed, as squared Mahalanobis distance `[-]`.
    pub separation_min: f64,
    /// Largest log likelihood ratio that one coarse pixel may have `[-]`.
    pub ratio_max: f64,
    /// Coarse pixels that look alike count as one `[-]`.
    pub alike: f64,
    /// Gaps up to this width inside the old part are part: the room in sparse infill `[m]`.
    pub gap_m: f64,
    /// Next to the old part so much bed is shaded by it and looks like either `[m]`.
    pub fringe_m: f64,
    /// What an offset of a step or more must be better supported than none, as log likelihood `[-]`: it is rare.
    pub rarity: f64,
    /// Memory of the evidence `[s]`.
    pub memory_s: f64,
    /// Least standard deviation of an offset `[m]`.
    pub sigma_floor_m: f64,
    /// A less certain offset is not known `[m]`.
    pub sigma_max_m: f64,
}

impl std::ops::Deref for OffsetParams {
    type Target = RawOffset;

    fn deref(&self) -> &RawOffset {
        &self.0
    }
}

impl TryFrom<RawOffset> for OffsetParams {
    type Error = ParamError;

    fn try_from(raw: RawOffset) -> Result<Self, ParamError> {
        for axis in 0..2 {
            in_range("offset.bed_low_m", raw.bed_low_m[axis], "m", (-1.0, 1.0))?;
            in_range("offset.bed_high_m", raw.bed_high_m[axis], "m", (-1.0, 1.0))?;
            let bounds = (raw.bed_low_m[axis], raw.bed_high_m[axis]);
            ordered(("offset.bed_low_m", bounds.0), ("offset.bed_high_m", bounds.1))?;
        }
        in_range("offset.depth_m", raw.depth_m, "m", (1e-4, 0.1))?;
        in_range("offset.old_s", raw.old_s, "s", (0.1, 3600.0))?;
        in_range("offset.beside_new_m", raw.beside_new_m, "m", (0.0, 5e-3))?;
        in_range("offset.range_m", raw.range_m, "m", (2e-4, 5e-3))?;
        in_range("offset.step_m", raw.step_m, "m", (5e-5, 1e-3))?;
        in_range("offset.sure_m", raw.sure_m, "m", (1e-4, 5e-3))?;
        in_range("offset.samples_min", f64::from(raw.samples_min), "px", (10.0, 1e5))?;
        in_range("offset.separation_min", raw.separation_min, "-", (0.0, 100.0))?;
        in_range("offset.ratio_max", raw.ratio_max, "-", (0.01, 1000.0))?;
        in_range("offset.alike", raw.alike, "-", (1.0, 1e4))?;
        in_range("offset.gap_m", raw.gap_m, "m", (0.0, 1e-2))?;
        in_range("offset.fringe_m", raw.fringe_m, "m", (0.0, 5e-3))?;
        in_range("offset.rarity", raw.rarity, "-", (0.0, 100.0))?;
        in_range("offset.memory_s", raw.memory_s, "s", (0.1, 600.0))?;
        in_range("offset.sigma_floor_m", raw.sigma_floor_m, "m", (1e-8, 0.01))?;
        in_range("offset.sigma_max_m", raw.sigma_max_m, "m", (1e-8, 1e-2))?;
        ordered(("offset.sigma_floor_m", raw.sigma_floor_m), ("offset.sigma_max_m", raw.sigma_max_m))?;
        Ok(Self(raw))
    }
}
