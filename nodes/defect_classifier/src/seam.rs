//! Shade of the seams between neighbouring roads, beside the same places on the layers below.
//!
//! Seen from straight above walls never narrow: beside a thin road the layers below show. What follows the flow there is
//! the valley between two roads that lie side by side. A fifth less melt opens it down to the layer below, a fifth more
//! fills it. How dark a valley looks depends on the light and on the way the seam runs far more than on the flow, so each
//! place of the part is compared with itself: level in the seam over the level on the crests beside it, less what that
//! ratio was there on earlier layers. Only places where this layer's roads lie as those of the earlier layers count: walls
//! of prismatic parts, skins whose lines repeat, where a sound nozzle lays as much as there. The first layer of an outline
//! is not learned: what lies below it, bed or other roads, shades its seams otherwise, and on the bed its roads are
//! higher and wider too. Nothing is told of the next layers either, and a lamp that is moved looks like a change of the
//! flow for as long as the layers below remember the old light.
//!
//! One reading of a fifth less melt may lie within what a sound print shows, ten of them in a row do not: what readings
//! lie below their usual shade beyond a slack is added up (E. S. Page, Biometrika 41, 1954), `S = max(0, S - n - k)` with
//! `n` the reading and `k` the slack in standard deviations; none counts for more than what is still learned.

mod params;
mod places;
#[cfg(test)]
mod tests;

pub use params::{RawSeam, SeamParams};

use crate::camera::Camera;
use crate::path::{PathHistory, Road};
use crate::surroundings::in_view;
use crate::width::WidthParams;
use crate::width::profile::Pixels;
use crate::width::stretch::{self, Piece, Station};
use models::units::Seconds;
use opencv::core::{Mat, MatTraitConst, MatTraitConstManual};
use places::{Change, Look, Place, Places};
use std::collections::{BTreeSet, HashSet};

/// Tops whose heights differ by less belong to one layer `[m]`.
const SAME_TOP_M: f64 = 1e-6;

/// How much darker or brighter seams are than they were at the same places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeamReading {
    /// Mean change of the ratio of seam to crests, below 0: darker `[-]`.
    pub shade: f64,
    /// Its standard deviation on a sound print `[-]`.
    pub sigma: f64,
    /// Cells in it.
    pub cells: u32,
    /// How far this and the readings before it together keep below what is usual, in their standard deviations `[-]`,
    /// 0 to `drift_max_sigmas`.
    pub drift_sigmas: f64,
}

/// Measures seams in frames. Knows no clock.
#[derive(Debug, Clone)]
pub struct SeamGauge {
    params: SeamParams,
    /// How straight and steady stretches are found.
    stretch: WidthParams,
    places: Places,
    /// Stations of the newest layer that need no other look, by their place to the bit.
    done: HashSet<[u64; 2]>,
    top_m: f64,
    /// Cells too few for a reading yet, with the exposure that made them whole.
    waiting: Vec<(Seconds, Place, Change)>,
    /// Mean square of sound readings so far `[-]`.
    shared: f64,
    /// Sum of what readings lay below their usual shade beyond the slack, in standard deviations `[-]`.
    drift_sigmas: f64,
}

impl SeamGauge {
    /// A gauge that has seen nothing; `stretch` tells what a straight and steady road is.
    #[must_use]
    pub fn new(params: SeamParams, stretch: &WidthParams) -> Self {
        Self {
            params,
            stretch: stretch.with_fresh(params.fresh_s),
            places: Places::default(),
            done: HashSet::new(),
            top_m: f64::NEG_INFINITY,
            waiting: Vec::new(),
            shared: params.shared_sigma[0].powi(2),
            drift_sigmas: 0.0,
        }
    }

    /// Forgets what readings said together: after a pause the flow may be another.
    pub fn forget_drift(&mut self) {
        self.drift_sigmas = 0.0;
    }

    /// Forgets the part.
    pub fn clear(&mut self) {
        self.forget_drift();
        self.places = Places::default();
        self.done.clear();
        self.waiting.clear();
        self.shared = self.params.shared_sigma[0].powi(2);
    }

    /// What the seams that were looked at for the first time tell; `None` where they are too few or their places new.
    /// `share` is what a sound nozzle laid then of the wanted flow.
    ///
    /// # Errors
    /// A picture operation that failed.
    pub fn on_frame(
        &mut self,
        grey: &Mat,
        (path, exposed): (&PathHistory, Seconds),
        view: (&Camera, [f64; 2]),
        share: impl Fn(Seconds) -> f64,
    ) -> Result<Option<SeamReading>, opencv::Error> {
        let pieces = stretch::pieces(path, exposed, &self.stretch);
        let Some(newest) = pieces.last() else { return Ok(None) };
        let top_m = newest.top_m;
        if (top_m - self.top_m).abs() > SAME_TOP_M {
            self.done.clear();
            self.waiting.clear();
            self.top_m = top_m;
        }
        let pixels =
            Pixels { levels: grey.data_bytes()?, columns: usize::try_from(grey.cols()).unwrap_or(0) };
        let mut roads = in_view(path, exposed, view);
        roads.retain(|(road, _)| (road.top_m - top_m).abs() <= SAME_TOP_M);
        // In order: sums are the same to the bit whenever the same frames are judged.
        let mut touched = BTreeSet::new();
        for piece in pieces.iter().filter(|piece| (piece.top_m - top_m).abs() <= SAME_TOP_M) {
            let sound = share(piece.laid);
            for station in &piece.stations {
                let id = station.point_m.map(f64::to_bits);
                if self.done.contains(&id) {
                    continue;
                }
                let Some(mut looks) = self.look(piece, station, &roads, (&pixels, view)) else { continue };
                looks.iter_mut().flatten().for_each(|look| look.share = sound);
                self.done.insert(id);
                touched.extend(looks.iter().flatten().filter_map(|look| self.places.add(look, &self.params)));
            }
        }
        self.waiting.retain(|(whole, ..)| exposed.0 - whole.0 <= self.params.fresh_s);
        for place in touched {
            let change = self.places.compare(&place, &self.params);
            self.waiting.extend(change.map(|change| (exposed, place, change)));
        }
        Ok(self.read())
    }

