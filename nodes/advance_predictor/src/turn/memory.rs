//! Where the path has been, and what it did next: walls repeat from layer to layer.

use super::params::TurnParams;
use super::path::Piece;
use std::collections::{HashMap, VecDeque};

/// Best matches that are asked.
const ASKED: usize = 4;
/// Way beyond the one asked for within which a turn still tells how near the edge is `[m]`.
pub(super) const BEYOND_M: f64 = 2e-3;

/// A point of the path, the end of one piece.
#[derive(Debug, Clone, Copy)]
struct Point {
    piece: Piece,
    /// Signed turn at its start `[rad]`.
    turn_before_rad: f64,
}

/// The newest points of the path, by place.
#[derive(Debug, Clone)]
pub(super) struct Memory {
    points: VecDeque<Point>,
    /// Number of the oldest point that is kept.
    first: u64,
    cells: HashMap<(i64, i64), Vec<u64>>,
}

/// What the memory says of the way behind a point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Recalled {
    /// Share of the matches; 0 where there is none, 1 with [`ASKED`] of them.
    pub(super) matched: f64,
    /// Share of the matches after which a turn came within the way asked for.
    pub(super) turned: f64,
    /// Mean way to those turns `[m]`.
    pub(super) way_m: f64,
    /// Mean of the way asked for less the way to the next turn, no less than -[`BEYOND_M`] `[m]`.
    pub(super) margin_m: f64,
    /// Misfit of the best match, 0 is the same, 3 hardly so.
    pub(super) misfit: f64,
}

impl Memory {
    pub(super) fn new() -> Self {
        Self { points: VecDeque::new(), first: 0, cells: HashMap::new() }
    }

    /// Adds the newest piece; forgets the oldest one where there is no room.
    pub(super) fn add(&mut self, piece: Piece, params: &TurnParams) {
        let turn_before_rad = self.points.back().map_or(0.0, |last| last.piece.turn_into(&piece));
        let number = self.first + self.points.len() as u64;
        self.cells.entry(cell(piece.end_m, params)).or_default().push(number);
        self.points.push_back(Point { piece, turn_before_rad });
        if self.points.len() > params.memory_points as usize
            && let Some(oldest) = self.points.pop_front()
        {
            let place = cell(oldest.piece.end_m, params);
            if let Some(numbers) = self.cells.get_mut(&place) {
                numbers.retain(|number| *number != self.first);
                if numbers.is_empty() {
                    self.cells.remove(&place);
                }
            }
            self.first += 1;
        }
    }

    /// What came within `way_m` behind the end of the newest piece when the path was here before.
    pub(super) fn recall(&self, way_m: f64, params: &TurnParams) -> Recalled {
        let Some(newest) = self.points.back() else { return Recalled::default() };
        let last = self.first + self.points.len() as u64 - 1;
        let (column, row) = cell(newest.piece.end_m, params);
        let mut matches: Vec<(f64, u64)> = vec![];
        for place in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (column + dx, row + dy))) {
            for number in self.cells.get(&place).into_iter().flatten() {
                if number + u64::from(params.memory_gap) <= last
                    && let Some(misfit) = self.misfit(newest, *number, params)
                {
                    matches.push((misfit, *number));
                }
            }
        }
        matches.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        matches.truncate(ASKED);
        let next = |(_, number): &(f64, u64)| self.way_to_turn_m(*number, way_m + BEYOND_M, params);
        let nexts: Vec<f64> = matches.iter().map(|found| next(found).unwrap_or(way_m + BEYOND_M)).collect();
        let ways: Vec<f64> = nexts.iter().copied().filter(|next_m| *next_m <= way_m).collect();
        let (asked, turned) = (count(matches.len()), count(ways.len()));
        Recalled {
            matched: asked / count(ASKED),
            turned: if asked > 0.0 { turned / asked } else { 0.0 },
            way_m: if turned > 0.0 { ways.iter().sum::<f64>() / turned } else { way_m },
            margin_m: if asked > 0.0 { way_m - nexts.iter().sum::<f64>() / asked } else { 0.0 },
            misfit: matches.first().map_or(3.0, |(misfit, _)| *misfit),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    fn point(&self, number: u64) -> Option<&Point> {
        self.points.get(usize::try_from(number.checked_sub(self.first)?).ok()?)
    }

    /// How unlike a remembered point is; `None` where it is another one.
    fn misfit(&self, newest: &Point, number: u64, params: &TurnParams) -> Option<f64> {
        let other = self.point(number)?;
        let (a, b) = (newest.piece.end_m, other.piece.end_m);
        let apart = (a[0] - b[0]).hypot(a[1] - b[1]) / params.memory_reach_m;
        let turned = newest.piece.turn_into(&other.piece).abs() / params.memory_turn_rad;
        let before = (newest.turn_before_rad - other.turn_before_rad).abs() / params.memory_turn_rad;
        (apart <= 1.0 && turned <= 1.0).then_some(apart + turned + before.min(1.0))
    }

    /// Way from a remembered point to the first turn behind it, no farther than `way_m`.
    fn way_to_turn_m(&self, number: u64, way_m: f64, params: &TurnParams) -> Option<f64> {
        let mut gone_m = 0.0;
        for next in number + 1.. {
            let point = self.point(next)?;
            if point.turn_before_rad.abs() > params.threshold_rad {
                return Some(gone_m);
            }
            gone_m += point.piece.length_m;
            if gone_m > way_m {
                return None;
            }
        }
        None
    }
}

#[expect(clippy::cast_precision_loss, reason = "a small count")]
fn count(number: usize) -> f64 {
    number as f64
}

/// Square of the reach that a point lies in.
#[expect(clippy::cast_possible_truncation, reason = "coordinates of a bed over tenths of a millimetre")]
pub(super) fn cell(point_m: [f64; 2], params: &TurnParams) -> (i64, i64) {
    let [x, y] = point_m.map(|part_m| (part_m / params.memory_reach_m).floor() as i64);
    (x, y)
}
