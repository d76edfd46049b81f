//! The brain: moves and set-points in, `K_A` and the next turn out.

use crate::compensation::{Prediction, Predictor, Unanswered};
use crate::params::Params;
use crate::turn::{Foresight, Piece, TurnNetwork, Watcher};
use models::advance::Condition;
use models::motion::{MoveKind, Segment};
use models::units::Celsius;
use std::f64::consts::FRAC_PI_4;

/// What happens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// A move begins; those behind it are not known yet.
    Move(Segment),
    /// The hot end's set-point; 0 degC is off.
    Target(Celsius),
}

/// A `K_A` and what it is meant for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Advance {
    /// The answer.
    pub prediction: Prediction,
    /// Its condition; the width is the road's cross section over its height.
    pub at: Condition,
}

/// What is known now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output {
    /// `K_A`; `None` before the first road, and out of bounds.
    pub advance: Option<Advance>,
    /// The next turn; `None` before the first move.
    pub turn: Option<Foresight>,
    /// The turn's probability is above the network's threshold.
    pub expected: bool,
}

/// Counters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Moves seen.
    pub moves: u64,
    /// Conditions for which the physical model answered.
    pub outside_hull: u64,
    /// Conditions for which there was no answer.
    pub unanswered: u64,
}

/// Foretells `K_A` and turns for one printer.
#[derive(Debug, Clone)]
pub struct AdvancePredictor {
    params: Params,
    compensation: Predictor,
    network: TurnNetwork,
    watcher: Watcher,
    target: Option<Celsius>,
    /// Height and width of the newest road `[m]`.
    road_m: Option<[f64; 2]>,
    advance: Option<Advance>,
    turn: Option<Foresight>,
    refused: Option<Unanswered>,
    counts: Counts,
}

impl AdvancePredictor {
    /// A predictor that has seen nothing.
    #[must_use]
    pub fn new(params: Params, compensation: Predictor, network: TurnNetwork) -> Self {
        let watcher = Watcher::new(params.turn);
        Self {
            params,
            compensation,
            network,
            watcher,
            target: None,
            road_m: None,
            advance: None,
            turn: None,
            refused: None,
            counts: Counts::default(),
        }
    }

    /// Takes an event in; a move always yields an output, a set-point where it changes the answer.
    pub fn on_event(&mut self, event: Event) -> Option<Output> {
        match event {
            Event::Move(segment) => {
                self.counts.moves += 1;
                self.follow(&segment);
                self.see_road(&segment);
                _ = self.answer();
                Some(self.output())
            }
            Event::Target(target) => {
                self.target = (target.0 > 0.0).then_some(target);
                self.answer().then(|| self.output())
            }
        }
    }

    /// Counters so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Why there is no `K_A`, where conditions are known.
    #[must_use]
    pub fn refused(&self) -> Option<Unanswered> {
        self.refused
    }

    fn follow(&mut self, segment: &Segment) {
        if let Some(piece) = Piece::of(segment) {
            if self.watcher.known() > 0 {
                self.watcher.begin_next();
            }
            self.watcher.push(piece);
            self.turn = self.watcher.foresee(&self.network, 0.0);
        }
    }

    /// Height and mean width of a road: `A/h = w - h (1 - pi/4)` of the stadium that the slicer means.
    fn see_road(&mut self, segment: &Segment) {
        if let (MoveKind::Deposit, Some(width_m), Some(height_m)) =
            (segment.kind, segment.target_width_m, segment.layer_height_m)
        {
            self.road_m = Some([height_m, width_m - height_m * (1.0 - FRAC_PI_4)]);
        }
    }

    /// Answers anew where the conditions changed; whether they did.
    fn answer(&mut self) -> bool {
        let (Some(temperature), Some([height_m, width_m])) = (self.target, self.road_m) else {
            return self.advance.take().is_some();
        };
        let at = Condition { temperature, height_m, width_m };
        if self.advance.is_some_and(|known| self.params.steps.same(&known.at, &at)) {
            return false;
        }
        let answered = self.compensation.predict(&self.params.polymer, &at);
        let was_known = self.advance.is_some();
        self.refused = answered.err();
        self.advance = answered.ok().map(|prediction| Advance { prediction, at });
        match &self.advance {
            Some(advance) if advance.prediction.source == crate::compensation::Source::Physics => {
                self.counts.outside_hull += 1;
            }
            Some(_) => {}
            None => self.counts.unanswered += 1,
        }
        was_known || self.advance.is_some()
    }

    fn output(&self) -> Output {
        let expected = self.turn.is_some_and(|turn| turn.probability >= self.network.threshold());
        Output { advance: self.advance, turn: self.turn, expected }
    }
}

#[cfg(test)]
mod tests;