    /// One reading from the cells that became whole since the last one, where they are enough.
    fn read(&mut self) -> Option<SeamReading> {
        let params = &self.params;
        let count = u32::try_from(self.waiting.len()).unwrap_or(u32::MAX);
        if count < params.cells_min {
            return None;
        }
        let changes = std::mem::take(&mut self.waiting);
        // Cells whose ratio scattered over the layers weigh less.
        let floor = params.cell_sigma.powi(2);
        let weights: Vec<f64> = changes.iter().map(|(.., change)| 1.0 / (floor + change.variance)).collect();
        let total: f64 = weights.iter().sum();
        let weighed = changes.iter().zip(&weights).map(|((.., change), weight)| weight * change.shade);
        let shade = weighed.sum::<f64>() / total;
        let sigma = (1.0 / total + self.shared).sqrt();
        let sigmas = shade / sigma;
        let counts = sigmas.max(-params.learn_max_sigmas) + params.drift_slack_sigmas;
        self.drift_sigmas = (self.drift_sigmas - counts).clamp(0.0, params.drift_max_sigmas);
        let drifted = self.drift_sigmas > params.learn_max_sigmas - params.drift_slack_sigmas;
        if drifted || sigmas.abs() > params.learn_max_sigmas {
            changes.iter().for_each(|(_, place, _)| self.places.suspect(place));
        } else {
            let [_, least, most] = params.shared_sigma.map(|sigma| sigma * sigma);
            self.shared += params.shared_rate * (shade * shade - self.shared);
            self.shared = self.shared.clamp(least, most);
        }
        Some(SeamReading { shade, sigma, cells: count, drift_sigmas: self.drift_sigmas })
    }

    /// The seams beside a station to roads laid before it, left and right; `None` while it is hidden.
    fn look(
        &self,
        piece: &Piece,
        station: &Station,
        roads: &[(Road, f64)],
        (pixels, (camera, tool_m)): (&Pixels<'_>, (&Camera, [f64; 2])),
    ) -> Option<[Option<Look>; 2]> {
        let margin_px = self.stretch.margin_px;
        if !camera.sees(camera.pixel(tool_m, station.point_m), margin_px) {
            return None;
        }
        let mut looks = [None; 2];
        for (look, side) in looks.iter_mut().zip([1.0, -1.0]) {
            let Some(apart_m) = self.neighbour(piece, (station, side), roads) else { continue };
            let at =
                |away_m: f64| [0, 1].map(|axis| station.point_m[axis] + side * away_m * station.left[axis]);
            if !camera.sees(camera.pixel(tool_m, at(apart_m)), margin_px) {
                return None;
            }
            let strip = |middle_m: f64, half_m: f64| {
                let reach = (half_m / camera.scale_m).round();
                let mut sum = 0.0;
                let mut away = -reach;
                while away <= reach {
                    sum += pixels.at(camera.pixel(tool_m, at(middle_m + away * camera.scale_m)))?;
                    away += 1.0;
                }
                Some(sum / (2.0 * reach + 1.0))
            };
            let crests = [strip(0.0, self.params.crest_m)?, strip(apart_m, self.params.crest_m)?];
            let valley = strip(0.5 * apart_m, self.params.valley_m)?;
            *look = Some(Look {
                point_m: at(0.5 * apart_m),
                along: [station.left[1], -station.left[0]],
                top_m: piece.top_m,
                levels: [valley, 0.5 * (crests[0] + crests[1])],
                share: 1.0,
            });
        }
        Some(looks)
    }

    /// How far beside a station the centre line of a road laid before lies `[m]`, where one lies alongside.
    fn neighbour(
        &self,
        piece: &Piece,
        (station, side): (&Station, f64),
        roads: &[(Road, f64)],
    ) -> Option<f64> {
        let [least_m, most_m] = self.params.pitch_rel.map(|share| share * piece.width_m);
        let least_cos = self.params.parallel_rad.cos();
        let beside = |(road, laid_m): &(Road, f64)| {
            if road.start.0 >= piece.laid.0 {
                return None;
            }
            let along = road.along();
            let away_m = [0, 1].map(|axis| station.point_m[axis] - road.from_m[axis]);
            let way_m = away_m[0] * along[0] + away_m[1] * along[1];
            let parallel = along[0] * station.left[1] - along[1] * station.left[0];
            if way_m < 0.0 || way_m > *laid_m || parallel.abs() < least_cos {
                return None;
            }
            // From the station to the road's line, along the station's normal.
            let aside_m = along[0] * away_m[1] - along[1] * away_m[0];
            let apart_m = -side * parallel.signum() * aside_m;
            (least_m..=most_m).contains(&apart_m).then_some(apart_m)
        };
        roads.iter().filter_map(beside).min_by(f64::total_cmp)
    }
}
