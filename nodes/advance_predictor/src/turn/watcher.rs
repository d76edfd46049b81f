//! Follows the path and foresees turns: by the buffer where it shows them, by memory, habit and the layer's walls behind
//! its end.

use super::carried::carry_on;
use super::file::TurnNetwork;
use super::memory::{BEYOND_M, Memory, Recalled};
use super::params::TurnParams;
use super::path::Piece;
use super::walls::Walls;
use models::units::Seconds;
use std::collections::VecDeque;

/// Pieces whose turns and lengths are inputs.
pub(super) const CONTEXT: usize = 8;
/// Turns whose distances are inputs.
const INTERVALS: usize = 3;
/// Turns whose mean bend is carried on towards a wall.
const BEND: usize = 3;
/// Misfit at which a path carried on is trusted half.
const ALIKE: f64 = 0.01;
/// Inputs of the network.
pub(super) const INPUTS: usize = 2 * CONTEXT + INTERVALS + 21;

/// What the answer rests on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Basis {
    /// The buffer shows the turn, or shows the whole horizon without one.
    Buffer,
    /// The buffer ends before the horizon: memory and habit.
    Network,
}

/// A turn foreseen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foresight {
    /// Probability of a turn within the horizon `[0, 1]`.
    pub probability: f64,
    /// Time to the turn, or to where it is expected if there is one.
    pub lead: Seconds,
    /// Way to it `[m]`.
    pub way_m: f64,
    /// What it rests on.
    pub basis: Basis,
    /// Way that the buffer shows `[m]`.
    pub known_m: f64,
}

/// The path up to the end of the buffer.
#[derive(Debug, Clone)]
pub struct Watcher {
    params: TurnParams,
    /// Newest pieces: those gone as far as they are context, the current one, the buffered ones.
    tail: VecDeque<Piece>,
    /// Pieces of the tail from the current one on.
    known: usize,
    memory: Memory,
    walls: Walls,
    /// Ways between the newest turns, newest last; the first is the way since the last turn `[m]`.
    intervals_m: VecDeque<f64>,
}

impl Watcher {
    /// A watcher that has seen nothing.
    #[must_use]
    pub fn new(params: TurnParams) -> Self {
        Self {
            params,
            tail: VecDeque::new(),
            known: 0,
            memory: Memory::new(),
            walls: Walls::default(),
            intervals_m: VecDeque::from([0.0]),
        }
    }

    /// A piece enters the buffer.
    pub fn push(&mut self, piece: Piece) {
        let turned =
            self.tail.back().is_some_and(|last| last.turn_into(&piece).abs() > self.params.threshold_rad);
        if turned {
            self.intervals_m.push_front(0.0);
            self.intervals_m.truncate(INTERVALS);
        }
        if let Some(since_m) = self.intervals_m.front_mut() {
            *since_m += piece.length_m;
        }
        self.memory.add(piece, &self.params);
        self.walls.add(&piece, &self.params);
        self.tail.push_back(piece);
        self.known += 1;
        self.forget();
    }

    /// The next buffered piece begins; the first one that was pushed begins by itself.
    pub fn begin_next(&mut self) {
        self.known = self.known.saturating_sub(1);
        self.forget();
    }

    /// Pieces from the current one on.
    #[must_use]
    pub fn known(&self) -> usize {
        self.known
    }

    /// Points of the path that are remembered.
    #[must_use]
    pub fn remembered(&self) -> usize {
        self.memory.len()
    }

    fn forget(&mut self) {
        while self.tail.len() > self.known.max(CONTEXT + 1) {
            self.tail.pop_front();
        }
    }

    /// Known pieces, the current one first.
    fn ahead(&self) -> impl Iterator<Item = &Piece> {
        self.tail.iter().skip(self.tail.len() - self.known)
    }

    /// Way that the buffer shows from `gone_m` into the current piece `[m]`.
    pub(super) fn known_m(&self, gone_m: f64) -> f64 {
        (self.ahead().map(|piece| piece.length_m).sum::<f64>() - gone_m).max(0.0)
    }

