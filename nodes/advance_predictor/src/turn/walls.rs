//! Where the walls of the newest layer were laid: roads that fill an area turn there.

use super::memory::cell;
use super::params::TurnParams;
use super::path::Piece;
use std::collections::HashSet;

/// Steps that are looked ahead at most: 30 mm of the shipped reach, whatever the speed of a move says.
const STEPS_MAX: u32 = 200;

/// Walls of one layer, by place; those of the layer before until the first of the next one, since some slicers fill first.
#[derive(Debug, Clone, Default)]
pub(super) struct Walls {
    cells: HashSet<(i64, i64)>,
    layer: Option<u32>,
}

impl Walls {
    /// Adds a piece where it is a wall; no more places than points are remembered.
    pub(super) fn add(&mut self, piece: &Piece, params: &TurnParams) {
        if piece.fill || !piece.deposit {
            return;
        }
        if piece.layer != self.layer {
            self.cells.clear();
            self.layer = piece.layer;
        }
        let room = params.memory_points as usize;
        let (mut back_m, mut steps) = (0.0, 0);
        while back_m < piece.length_m && steps < room && self.cells.len() < room {
            self.cells.insert(cell(along(piece.end_m, piece.direction, -back_m), params));
            back_m += step_m(params);
            steps += 1;
        }
    }

    /// Way from the end of a piece to the next wall if the path bends on by `curvature_1_m`, left positive, 0 straight
    /// on; `way_m` where none is nearer.
    pub(super) fn way_m(
        &self,
        piece: &Piece,
        (curvature_1_m, way_m): (f64, f64),
        params: &TurnParams,
    ) -> f64 {
        let step_m = step_m(params);
        let (sin, cos) = (curvature_1_m * step_m).sin_cos();
        let (mut at_m, mut direction) = (piece.end_m, piece.direction);
        for step in 1..=STEPS_MAX {
            let gone_m = f64::from(step) * step_m;
            if gone_m > way_m {
                break;
            }
            direction = [cos * direction[0] - sin * direction[1], sin * direction[0] + cos * direction[1]];
            at_m = along(at_m, direction, step_m);
            if self.cells.contains(&cell(at_m, params)) {
                return gone_m;
            }
        }
        way_m
    }
}

/// Between two places that are looked at: half of what is the same place.
fn step_m(params: &TurnParams) -> f64 {
    0.5 * params.memory_reach_m
}

fn along(from_m: [f64; 2], direction: [f64; 2], way_m: f64) -> [f64; 2] {
    [0, 1].map(|axis| from_m[axis] + way_m * direction[axis])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensation::tests::params;
    use crate::turn::tests::piece;

    fn wall(from_mm: [f64; 2], to_mm: [f64; 2], layer: u32) -> Piece {
        Piece { layer: Some(layer), ..piece(from_mm, to_mm) }
    }

    /// A wall at x = 10 mm; the path ends at x = 6 mm and goes towards it.
    fn towards() -> (Walls, Piece) {
        let mut walls = Walls::default();
        walls.add(&wall([10.0, -5.0], [10.0, 5.0], 0), &params().turn);
        (walls, Piece { fill: true, ..piece([5.0, 0.0], [6.0, 0.0]) })
    }

    fn way_mm(walls: &Walls, from: &Piece, radius_mm: f64) -> f64 {
        1e3 * walls.way_m(from, (1e3 / radius_mm, 6e-3), &params().turn)
    }

    /// 4 mm to it, told to the reach of 0.3 mm; a circle of 1 or 1.5 mm turns back before it. Where no wall is,
    /// the way asked for comes back.
    #[test]
    fn a_wall_ahead_is_met_where_it_was_laid() {
        let (walls, path) = towards();
        assert!((way_mm(&walls, &path, f64::INFINITY) - 4.0).abs() <= 0.3);
        for radius_mm in [1.0, -1.5] {
            assert!((way_mm(&walls, &path, radius_mm) - 6.0).abs() < 1e-9, "{radius_mm}");
        }
        // One of 8 mm meets it at asin(1/2): 8 pi / 6 = 4.19 mm.
        assert!((way_mm(&walls, &path, 8.0) - 4.19).abs() <= 0.35);
        assert!((way_mm(&Walls::default(), &path, f64::INFINITY) - 6.0).abs() < 1e-9);
    }

    /// Roads that fill and travels are none; the first wall of another layer takes the older ones away.
    #[test]
    fn walls_are_those_of_the_newest_layer() {
        let (mut walls, path) = towards();
        let beside = wall([8.0, -5.0], [8.0, 5.0], 1);
        walls.add(&Piece { fill: true, ..beside }, &params().turn);
        walls.add(&Piece { deposit: false, ..beside }, &params().turn);
        assert!((way_mm(&walls, &path, f64::INFINITY) - 4.0).abs() <= 0.3);
        walls.add(&wall([0.0, 20.0], [1.0, 20.0], 1), &params().turn);
        assert!((way_mm(&walls, &path, f64::INFINITY) - 6.0).abs() < 1e-9);
    }

    /// A move of any length and speed takes no more steps than there is room, and is not looked along without end.
    #[test]
    fn walls_are_bounded() {
        let params = params().turn;
        let (mut walls, path) = towards();
        for (length_m, end_m) in [(1e12, [1e12, 3.0]), (1e300, [1e300, 0.0])] {
            walls.add(&Piece { length_m, end_m, ..wall([0.0, 0.0], [1.0, 0.0], 0) }, &params);
            assert!(walls.cells.len() <= params.memory_points as usize);
        }
        let mut away = path;
        away.direction = [-1.0, 0.0];
        assert!((walls.way_m(&away, (0.0, 1e9), &params) - 1e9).abs() < 1.0);
    }
}
