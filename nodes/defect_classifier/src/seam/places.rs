//! What is usual at each place of the part: a map in part coordinates, one entry to a cell of a seam.

use super::params::SeamParams;
use std::collections::HashMap;
use std::f64::consts::PI;

/// Directions that are told apart over half a turn: walls along and across the bed lie in the middle of theirs.
const SECTORS: f64 = 8.0;
/// Width of a cell across the seam `[m]`: two seams of one wall lie farther apart.
const ACROSS_M: f64 = 2.0e-4;
/// Least share of the stations of earlier layers that a cell needs to be compared with them `[-]`.
const WHOLE: f64 = 0.85;
/// A top whose height differs by less is that of the same layer `[m]`.
const SAME_TOP_M: f64 = 1e-6;

/// Cell of a seam: sector of its direction, along and across it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Place(u8, i32, i32);

/// One look at a seam.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Look {
    /// Middle of the seam on the bed `[m]`.
    pub(super) point_m: [f64; 2],
    /// Unit vector along it, either way.
    pub(super) along: [f64; 2],
    /// Height of its roads' tops `[m]`.
    pub(super) top_m: f64,
    /// Level in the seam and on the crests beside it `[grey]`.
    pub(super) levels: [f64; 2],
    /// What a sound nozzle laid there of the wanted flow `[-]`.
    pub(super) share: f64,
}

/// A cell on the layer that is being laid.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Gathered {
    top_m: f64,
    stations: u32,
    levels: [f64; 2],
    across_m: f64,
    share: f64,
    compared: bool,
    suspect: bool,
}

/// A cell on the layers before.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Known {
    top_m: f64,
    stations: u32,
    across_m: f64,
    share: f64,
    /// Layers in the mean: without the first, which lies on another ground.
    layers: u32,
    mean: f64,
    variance: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Cell {
    now: Option<Gathered>,
    before: Option<Known>,
}

/// A cell beside its own past.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Change {
    /// Ratio of the levels less the usual one `[-]`.
    pub(super) shade: f64,
    /// Variance over earlier layers `[-]`.
    pub(super) variance: f64,
}

/// All cells.
#[derive(Debug, Clone, Default)]
pub(super) struct Places(HashMap<Place, Cell>);

impl Gathered {
    fn ratio(&self) -> f64 {
        self.levels[0] / self.levels[1]
    }

    fn across_m(&self) -> f64 {
        self.across_m / f64::from(self.stations)
    }

    fn share(&self) -> f64 {
        self.share / f64::from(self.stations)
    }

    /// The roads lie as on the layers before, and a sound nozzle lays as much.
    fn is_like(&self, before: &Known, params: &SeamParams) -> bool {
        let most = f64::from(self.stations.max(before.stations));
        let least = f64::from(self.stations.min(before.stations));
        least >= WHOLE * most
            && (self.across_m() - before.across_m).abs() <= params.beside_m
            && (self.share() - before.share).abs() <= params.beside_share
            && (0.0..=params.depth_m).contains(&(self.top_m - before.top_m))
    }
}

impl Cell {
    /// Top of the newest layer in it `[m]`.
    fn top_m(&self) -> Option<f64> {
        self.now.map(|now| now.top_m).or(self.before.map(|before| before.top_m))
    }

    /// The layer is over: what was seen of it becomes the past.
    fn close(&mut self, params: &SeamParams) {
        let Some(now) = self.now.take() else { return };
        if now.stations < params.stations_min {
            return;
        }
        let ratio = now.ratio();
        match &mut self.before {
            Some(before) if now.is_like(before, params) => {
                if now.suspect {
                    return;
                }
                before.layers = before.layers.saturating_add(1);
                let share = params.rate.max(1.0 / f64::from(before.layers));
                let away = ratio - before.mean;
                before.mean += share * away;
                before.variance = (1.0 - share) * (before.variance + share * away * away);
                (before.top_m, before.stations, before.across_m) = (now.top_m, now.stations, now.across_m());
                before.share += share * (now.share() - before.share);
            }
            before => {
                *before = Some(Known {
                    top_m: now.top_m,
                    stations: now.stations,
                    across_m: now.across_m(),
                    share: now.share(),
                    layers: 0,
                    mean: ratio,
                    variance: 0.0,
                });
            }
        }
    }
}

impl Places {
    /// Adds a look, and tells its cell; `None` where a level is no number or the crests are black.
    pub(super) fn add(&mut self, look: &Look, params: &SeamParams) -> Option<Place> {
        let sound = look.levels.iter().all(|level| level.is_finite()) && look.levels[1] > 0.0;
        if !sound {
            return None;
        }
        let (place, across_m) = place(look, params.cell_m);
        if self.0.len() >= params.cells_max as usize && !self.0.contains_key(&place) {
            self.make_room(look.top_m, params);
        }
        let cell = self.0.entry(place).or_default();
        if cell.now.is_some_and(|now| (now.top_m - look.top_m).abs() > SAME_TOP_M) {
            cell.close(params);
        }
        let now = cell.now.get_or_insert(Gathered {
            top_m: look.top_m,
            stations: 0,
            levels: [0.0; 2],
            across_m: 0.0,
            share: 0.0,
            compared: false,
            suspect: false,
        });
        now.stations += 1;
        now.across_m += across_m;
        now.share += look.share;
        now.levels = [0, 1].map(|level| now.levels[level] + look.levels[level]);
        Some(place)
    }

    /// Forgets what lies too deep to be compared; all where the newest layers alone are too many.
    fn make_room(&mut self, top_m: f64, params: &SeamParams) {
        self.0.retain(|_, cell| cell.top_m().is_some_and(|newest_m| top_m - newest_m <= params.depth_m));
        if self.0.len() > params.cells_max as usize / 2 {
            self.0.clear();
        }
    }

    /// The cell beside its past, once a layer, when it is as whole as it was there.
    pub(super) fn compare(&mut self, place: &Place, params: &SeamParams) -> Option<Change> {
        let cell = self.0.get_mut(place)?;
        let (now, before) = (cell.now.as_mut()?, cell.before?);
        let ready = !now.compared
            && now.stations >= params.stations_min
            && before.layers >= params.layers_min
            && now.is_like(&before, params);
        if !ready {
            return None;
        }
        now.compared = true;
        Some(Change { shade: now.ratio() - before.mean, variance: before.variance })
    }

    /// Nothing is learned of this layer there.
    pub(super) fn suspect(&mut self, place: &Place) {
        if let Some(now) = self.0.get_mut(place).and_then(|cell| cell.now.as_mut()) {
            now.suspect = true;
        }
    }
}

/// Cell of a look, and how far from its sector's axis through the origin the seam lies `[m]`.
fn place(look: &Look, cell_m: f64) -> (Place, f64) {
    let angle_rad = look.along[1].atan2(look.along[0]).rem_euclid(PI);
    let sector = (angle_rad / PI * SECTORS).round() % SECTORS;
    let axis_rad = sector * PI / SECTORS;
    let axis = [axis_rad.cos(), axis_rad.sin()];
    let along_m = axis[0] * look.point_m[0] + axis[1] * look.point_m[1];
    let across_m = axis[0] * look.point_m[1] - axis[1] * look.point_m[0];
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "sectors are few, beds a few metres; a cast saturates"
    )]
    let place = Place(sector as u8, (along_m / cell_m).floor() as i32, (across_m / ACROSS_M).floor() as i32);
    (place, across_m)
}