    fn speed_m_s(&self) -> f64 {
        self.ahead().next().map_or(0.0, |current| current.speed_m_s).max(f64::MIN_POSITIVE)
    }

    /// Way within which a turn counts, at the current speed `[m]`.
    pub(super) fn horizon_m(&self) -> f64 {
        self.params.horizon_m.max(self.params.horizon_s * self.speed_m_s())
    }

    /// Way to the first turn that the buffer shows `[m]`.
    pub(super) fn shown_turn_m(&self, gone_m: f64) -> Option<f64> {
        let mut way_m = -gone_m;
        let mut before: Option<&Piece> = None;
        for piece in self.ahead() {
            if before.is_some_and(|before| before.turn_into(piece).abs() > self.params.threshold_rad) {
                return Some(way_m);
            }
            way_m += piece.length_m;
            before = Some(piece);
        }
        None
    }

    /// What the buffer alone says: a turn within the horizon, none, or `None` where it ends too early.
    pub(super) fn by_buffer(&self, gone_m: f64) -> Option<Foresight> {
        let (horizon_m, known_m) = (self.horizon_m(), self.known_m(gone_m));
        let lead = |way_m: f64| Seconds(way_m / self.speed_m_s());
        let answer = |probability, way_m| {
            Some(Foresight { probability, lead: lead(way_m), way_m, basis: Basis::Buffer, known_m })
        };
        match self.shown_turn_m(gone_m) {
            Some(way_m) if way_m <= horizon_m => answer(1.0, way_m),
            Some(way_m) => answer(0.0, way_m),
            None if known_m >= horizon_m => answer(0.0, known_m),
            None => None,
        }
    }

    /// Foresees at `gone_m` into the current piece; `None` before the first one.
    #[must_use]
    pub fn foresee(&self, network: &TurnNetwork, gone_m: f64) -> Option<Foresight> {
        if self.known == 0 || !gone_m.is_finite() {
            return None;
        }
        if let Some(shown) = self.by_buffer(gone_m) {
            return Some(shown);
        }
        let (inputs, recalled) = self.inputs(gone_m);
        let known_m = self.known_m(gone_m);
        let way_m = known_m + recalled.way_m;
        Some(Foresight {
            probability: network.probability(&inputs),
            lead: Seconds(way_m / self.speed_m_s()),
            way_m,
            basis: Basis::Network,
            known_m,
        })
    }

    /// Baselines: whether a turn lies behind the buffer if the last two turns go on in a line, and if the mean
    /// curvature of the newest pieces goes on.
    pub(super) fn extrapolated(&self, gone_m: f64) -> [bool; 2] {
        let hidden_m = (self.horizon_m() - self.known_m(gone_m)).max(0.0);
        let newest: Vec<&Piece> = self.tail.iter().rev().take(CONTEXT + 1).collect();
        let turns_rad: Vec<f64> = newest.windows(2).map(|pair| pair[1].turn_into(pair[0])).collect();
        let way_m: f64 = newest.iter().map(|piece| piece.length_m).sum();
        let [Some(last), Some(before)] = [turns_rad.first(), turns_rad.get(1)] else { return [false; 2] };
        let pieces = hidden_m / newest[0].length_m;
        let line_rad = last + (last - before) * pieces.floor().min(100.0);
        let mean_rad = turns_rad.iter().sum::<f64>() / way_m * hidden_m;
        [line_rad, mean_rad].map(|turn_rad| turn_rad.abs() > self.params.threshold_rad)
    }

