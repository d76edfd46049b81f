//! Straight, steadily laid stretches of fresh road, cut into pieces that are measured as one.

use super::ground;
use super::params::WidthParams;
use crate::path::{PathHistory, Road};
use models::units::Seconds;

/// A place on a road's centre line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// On the bed `[m]`.
    pub point_m: [f64; 2],
    /// Unit vector to the left of the direction of travel.
    pub left: [f64; 2],
}

/// A piece of road measured as one.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Places along it.
    pub stations: Vec<Station>,
    /// Width that the slicer asked for `[m]`.
    pub width_m: f64,
    /// Its height `[m]`.
    pub height_m: f64,
    /// Height of its top over the bed `[m]`.
    pub top_m: f64,
    /// When its middle was laid.
    pub laid: Seconds,
}

/// One stretch while it is gathered.
#[derive(Default)]
struct Stretch {
    stations: Vec<(Station, Seconds)>,
    width_m: f64,
    height_m: f64,
    top_m: f64,
    last: Option<(u64, [f64; 2])>,
}

/// Pieces of all roads laid within `fresh_s` before `exposed`, oldest first.
#[must_use]
pub fn pieces(path: &PathHistory, exposed: Seconds, params: &WidthParams) -> Vec<Piece> {
    let (mut found, mut stretch) = (Vec::new(), Stretch::default());
    let from_s = exposed.0 - params.fresh_s;
    let begun = |road: &&Road| road.start.0 >= from_s;
    let count = path.roads(exposed).rev().take_while(begun).count();
    // One more: it may have begun earlier and ended within the time.
    let total = path.roads(exposed).count();
    for road in path.roads(exposed).skip(total.saturating_sub(count + 1)) {
        let along = road.along();
        let joins = stretch.last.is_some_and(|(run, before)| {
            let turn_rad = (before[0] * along[1] - before[1] * along[0])
                .atan2(before[0] * along[0] + before[1] * along[1]);
            run == road.run && turn_rad.abs() <= params.turn_max_rad
        });
        let near = |a_m: f64, b_m: f64| (a_m - b_m).abs() <= 1e-3 * road.width_m;
        let same = near(stretch.width_m, road.width_m) && near(stretch.top_m, road.top_m);
        let pressed = ground::pressed(road, params);
        if !(joins && same && pressed) {
            stretch.cut(params, &mut found);
        }
        if !pressed {
            continue;
        }
        stretch.width_m = road.width_m;
        stretch.height_m = road.height_m;
        stretch.top_m = road.top_m;
        stretch.last = Some((road.run, along));
        stretch.gather((path, road), (Seconds(from_s), exposed), params, &mut found);
    }
    stretch.cut(params, &mut found);
    found
}

/// Whether a road is laid at nearly its highest speed there.
fn steady(road: &Road, way_m: f64, share: f64) -> bool {
    let profile = &road.profile;
    let up_m = 0.5 * (profile.entry_m_s + profile.cruise_m_s) * profile.accel_s;
    let down_m = 0.5 * (profile.exit_m_s + profile.cruise_m_s) * profile.decel_s;
    let (from_m_s, ramp_m, along_m) = if way_m < up_m {
        (profile.entry_m_s, up_m, way_m)
    } else if road.length_m - way_m < down_m {
        (profile.exit_m_s, down_m, road.length_m - way_m)
    } else {
        return true;
    };
    // v^2 grows evenly along a ramp.
    let speed_sq = from_m_s.powi(2) + (profile.cruise_m_s.powi(2) - from_m_s.powi(2)) * along_m / ramp_m;
    speed_sq.sqrt() >= share * profile.cruise_m_s
}

impl Stretch {
    /// Adds the stations of a road; a slow or an old place ends the stretch.
    fn gather(
        &mut self,
        (path, road): (&PathHistory, &Road),
        (from, exposed): (Seconds, Seconds),
        params: &WidthParams,
        found: &mut Vec<Piece>,
    ) {
        let along = road.along();
        let left = [-along[1], along[0]];
        let laid_m = path.laid_m(road, exposed);
        let mut way_m = 0.5 * params.station_m;
        while way_m < laid_m {
            let laid = path.laid_at(road, way_m);
            match laid.filter(|laid| laid.0 >= from.0 && steady(road, way_m, params.cruise_share)) {
                Some(laid) => self.stations.push((Station { point_m: road.point_m(way_m), left }, laid)),
                None => self.cut(params, found),
            }
            way_m += params.station_m;
        }
    }

    /// Cuts what was gathered into pieces without its ends, and starts anew.
    fn cut(&mut self, params: &WidthParams, found: &mut Vec<Piece>) {
        let stations = std::mem::take(&mut self.stations);
        self.last = None;
        let ends = steps(params.corner_m / params.station_m);
        if stations.len() <= 2 * ends {
            return;
        }
        let inner = &stations[ends..stations.len() - ends];
        let (most, least) =
            (steps(params.piece_m / params.station_m), steps(params.piece_min_m / params.station_m));
        for chunk in inner.chunks(most.max(1)).filter(|chunk| chunk.len() >= least) {
            found.push(Piece {
                stations: chunk.iter().map(|(station, _)| *station).collect(),
                width_m: self.width_m,
                height_m: self.height_m,
                top_m: self.top_m,
                laid: chunk[chunk.len() / 2].1,
            });
        }
    }
}

/// A ratio of lengths as a number of stations.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a small ratio of checked parameters"
)]
fn steps(ratio: f64) -> usize {
    ratio.round().clamp(0.0, 1e6) as usize
}
