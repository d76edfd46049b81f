//! Parameters of the seams' shade.

use models::params::{ParamError, in_range, ordered};
use serde::Deserialize;

/// How the shade of seams is measured and held against earlier layers. Built only from a valid [`RawSeam`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawSeam")]
pub struct SeamParams(RawSeam);

/// The `seam` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSeam {
    /// Roads laid longer before the exposure are not looked at for the first time `[s]`.
    pub fresh_s: f64,
    /// Least and largest distance of two roads' centre lines that share a seam, in widths `[-]`.
    pub pitch_rel: [f64; 2],
    /// Largest angle between two roads that share a seam `[rad]`.
    pub parallel_rad: f64,
    /// Half of the strip around the middle of a seam that is averaged `[m]`.
    pub valley_m: f64,
    /// Half of the strip around a centre line that is averaged `[m]`.
    pub crest_m: f64,
    /// Length of a cell along the seam `[m]`.
    pub cell_m: f64,
    /// Cells kept; when there are more, the deep ones are forgotten `[cells]`.
    pub cells_max: u32,
    /// Stations that make a cell `[stations]`.
    pub stations_min: u32,
    /// How far a seam may lie beside that of an earlier layer to be the same place `[m]`.
    pub beside_m: f64,
    /// How far a sound nozzle's share of the wanted flow may lie beside that of the earlier layers `[-]`.
    pub beside_share: f64,
    /// Layers in a cell's memory before it tells something `[layers]`.
    pub layers_min: u32,
    /// Share of a new layer in what is usual in a cell `[-]`.
    pub rate: f64,
    /// A memory is dropped when the newest layer in it lies deeper `[m]`.
    pub depth_m: f64,
    /// Cells that make a reading of a frame `[cells]`.
    pub cells_min: u32,
    /// Standard deviation of one cell's ratio beside its memory, least `[-]`.
    pub cell_sigma: f64,
    /// Standard deviation of readings on a sound print before any was seen, and the least and largest that is believed:
    /// light and gloss decide how much a percent of flow shows `[-]`.
    pub shared_sigma: [f64; 3],
    /// Share of a new reading in that deviation's square `[-]`.
    pub shared_rate: f64,
    /// Readings that many standard deviations off are not learned, nor those with a drift beyond that less the slack;
    /// in the drift none counts for more `[-]`.
    pub learn_max_sigmas: f64,
    /// Standard deviations below the usual shade that add nothing to the drift; half of what is to be found `[-]`.
    pub drift_slack_sigmas: f64,
    /// Largest drift, above `learn_max_sigmas`: how fast sound readings take it back `[-]`.
    pub drift_max_sigmas: f64,
}

impl std::ops::Deref for SeamParams {
    type Target = RawSeam;

    fn deref(&self) -> &RawSeam {
        &self.0
    }
}

impl TryFrom<RawSeam> for SeamParams {
    type Error = ParamError;

    fn try_from(raw: RawSeam) -> Result<Self, ParamError> {
        in_range("seam.fresh_s", raw.fresh_s, "s", (0.05, 60.0))?;
        in_range("seam.pitch_rel", raw.pitch_rel[0], "-", (0.01, 2.0))?;
        ordered(("seam.pitch_rel[0]", raw.pitch_rel[0]), ("seam.pitch_rel[1]", raw.pitch_rel[1]))?;
        in_range("seam.pitch_rel", raw.pitch_rel[1], "-", (0.5, 2.0))?;
        in_range("seam.parallel_rad", raw.parallel_rad, "rad", (0.0, 0.5))?;
        in_range("seam.valley_m", raw.valley_m, "m", (0.0, 5e-4))?;
        in_range("seam.crest_m", raw.crest_m, "m", (0.0, 5e-4))?;
        in_range("seam.cell_m", raw.cell_m, "m", (2e-4, 2e-2))?;
        in_range("seam.cells_max", f64::from(raw.cells_max), "cells", (16.0, 1e6))?;
        in_range("seam.stations_min", f64::from(raw.stations_min), "stations", (1.0, 1e3))?;
        in_range("seam.beside_m", raw.beside_m, "m", (1e-6, 1e-3))?;
        in_range("seam.beside_share", raw.beside_share, "-", (0.0, 1.0))?;
        in_range("seam.layers_min", f64::from(raw.layers_min), "layers", (1.0, 1e3))?;
        in_range("seam.rate", raw.rate, "-", (0.0, 1.0))?;
        in_range("seam.depth_m", raw.depth_m, "m", (1e-4, 0.1))?;
        in_range("seam.cells_min", f64::from(raw.cells_min), "cells", (1.0, 1e3))?;
        in_range("seam.cell_sigma", raw.cell_sigma, "-", (1e-4, 10.0))?;
        let [first, least, most] = raw.shared_sigma;
        in_range("seam.shared_sigma", least, "-", (1e-4, 1.0))?;
        in_range("seam.shared_sigma", most, "-", (least, 1.0))?;
        in_range("seam.shared_sigma", first, "-", (least, most))?;
        in_range("seam.shared_rate", raw.shared_rate, "-", (0.0, 1.0))?;
        in_range("seam.learn_max_sigmas", raw.learn_max_sigmas, "-", (1.0, 100.0))?;
        in_range("seam.drift_slack_sigmas", raw.drift_slack_sigmas, "-", (0.1, 10.0))?;
        ordered(
            ("seam.drift_slack_sigmas", raw.drift_slack_sigmas),
            ("seam.learn_max_sigmas", raw.learn_max_sigmas),
        )?;
        ordered(
            ("seam.learn_max_sigmas", raw.learn_max_sigmas),
            ("seam.drift_max_sigmas", raw.drift_max_sigmas),
        )?;
        in_range("seam.drift_max_sigmas", raw.drift_max_sigmas, "-", (1.0, 1000.0))?;
        Ok(Self(raw))
    }
}
