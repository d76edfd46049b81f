//! The brain: moves and set-points in, `K_A` and the next turn out.

use crate::compensation::{Prediction, Predictor, Unanswered};
use crate::params::Params;
use crate::speeds::Speeds;
use crate::turn::{Foresight, Piece, TurnNetwork, Watcher};
use models::advance::Condition;
use models::command::AdvanceLaw;
use models::motion::{MoveKind, Segment};
use models::units::{Celsius, Seconds};
use std::f64::consts::FRAC_PI_4;

/// What happens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// A move begins; those behind it are not known yet.
    Move(Segment),
    /// The hot end's set-point at a time; 0 degC is off.
    Target(Seconds, Celsius),
}

/// A `K_A` and what it is meant for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Advance {
    /// The answer.
    pub prediction: Prediction,
    /// Its condition; the width is the road's cross section over its height.
    pub at: Condition,
    /// The answer over the feed, at whatever speed is printed.
    pub law: AdvanceLaw,
    /// Lag over the changes of speed that are printed over the lag over those of the test line `[-]`.
    pub speeds: f64,
}

impl Advance {
    /// `K_A` for the changes of speed that are printed.
    #[must_use]
    pub fn advance(&self) -> Seconds {
        Seconds(self.prediction.advance.0 * self.speeds)
    }

    /// Half width of its interval, in the same proportion.
    #[must_use]
    pub fn half_width(&self) -> Seconds {
        Seconds(self.prediction.half_width.0 * self.speeds)
    }
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
    speeds: Speeds,
    target: Option<Celsius>,
    /// Height and width of the newest road `[m]`.
    road_m: Option<[f64; 2]>,
    advance: Option<Advance>,
    turn: Option<Foresight>,
    /// First set-point after the move that the turn was foreseen in.
    turn_since: Option<Seconds>,
    /// When set-points made the last word, or might have.
    said: Option<Seconds>,
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
            speeds: Speeds::default(),
            target: None,
            road_m: None,
            advance: None,
            turn: None,
            turn_since: None,
            said: None,
            refused: None,
            counts: Counts::default(),
        }
    }

    /// Takes an event in; a move always yields an output, a set-point where it changes the answer, and from time to time
    /// where it does not: a road may be long, and who is silent counts as dead.
    pub fn on_event(&mut self, event: Event) -> Option<Output> {
        match event {
            Event::Move(segment) => {
                self.counts.moves += 1;
                self.follow(&segment);
                self.see_road(&segment);
                _ = self.answer();
                self.see_speeds(&segment);
                Some(self.output())
            }
            Event::Target(now, target) => {
                self.target = (target.0 > 0.0).then_some(target);
                self.come_nearer(now);
                let changed = self.answer();
                let due =
                    self.said.is_none_or(|said| !(0.0..self.params.repeat_s.0).contains(&(now - said).0));
                if !(changed || due) {
                    return None;
                }
                self.said = Some(now);
                (changed || self.advance.is_some()).then(|| self.output())
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
            self.turn_since = None;
        }
    }

    /// The turn foreseen at the start of the move is nearer by the time since then.
    fn come_nearer(&mut self, now: Seconds) {
        let since = self.turn_since.replace(now);
        if let (Some(turn), Some(since)) = (&mut self.turn, since) {
            let left_s = (turn.lead.0 - (now - since).0.max(0.0)).max(0.0);
            turn.way_m *= if turn.lead.0 > 0.0 { left_s / turn.lead.0 } else { 1.0 };
            turn.lead = Seconds(left_s);
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

    /// Takes the speed changes of a road that begins into account: its last one is known before it happens.
    fn see_speeds(&mut self, segment: &Segment) {
        if segment.kind != MoveKind::Deposit {
            return self.speeds.end();
        }
        let Some(advance) = &mut self.advance else { return };
        let outlet = |speed_m_s: f64| {
            self.compensation.static_law(&self.params.polymer, &advance.at).map(|(law, per_way)| {
                let outlet_m_s = per_way * speed_m_s;
                [outlet_m_s, law.compression_m(outlet_m_s)]
            })
        };
        let profile = &segment.profile;
        let ends = [profile.entry_m_s, profile.cruise_m_s, profile.exit_m_s].map(outlet);
        let [Some(entry), Some(cruise), Some(exit)] = ends else { return };
        self.speeds.add([entry, cruise, exit], profile.duration().0, self.params.speeds.memory_s);
        let line = self.compensation.secant_s(&self.params.polymer, &advance.at);
        advance.speeds = match (self.speeds.lag_s(), line) {
            (Some(lag_s), Some(line_s)) => self.params.speeds.bounded(lag_s / line_s),
            _ => 1.0,
        };
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
        let speeds = self.advance.map_or(1.0, |before| before.speeds);
        self.advance = answered.ok().and_then(|prediction| {
            let law = self.compensation.law(&self.params.polymer, &at, prediction.advance)?;
            Some(Advance { prediction, at, law, speeds })
        });
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
