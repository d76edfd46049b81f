//! Parameters of the surface.

use models::params::{ParamError, in_range, ordered};
use serde::Deserialize;

/// How edges are held against roads. Built only from a valid [`RawUnexplained`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawUnexplained")]
pub struct UnexplainedParams(RawUnexplained);

impl std::ops::Deref for UnexplainedParams {
    type Target = RawUnexplained;

    fn deref(&self) -> &RawUnexplained {
        &self.0
    }
}

/// The `unexplained` block of `config/defect_classifier.param.yaml` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawUnexplained {
    /// Lowest corner of what can be printed on `[m]`.
    pub bed_low_m: [f64; 2],
    /// Highest corner `[m]`.
    pub bed_high_m: [f64; 2],
    /// Side of a cell of the map `[m]`.
    pub cell_m: f64,
    /// A road explains edges as far beside it `[m]`.
    pub beside_m: f64,
    /// Largest angle between an edge and its road `[rad]`.
    pub turn_max_rad: f64,
    /// An edge is strong from this share of what edges on roads typically have `[-]`.
    pub strong_share: f64,
    /// Share of the way that what is known of the bed's texture follows a frame with more of it `[-]`.
    pub texture_rise: f64,
    /// And a frame with less `[-]`.
    pub texture_fall: f64,
    /// So many times the known texture is not counted `[-]`, 1 or more.
    pub texture_margin: f64,
    /// Least share of the visible pixels on roads to tell anything `[-]`.
    pub roads_share_min: f64,
    /// Fewest pixels on roads to tell what they typically have, and off them to learn the texture.
    pub pixels_min: u32,
}

impl TryFrom<RawUnexplained> for UnexplainedParams {
    type Error = ParamError;

    fn try_from(raw: RawUnexplained) -> Result<Self, ParamError> {
        for axis in 0..2 {
            let (low_m, high_m) = (raw.bed_low_m[axis], raw.bed_high_m[axis]);
            in_range("unexplained.bed_low_m", low_m, "m", (-1.0, 1.0))?;
            in_range("unexplained.bed_high_m", high_m, "m", (-1.0, 1.0))?;
            ordered(("unexplained.bed_low_m", low_m), ("unexplained.bed_high_m", high_m))?;
        }
        in_range("unexplained.cell_m", raw.cell_m, "m", (5e-5, 1e-3))?;
        in_range("unexplained.beside_m", raw.beside_m, "m", (0.0, 5e-3))?;
        in_range("unexplained.turn_max_rad", raw.turn_max_rad, "rad", (0.05, 1.5))?;
        in_range("unexplained.strong_share", raw.strong_share, "-", (0.001, 100.0))?;
        in_range("unexplained.texture_rise", raw.texture_rise, "-", (0.0, 1.0))?;
        in_range("unexplained.texture_fall", raw.texture_fall, "-", (0.0, 1.0))?;
        in_range("unexplained.texture_margin", raw.texture_margin, "-", (1.0, 100.0))?;
        in_range("unexplained.roads_share_min", raw.roads_share_min, "-", (0.0, 1.0))?;
        in_range("unexplained.pixels_min", f64::from(raw.pixels_min), "px", (10.0, 1e5))?;
        Ok(Self(raw))
    }
}

impl UnexplainedParams {
    /// Columns and rows of the map.
    #[expect(clippy::cast_possible_truncation, reason = "at most two metres of cells of 50 um")]
    pub(super) fn cells(&self) -> [i32; 2] {
        [0, 1].map(|axis| ((self.bed_high_m[axis] - self.bed_low_m[axis]) / self.cell_m).ceil() as i32)
    }

    /// Cells in `beside_m`.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 100 cells")]
    pub(super) fn beside_cells(&self) -> usize {
        (self.beside_m / self.cell_m).round() as usize
    }
}
