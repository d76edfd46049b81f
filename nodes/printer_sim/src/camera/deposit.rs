//! What lies on the bed: a height field in tiles, in the true bed frame.

use super::cast::{floor, index, number, signed, single};
use super::params::FieldParams;
use models::bead::stadium;
use std::collections::{HashMap, VecDeque};

/// Cells to a side of a tile.
const SIDE: usize = 64;
const CELLS: usize = SIDE * SIDE;
/// Tiles that know what lay below the newest road; a road passes no more of them within [`SAME_ROAD`] widths.
const RECENT_TILES: usize = 16;
/// No road is drawn wider `[tiles]`: a nozzle spreads the melt over about its own width, what is more heaps up.
const WIDEST_TILES: f64 = 2.0;
/// Way back along the path, in widths, within which a deposit counts as the same road.
const SAME_ROAD: f32 = 2.0;

/// Cross section of a road and its place in height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bead {
    /// Height of the road's crest over the bed `[m]`.
    pub top_m: f64,
    /// Width of the stadium that the deposited volume makes `[m]`.
    pub width_m: f64,
    /// Layer height: from what the road lies on to its crest `[m]`.
    pub height_m: f64,
}

/// Heights over the bed `[m]`, sixteen kilobytes to a tile; empty ones do not exist.
struct Tile {
    z: Box<[f32; CELLS]>,
    recent: Option<Box<Recent>>,
}

/// What the newest road through a cell covers, so that it joins its neighbour once and itself never.
struct Recent {
    below: [f32; CELLS],
    path: [f32; CELLS],
}

impl Recent {
    const NEW: Self = Self { below: [0.0; CELLS], path: [f32::NEG_INFINITY; CELLS] };
}

/// A road's stamp in cells.
struct Stamp {
    from: [f32; 2],
    along: [f32; 2],
    inverse_length2: f32,
    inverse_radius2: f32,
    base: f32,
    height: f32,
    squish: f32,
    /// Way along all roads at the piece's start, its own length, and the way within which a road is the same `[m]`.
    path: f32,
    length: f32,
    same: f32,
}

/// The height field.
pub struct Deposit {
    params: FieldParams,
    cell_m: f64,
    tiles: HashMap<(i32, i32), Tile>,
    recent: VecDeque<(i32, i32)>,
    path_m: f64,
    refused: u64,
}

impl Deposit {
    /// An empty bed with cells of `cell_m`.
    #[must_use]
    pub fn new(params: FieldParams, cell_m: f64) -> Self {
        Self { params, cell_m, tiles: HashMap::new(), recent: VecDeque::new(), path_m: 0.0, refused: 0 }
    }

    /// Lays a straight piece of road. The deposited volume keeps its cross section: what is too little for the
    /// layer's height becomes a round strand, and nothing is laid below a hundredth of that height's strand.
    ///
    /// Across the road `z = h sqrt(1 - (2d/w)^2)`, flattened where it is squished, united with what lies there by
    /// the maximum. Where the road overlaps its neighbour a share of the shared volume raises the seam, at most by
    /// `ridge_share` over the layer. What is wider than two tiles is drawn as wide as these, and counted.
    pub fn lay(&mut self, from_m: [f64; 2], to_m: [f64; 2], bead: Bead) {
        let area_m2 = stadium::area_m2(bead.width_m, bead.height_m);
        let round_m2 = std::f64::consts::FRAC_PI_4 * bead.height_m.powi(2);
        let base_m = bead.top_m - bead.height_m;
        let widest_m = WIDEST_TILES * f64::from(signed(SIDE)) * self.cell_m;
        self.refused += u64::from(bead.width_m > widest_m);
        if area_m2 >= round_m2 {
            self.stamp(from_m, to_m, (bead.width_m.min(widest_m), base_m, bead.height_m));
        } else if area_m2 > 1e-2 * round_m2 {
            let strand_m = bead.height_m * (area_m2 / round_m2).sqrt();
            self.stamp(from_m, to_m, (strand_m, base_m, strand_m));
        }
    }

