//! Parameters of the width measurement.

use models::params::{ParamError, in_range, ordered};
use serde::Deserialize;

/// How widths are measured. Built only from a valid [`RawWidth`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawWidth")]
pub struct WidthParams(RawWidth);

/// The `width` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawWidth {
    /// Roads laid longer before the exposure are not fresh `[s]`.
    pub fresh_s: f64,
    /// Distance between two profiles along a road `[m]`.
    pub station_m: f64,
    /// Length over which profiles are averaged `[m]`.
    pub piece_m: f64,
    /// Between two samples of a profile `[m]`.
    pub profile_step_m: f64,
    /// Shortest length worth a measurement `[m]`.
    pub piece_min_m: f64,
    /// What is left out at both ends of a straight stretch: the flow has not settled in a corner `[m]`.
    pub corner_m: f64,
    /// Largest turn between two roads of one stretch `[rad]`.
    pub turn_max_rad: f64,
    /// Least share of the cruise speed; slower is a ramp `[-]`.
    pub cruise_share: f64,
    /// Rounder roads, by height over width, are strands: not measured `[-]`.
    pub height_max_rel: f64,
    /// A road lies beside ours, and not below, where its top is lower by less than so many heights of ours `[-]`.
    pub beside_heights: f64,
    /// Ground is open where strands or sparse infill lie within half of it: the widest room between them `[m]`.
    pub open_m: f64,
    /// A side is free where no road beside ours lies within so many widths of the centre line `[-]`.
    pub clear_widths: f64,
    /// A side is stacked where the edge of a road below lies within so many widths of ours `[-]`.
    pub stacked_widths: f64,
    /// Least distance of what is measured from the image's border `[px]`.
    pub margin_px: f64,
    /// Widths that one measurement may stand away from the wanted one `[-]`, relative.
    pub range_rel: f64,
    /// Calibration: what the edges lie too far out on the average over lights `[m]`.
    pub edge_bias_m: f64,
    /// Pieces laid within this time of each other make one measurement `[s]`.
    pub together_s: f64,
    /// Pieces farther from the median than so many spreads do not count `[-]`.
    pub outlier_spreads: f64,
    /// Standard deviation of one edge, beyond what averaging takes away `[m]`.
    pub edge_sigma_m: f64,
    /// Least standard deviation of a measurement `[m]`.
    pub sigma_floor_m: f64,
    /// A worse measurement is not published `[m]`.
    pub sigma_max_m: f64,
}

impl std::ops::Deref for WidthParams {
    type Target = RawWidth;

    fn deref(&self) -> &RawWidth {
        &self.0
    }
}

impl WidthParams {
    /// The same for roads that may have been laid longer ago.
    #[must_use]
    pub(crate) fn with_fresh(mut self, fresh_s: f64) -> Self {
        self.0.fresh_s = fresh_s;
        self
    }
}

impl TryFrom<RawWidth> for WidthParams {
    type Error = ParamError;

    fn try_from(raw: RawWidth) -> Result<Self, ParamError> {
        in_range("width.fresh_s", raw.fresh_s, "s", (0.05, 60.0))?;
        in_range("width.station_m", raw.station_m, "m", (1e-5, 1e-3))?;
        in_range("width.piece_m", raw.piece_m, "m", (2e-4, 2e-2))?;
        in_range("width.profile_step_m", raw.profile_step_m, "m", (1e-6, 1e-4))?;
        in_range("width.edge_bias_m", raw.edge_bias_m, "m", (-5e-5, 5e-5))?;
        in_range("width.piece_min_m", raw.piece_min_m, "m", (1e-5, 0.1))?;
        in_range("width.corner_m", raw.corner_m, "m", (0.0, 1e-2))?;
        in_range("width.turn_max_rad", raw.turn_max_rad, "rad", (0.0, 0.5))?;
        in_range("width.cruise_share", raw.cruise_share, "-", (0.0, 1.0))?;
        in_range("width.height_max_rel", raw.height_max_rel, "-", (0.1, 2.0))?;
        in_range("width.beside_heights", raw.beside_heights, "-", (0.05, 0.95))?;
        in_range("width.open_m", raw.open_m, "m", (0.0, 2e-2))?;
        in_range("width.clear_widths", raw.clear_widths, "-", (0.9, 5.0))?;
        in_range("width.stacked_widths", raw.stacked_widths, "-", (0.0, 1.0))?;
        in_range("width.margin_px", raw.margin_px, "px", (1.0, 100.0))?;
        in_range("width.range_rel", raw.range_rel, "-", (0.05, 0.8))?;
        in_range("width.together_s", raw.together_s, "s", (0.01, 10.0))?;
        in_range("width.outlier_spreads", raw.outlier_spreads, "-", (1.0, 20.0))?;
        in_range("width.edge_sigma_m", raw.edge_sigma_m, "m", (1e-8, 0.001))?;
        in_range("width.sigma_floor_m", raw.sigma_floor_m, "m", (1e-8, 0.01))?;
        in_range("width.sigma_max_m", raw.sigma_max_m, "m", (1e-8, 1e-2))?;
        ordered(("width.sigma_floor_m", raw.sigma_floor_m), ("width.sigma_max_m", raw.sigma_max_m))?;
        Ok(Self(raw))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn params() -> WidthParams {
        WidthParams::try_from(RawWidth {
            fresh_s: 1.5,
            station_m: 1e-4,
            piece_m: 3e-3,
            profile_step_m: 1e-5,
            piece_min_m: 1e-3,
            corner_m: 8e-4,
            turn_max_rad: 0.1,
            cruise_share: 0.95,
            height_max_rel: 0.75,
            beside_heights: 0.7,
            open_m: 3e-3,
            clear_widths: 1.5,
            stacked_widths: 0.3,
            margin_px: 4.0,
            range_rel: 0.45,
            edge_bias_m: 0.0,
            together_s: 0.3,
            outlier_spreads: 3.0,
            edge_sigma_m: 1e-5,
            sigma_floor_m: 1e-5,
            sigma_max_m: 4e-5,
        })
        .unwrap()
    }

    #[test]
    fn a_value_out_of_range_is_refused_by_name() {
        let raw = RawWidth { range_rel: f64::NAN, ..*params() };
        assert!(WidthParams::try_from(raw).unwrap_err().to_string().starts_with("width.range_rel = NaN"));
        let raw = RawWidth { sigma_max_m: 1e-6, ..*params() };
        assert!(WidthParams::try_from(raw).unwrap_err().to_string().contains("sigma_floor_m"));
    }
}
