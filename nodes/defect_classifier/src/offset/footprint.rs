//! Where on the bed anything was laid, as commanded, and how high: two bytes a cell.

use crate::path::Road;

/// Heights are kept in steps of 10 um: 0.65 m at most.
const STEP_M: f64 = 1e-5;

/// What lies at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Lies {
    /// Part, near the level that was asked for or above it.
    Part,
    /// Part far below: dark, out of focus, like part or like bed.
    Deep,
    /// Nothing was laid.
    Bed,
}

/// The bed as cells; bounded by its size.
#[derive(Debug, Clone)]
pub(crate) struct Footprint {
    corner_m: [f64; 2],
    cell_m: f64,
    cells: [usize; 2],
    /// Top of what was laid there last, in steps; 0 for nothing.
    tops: Vec<u16>,
}

impl Footprint {
    /// An empty bed from `low_m` to `high_m`.
    pub(crate) fn new(low_m: [f64; 2], high_m: [f64; 2], cell_m: f64) -> Self {
        let cells = [0, 1].map(|axis| index((high_m[axis] - low_m[axis]) / cell_m) + 1);
        Self { corner_m: low_m, cell_m, cells, tops: vec![0; cells[0] * cells[1]] }
    }

    /// Marks the first `laid_m` of a road.
    pub(crate) fn mark(&mut self, road: &Road, laid_m: f64) {
        let half_m = 0.5 * road.width_m;
        let top = steps(road.top_m).max(1);
        let (from, to, along) = (road.from_m, road.point_m(laid_m), road.along());
        let row_of = |y_m: f64| (y_m - self.corner_m[1]) / self.cell_m;
        let rows = (row_of(from[1].min(to[1]) - half_m), row_of(from[1].max(to[1]) + half_m));
        let columns = |x_m: f64| (x_m - self.corner_m[0]) / self.cell_m;
        let wide = (columns(from[0].min(to[0]) - half_m), columns(from[0].max(to[0]) + half_m));
        if rows.1 < 0.0 || wide.1 < 0.0 || !(rows.0.is_finite() && wide.0.is_finite()) {
            return;
        }
        for row in index(rows.0)..=index(rows.1).min(self.cells[1] - 1) {
            for column in index(wide.0)..=index(wide.1).min(self.cells[0] - 1) {
                let [x_m, y_m] = self.centre_m([column, row]);
                let way_m = ((x_m - from[0]) * along[0] + (y_m - from[1]) * along[1]).clamp(0.0, laid_m);
                let off_m = [x_m - from[0] - way_m * along[0], y_m - from[1] - way_m * along[1]];
                // Squares: a root for each cell of each road is the dearest line of a print.
                if off_m[0] * off_m[0] + off_m[1] * off_m[1] <= half_m * half_m {
                    self.tops[row * self.cells[0] + column] = top;
                }
            }
        }
    }

    /// What lies at a place, for one who looks at the level `level_m` and sees `depth_m` below it well.
    pub(crate) fn at(&self, place_m: [f64; 2], (level_m, depth_m): (f64, f64)) -> Lies {
        let cell = [0, 1].map(|axis| (place_m[axis] - self.corner_m[axis]) / self.cell_m);
        if cell.iter().any(|value| !value.is_sign_positive() || value.is_nan()) {
            return Lies::Bed;
        }
        let [column, row] = cell.map(index);
        if column >= self.cells[0] || row >= self.cells[1] {
            return Lies::Bed;
        }
        match self.tops[row * self.cells[0] + column] {
            0 => Lies::Bed,
            top if top >= steps(level_m - depth_m) => Lies::Part,
            _ => Lies::Deep,
        }
    }

    fn centre_m(&self, cell: [usize; 2]) -> [f64; 2] {
        [0, 1].map(|axis| {
            #[expect(clippy::cast_precision_loss, reason = "cells of a bed are far below 2^52")]
            let count = cell[axis] as f64;
            self.corner_m[axis] + (count + 0.5) * self.cell_m
        })
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a cast saturates, as meant")]
fn steps(height_m: f64) -> u16 {
    (height_m / STEP_M).round() as u16
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "negative becomes 0, as meant")]
fn index(value: f64) -> usize {
    value.max(0.0) as usize
}
