//! The filament's section along the print, as gains on the nominal one at knots: what of it is unknown is the melt's heat too.

use super::params::IdentifyParams;
use super::record::At;
use super::series;
use nalgebra::DMatrix;

/// Knots of a long print `[-]`: the time of a fit grows with their number squared, and no width tells one from the next.
const KNOTS_MOST: f64 = 40.0;

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
        let origin_m = fed_m.first().map_or(0.0, |first| first.1);
        let length_m = fed_m.iter().map(|fed| fed.1 - origin_m).fold(0.0, f64::max);
        let knot_m = params.fit.gain_knot_m.max(length_m / KNOTS_MOST);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::ConfigDir;
    use std::path::Path;

    /// Of a walk from `gain` on the variance grows by `gain_walk_rel^2` over each metre, however far apart the knots are.
    #[test]
    fn the_belief_is_a_walk_along_the_filament() {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config"));
        let params = IdentifyParams::load(&ConfigDir::find(Some(folder)).unwrap()).unwrap();
        for (length_m, most) in [(0.0, 2), (0.63, 12), (30.0, 42)] {
            let gains = Gains::believed(&[(0.0, 5.0), (100.0, 5.0 + length_m)], &params);
            let root = gains.whitener.clone().try_inverse().unwrap();
            let covariance = &root * root.transpose();
            let last = covariance.nrows() - 1;
            assert!((most - 2..most).contains(&last), "{length_m} m: {last}");
            // Where the print ends, in knots: so far apart they are.
            let place = gains.places[1].1;
            let knot_m = if place > 0.0 { length_m / place } else { params.fit.gain_knot_m };
            #[allow(clippy::cast_precision_loss, reason = "a count of knots")]
            let walked_m = knot_m * last as f64;
            let wanted = params.prior.gain.powi(2) + params.prior.gain_walk_rel.powi(2) * walked_m;
            assert!((covariance[(last, last)] / wanted - 1.0).abs() < 1e-9, "{length_m} m");
        }
    }
}