    /// Lays a piece of loose strand of `diameter_m` whose crest is at `top_m`.
    pub fn drop_strand(&mut self, from_m: [f64; 2], to_m: [f64; 2], (diameter_m, top_m): (f64, f64)) {
        self.stamp(from_m, to_m, (diameter_m, top_m - diameter_m / 2.0, diameter_m / 2.0));
    }

    fn stamp(&mut self, from_m: [f64; 2], to_m: [f64; 2], (width_m, base_m, height_m): (f64, f64, f64)) {
        let finite = [from_m[0], from_m[1], to_m[0], to_m[1], width_m, base_m, height_m];
        if finite.iter().any(|value| !value.is_finite()) {
            self.refused += 1;
            return;
        }
        let length_m = (to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1]);
        let (cell_m, radius_m) = (self.cell_m, width_m / 2.0);
        let low = [0, 1].map(|axis| floor((from_m[axis].min(to_m[axis]) - radius_m) / cell_m));
        let high = [0, 1].map(|axis| floor((from_m[axis].max(to_m[axis]) + radius_m) / cell_m));
        // Cells count from the lower corner of the stamp, so that single precision does on any bed.
        let place =
            |at_m: [f64; 2]| [0, 1].map(|axis| single(at_m[axis] / cell_m - f64::from(low[axis]) - 0.5));
        let (from, to) = (place(from_m), place(to_m));
        let along = [to[0] - from[0], to[1] - from[1]];
        let length2 = along[0] * along[0] + along[1] * along[1];
        let squished = (width_m / height_m - self.params.squish_from)
            / (self.params.squish_full - self.params.squish_from);
        let stamp = Stamp {
            from,
            along,
            inverse_length2: if length2 > 0.0 { 1.0 / length2 } else { 0.0 },
            inverse_radius2: single((cell_m / radius_m).powi(2)),
            base: single(base_m),
            height: single(height_m),
            squish: single(squished.clamp(0.0, 1.0)),
            path: single(self.path_m),
            length: single(length_m),
            same: SAME_ROAD * single(width_m),
        };
        let tile_of = |cell: i32| cell.div_euclid(signed(SIDE));
        for row in tile_of(low[1])..=tile_of(high[1]) {
            for column in tile_of(low[0])..=tile_of(high[0]) {
                self.stamp_tile((column, row), &stamp, (low, high));
            }
        }
        self.path_m += length_m;
    }

    fn stamp_tile(&mut self, key: (i32, i32), stamp: &Stamp, (low, high): ([i32; 2], [i32; 2])) {
        let join = (single(self.params.overlap_share), 1.0 + single(self.params.ridge_share));
        let corner = [key.0 * signed(SIDE), key.1 * signed(SIDE)];
        let Some((tile, recent)) = self.touch(key) else { return };
        for y in low[1].max(corner[1])..=high[1].min(corner[1] + signed(SIDE) - 1) {
            let row = index(y - corner[1]) * SIDE;
            let first = low[0].max(corner[0]);
            let last = high[0].min(corner[0] + signed(SIDE) - 1);
            let off_y = number(y - low[1]) - stamp.from[1];
            for x in first..=last {
                let off_x = number(x - low[0]) - stamp.from[0];
                let Some((crest, path)) = stamp.crest(off_x, off_y) else { continue };
                let at = row + index(x - corner[0]);
                if path - recent.path[at] > stamp.same {
                    recent.below[at] = tile[at];
                }
                recent.path[at] = path;
                let below = recent.below[at] - stamp.base;
                let mut joined = crest;
                if below > 0.0 {
                    joined = (crest + join.0 * below).min(join.1 * stamp.height).max(below).max(crest);
                }
                tile[at] = tile[at].max(stamp.base + joined);
            }
        }
    }

    /// The tile, made where there is none yet, with what the newest road covers.
    fn touch(&mut self, key: (i32, i32)) -> Option<(&mut [f32; CELLS], &mut Recent)> {
        if !self.tiles.contains_key(&key) && self.tiles.len() >= self.params.tiles_max {
            self.refused += 1;
            return None;
        }
        let mut spare = None;
        if self.tiles.get(&key).is_none_or(|tile| tile.recent.is_none()) {
            if self.recent.len() >= RECENT_TILES
                && let Some(oldest) = self.recent.pop_front()
            {
                spare = self.tiles.get_mut(&oldest).and_then(|tile| tile.recent.take());
            }
            self.recent.push_back(key);
        }
        let tile = self.tiles.entry(key).or_insert_with(|| Tile { z: Box::new([0.0; CELLS]), recent: None });
        let recent = tile.recent.get_or_insert_with(|| {
            let mut recent = spare.unwrap_or_else(|| Box::new(Recent::NEW));
            recent.path.fill(f32::NEG_INFINITY);
            recent
        });
        Some((&mut tile.z, recent))
    }

    /// Height at a point of the bed `[m]`.
    #[must_use]
    pub fn height_m(&self, at_m: [f64; 2]) -> f64 {
        let cell = at_m.map(|value| floor(value / self.cell_m));
        let side = signed(SIDE);
        let tile = self.tiles.get(&(cell[0].div_euclid(side), cell[1].div_euclid(side)));
        let at = index(cell[1].rem_euclid(side)) * SIDE + index(cell[0].rem_euclid(side));
        tile.map_or(0.0, |tile| f64::from(tile.z[at]))
    }

    /// Copies heights in cells into `out`, `width` to a row; row 0 is at `top` and rows go to lower y.
    pub(super) fn window(&self, (left, top): (i32, i32), width: usize, out: &mut [f32]) {
        let side = signed(SIDE);
        let inverse_cell = single(1.0 / self.cell_m);
        let rows = signed(out.len() / width);
        out.fill(0.0);
        for tile_row in (top - rows + 1).div_euclid(side)..=top.div_euclid(side) {
            for column in left.div_euclid(side)..=(left + signed(width) - 1).div_euclid(side) {
                let Some(tile) = self.tiles.get(&(column, tile_row)) else { continue };
                let first = left.max(column * side);
                let count = index((left + signed(width)).min((column + 1) * side) - first);
                for y in (top - rows + 1).max(tile_row * side)..=top.min(tile_row * side + side - 1) {
                    let from = index(y - tile_row * side) * SIDE + index(first - column * side);
                    let to = index(top - y) * width + index(first - left);
                    let target = &mut out[to..to + count];
                    for (target, z) in target.iter_mut().zip(&tile.z[from..from + count]) {
                        *target = z * inverse_cell;
                    }
                }
            }
        }
    }

    /// Side of a cell `[m]`.
    #[must_use]
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// Memory of the tiles `[bytes]`; at most `tiles_max` times 16 KiB and half a megabyte.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.tiles.len() * size_of::<[f32; CELLS]>() + self.recent.len() * size_of::<Recent>()
    }

    /// Pieces of road that were not drawn as they are: no tile left, not a number, or wider than any road.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }
}

impl Stamp {
    /// Height of the road over its base at a cell and the way along it, if the cell is under it.
    fn crest(&self, off_x: f32, off_y: f32) -> Option<(f32, f32)> {
        let share = (off_x * self.along[0] + off_y * self.along[1]) * self.inverse_length2;
        let share = share.clamp(0.0, 1.0);
        let (x, y) = (off_x - share * self.along[0], off_y - share * self.along[1]);
        let u = (x * x + y * y) * self.inverse_radius2;
        let crest = || self.height * (1.0 - u * (1.0 - self.squish + self.squish * u)).sqrt();
        (u < 1.0).then(|| (crest(), self.path + share * self.length))
    }
}
