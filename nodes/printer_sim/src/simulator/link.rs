//! A host over HTTP: a trim acts some time after it was sent, and none overtakes another.

use crate::sensors::Noise;
use models::command::Trims;
use models::units::Seconds;
use std::collections::VecDeque;

/// Time between two requests `[s]`: the pace of Moonraker's state.
const REQUEST_S: f64 = 0.25;

/// What is on its way.
#[derive(Debug, Clone)]
pub(super) struct Link {
    effect_s: (f64, f64),
    noise: Noise,
    waiting: VecDeque<(Seconds, Trims)>,
    sent: Option<(Seconds, Trims)>,
    in_force: Trims,
}

impl Link {
    pub(super) fn new(effect_s: (f64, f64), noise: Noise) -> Self {
        Self { effect_s, noise, waiting: VecDeque::new(), sent: None, in_force: Trims::NEUTRAL }
    }

    /// The trims that act at `now`, while `wished` is what is to be. No request overtakes another.
    pub(super) fn step(&mut self, now: Seconds, wished: Trims) -> Trims {
        while let Some((_, arrived)) = self.waiting.front().filter(|(due, _)| now.0 >= due.0).copied() {
            self.in_force = arrived;
            self.waiting.pop_front();
        }
        let rested = self.sent.is_none_or(|(at, _)| (now - at).0 >= REQUEST_S);
        let news = wished != self.sent.map_or(Trims::NEUTRAL, |(_, trims)| trims);
        if rested && news {
            let before_s = self.waiting.back().map_or(now.0, |(due, _)| due.0);
            let due = Seconds((now.0 + self.noise.between(self.effect_s)).max(before_s));
            self.waiting.push_back((due, wished));
            self.sent = Some((now, wished));
        }
        self.in_force
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trim_acts_within_its_time_and_the_next_one_follows() {
        let mut link = Link::new((0.5, 2.0), Noise::new(1, 7));
        let trims = |flow| Trims { flow, ..Trims::NEUTRAL };
        let at = |ms: u32| Seconds(f64::from(ms) * 1e-3);
        let first = (0..3000).find(|ms| link.step(at(*ms), trims(1.1)) == trims(1.1)).unwrap();
        assert!((500..=2000).contains(&first), "{first} ms");
        let second = (first..6000).find(|ms| link.step(at(*ms), trims(1.2)) == trims(1.2)).unwrap() - first;
        assert!((500..=2000).contains(&second), "{second} ms");
    }
}
