//! Moments along a path: what was known, and what came, by hindsight.

use super::params::TurnParams;
use super::path::Piece;
use super::watcher::Watcher;

/// One update of the predictor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moment {
    /// Piece that is under way.
    pub(super) piece: usize,
    /// Way gone in it `[m]`.
    pub(super) gone_m: f64,
    /// Time since the start of the path `[s]`.
    pub(super) time_s: f64,
    /// A turn comes within the horizon.
    pub(super) turns: bool,
}

/// Way between two updates inside of a long piece `[m]`: 50 Hz at 50 mm/s.
const STEP_M: f64 = 1e-3;
/// Longer pieces are looked at near their end alone `[m]`: before that there is nothing to foresee.
const LOOK_M: f64 = 0.02;

/// A path with its turns.
#[derive(Debug, Clone)]
pub(super) struct Track<'a> {
    pub(super) pieces: &'a [Piece],
    /// Time at which each piece begins `[s]`.
    pub(super) starts_s: Vec<f64>,
    /// For each piece the first one at or behind it that a turn ends.
    next_turn: Vec<Option<usize>>,
}

impl<'a> Track<'a> {
    pub(super) fn new(pieces: &'a [Piece], params: &TurnParams) -> Self {
        let mut now_s = 0.0;
        let starts_s = pieces
            .iter()
            .map(|piece| {
                now_s += piece.duration_s;
                now_s - piece.duration_s
            })
            .collect();
        let mut coming = None;
        let mut next_turn: Vec<Option<usize>> = (0..pieces.len())
            .rev()
            .map(|place| {
                let turns = pieces
                    .get(place + 1)
                    .is_some_and(|next| pieces[place].turn_into(next).abs() > params.threshold_rad);
                coming = if turns { Some(place) } else { coming };
                coming
            })
            .collect();
        next_turn.reverse();
        Self { pieces, starts_s, next_turn }
    }

    /// Pieces that a turn ends.
    pub(super) fn turns(&self) -> impl Iterator<Item = usize> {
        self.next_turn
            .iter()
            .enumerate()
            .filter(|(place, next)| **next == Some(*place))
            .map(|(place, _)| place)
    }

    /// Runs a watcher with `buffered` pieces ahead along the path and shows every moment.
    pub(super) fn run(&self, buffered: usize, params: &TurnParams, mut see: impl FnMut(&Watcher, &Moment)) {
        let mut watcher = Watcher::new(*params);
        let mut pushed = 0;
        for piece in 0..self.pieces.len() {
            if piece > 0 {
                watcher.begin_next();
            }
            while pushed < self.pieces.len() && pushed <= piece + buffered {
                watcher.push(self.pieces[pushed]);
                pushed += 1;
            }
            let length_m = self.pieces[piece].length_m;
            let mut gone_m = (length_m - LOOK_M).max(0.0);
            while gone_m < length_m {
                let moment = self.moment(piece, gone_m, watcher.horizon_m());
                see(&watcher, &moment);
                gone_m += STEP_M;
            }
        }
    }

    fn moment(&self, piece: usize, gone_m: f64, horizon_m: f64) -> Moment {
        let share = gone_m / self.pieces[piece].length_m;
        let time_s = self.starts_s[piece] + share * self.pieces[piece].duration_s;
        let turns = self.next_turn[piece].is_some_and(|last| {
            let mut way_m = -gone_m;
            for between in &self.pieces[piece..=last] {
                way_m += between.length_m;
                if way_m > horizon_m {
                    return false;
                }
            }
            true
        });
        Moment { piece, gone_m, time_s, turns }
    }
}