    /// Inputs of the network, all about the end of the buffer, and what the memory says there.
    pub(super) fn inputs(&self, gone_m: f64) -> ([f64; INPUTS], Recalled) {
        let (horizon_m, known_m) = (self.horizon_m(), self.known_m(gone_m));
        let hidden_m = (horizon_m - known_m).max(0.0);
        let recalled = self.memory.recall(hidden_m, &self.params);
        let mut inputs = [0.0; INPUTS];
        let newest: Vec<&Piece> = self.tail.iter().rev().take(CONTEXT + 1).collect();
        for (place, pair) in newest.windows(2).enumerate() {
            let turn_rad = pair[1].turn_into(pair[0]);
            // Mirrored paths are the same: the newest turn is positive.
            inputs[place] = turn_rad;
            inputs[CONTEXT + place] = (1e3 * pair[0].length_m).ln();
        }
        let sign =
            inputs[..CONTEXT].iter().find(|turn_rad| turn_rad.abs() > 1e-6).map_or(1.0, |t| t.signum());
        inputs[..CONTEXT].iter_mut().for_each(|turn_rad| *turn_rad *= sign);
        for (place, way_m) in self.intervals_m.iter().enumerate() {
            inputs[2 * CONTEXT + place] = (1e3 * way_m.max(1e-5)).ln();
        }
        let repeat = match (self.intervals_m.front(), self.intervals_m.get(1), self.intervals_m.get(2)) {
            (Some(since_m), Some(last_m), Some(before_m)) => {
                [(last_m - since_m) / horizon_m, (before_m - since_m) / horizon_m]
                    .map(|part| part.clamp(-5.0, 5.0))
            }
            _ => [5.0, 5.0],
        };
        let sum: f64 = inputs[..CONTEXT].iter().sum();
        let most = inputs[..CONTEXT].iter().fold(0.0_f64, |most, turn_rad| most.max(turn_rad.abs()));
        let last = newest.first().copied();
        let walls_m = self.walls_m(&newest, hidden_m);
        let carried = carry_on(&newest, hidden_m + BEYOND_M, &self.params);
        let alike = ALIKE / (ALIKE + carried.misfit);
        let along = self.ahead().next().map_or(0.0, |current| current.along_m_s2);
        let rest = [
            hidden_m / horizon_m,
            1e3 * hidden_m,
            1e3 * known_m,
            self.speed_m_s(),
            along,
            sum,
            most,
            repeat[0],
            repeat[1],
            f64::from(u8::from(last.is_some_and(|piece| piece.fill))),
            f64::from(u8::from(last.is_some_and(|piece| piece.deposit))),
            recalled.turned * recalled.matched.sqrt(),
            (1.0 - recalled.turned) * recalled.matched.sqrt(),
            1e3 * recalled.margin_m,
            recalled.misfit,
            1e3 * (hidden_m - walls_m[0]),
            1e3 * (hidden_m - walls_m[1]),
            walls_m.iter().filter(|way_m| **way_m < hidden_m).map(|_| 1.0).sum(),
            1e3 * (alike * (hidden_m - carried.way_m) - (1.0 - alike) * BEYOND_M),
            alike,
            if carried.way_m < hidden_m { alike } else { 0.0 },
        ];
        inputs[2 * CONTEXT + INTERVALS..].copy_from_slice(&rest);
        (inputs, recalled)
    }

    /// Ways from the end of the buffer to the next wall of the layer, straight on and bent on as the newest pieces are, no
    /// farther than [`BEYOND_M`] behind the hidden way; where the path does not fill an area there is none `[m]`.
    fn walls_m(&self, newest: &[&Piece], hidden_m: f64) -> [f64; 2] {
        let far_m = hidden_m + BEYOND_M;
        let Some(last) = newest.first().filter(|last| last.fill) else { return [far_m; 2] };
        let bend = &newest[..newest.len().min(BEND + 1)];
        let bent_rad: f64 = bend.windows(2).map(|pair| pair[1].turn_into(pair[0])).sum();
        let bent_m: f64 = bend.iter().map(|piece| piece.length_m).sum();
        [0.0, bent_rad / bent_m]
            .map(|curvature_1_m| self.walls.way_m(last, (curvature_1_m, far_m), &self.params))
    }
}
