//! The filament's section along the print, as gains on the nominal one at knots: what of it is unknown is the melt's heat too.

use super::params::IdentifyParams;
use super::record::At;
use super::series;
use nalgebra::DMatrix;

/// How well the section is known: by widths, or without them by belief alone.
#[derive(Debug, Clone)]
pub(super) struct Gains {
    /// Place among the knots against time: number of the knot before, and the share of the way to the next.
    pub(super) places: Vec<At>,
    /// Inverse root of the covariance of the gain at the knots.
    pub(super) whitener: DMatrix<f64>,
}

impl Gains {
    /// Nothing but the belief: a first gain, and its walk from knot to knot.
    pub(super) fn believed(fed_m: &[At], params: &IdentifyParams) -> Self {
        let (origin_m, knot_m) = (fed_m.first().map_or(0.0, |first| first.1), params.fit.gain_knot_m);
        let places: Vec<At> =
            fed_m.iter().map(|(at_s, at_m)| (*at_s, ((at_m - origin_m) / knot_m).max(0.0))).collect();
        let last = places.iter().map(|place| place.1).fold(0.0, f64::max);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 or more, and few")]
        let knots = last.floor() as usize + 2;
        let walk = params.prior.gain_walk_rel * knot_m.sqrt();
        let whitener = DMatrix::from_fn(knots, knots, |row, column| match (row, column) {
            (0, 0) => 1.0 / params.prior.gain,
            (0, _) => 0.0,
            (row, column) if row == column => 1.0 / walk,
            (row, column) if row == column + 1 => -1.0 / walk,
            _ => 0.0,
        });
        Self { places, whitener }
    }

    /// Knot before a time, and the share of the way to the next one.
    pub(super) fn at(&self, time_s: f64) -> (usize, f64) {
        let place = series::at(&self.places, time_s).max(0.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 or more, and few")]
        let knot = (place.floor() as usize).min(self.whitener.nrows().saturating_sub(2));
        #[allow(clippy::cast_precision_loss, reason = "a count of knots")]
        let before = knot as f64;
        (knot, (place - before).min(1.0))
    }
}
