//! What was sent and does not act yet: a host that attaches trims to moves, or takes them over HTTP, executes what it was sent
//! seconds ago.
//!
//! The printer's state tells the slip in force, and each slip that was sent is told from the next by its digits: so the delay
//! is measured. What the melt lacks is foretold to when a correction acts, with those on their way, before another one is sent
//! (Smith 1957): without that a gain of 1 1/s and a delay of 1.5 s push to and fro for ever.

use std::collections::VecDeque;

/// Slips that are remembered: 6 s at 20 Hz, three times what a host over HTTP takes.
const SENT: usize = 120;

/// A slip that was sent.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sent {
    at_s: f64,
    slip: f64,
}

/// Slips on their way.
#[derive(Debug, Clone)]
pub(crate) struct Pending {
    sent: VecDeque<Sent>,
    /// Time from sending to effect, as last seen `[s]`; 0 before.
    delay_s: f64,
}

impl Pending {
    pub(crate) fn new() -> Self {
        Self { sent: VecDeque::with_capacity(SENT), delay_s: 0.0 }
    }

    /// Forgets what was sent; the host's delay stays.
    pub(crate) fn clear(&mut self) {
        self.sent.clear();
    }

    pub(crate) fn send(&mut self, at_s: f64, slip: f64) {
        if self.sent.len() == SENT {
            self.sent.pop_front();
        }
        self.sent.push_back(Sent { at_s, slip });
    }

    /// The slip in force at `stamp_s`. Of several that are the same it is the one that fits the delay so far; one that was
    /// never sent (limited on its way, or another's) tells nothing.
    pub(crate) fn on_in_force(&mut self, stamp_s: f64, slip: f64) {
        let misfit = |sent: &&Sent| (stamp_s - sent.at_s - self.delay_s).abs();
        let same = self.sent.iter().filter(|sent| sent.slip.to_bits() == slip.to_bits());
        let fitting = same.min_by(|left, right| misfit(left).total_cmp(&misfit(right)));
        self.delay_s = fitting.map_or(self.delay_s, |sent| (stamp_s - sent.at_s).max(0.0));
    }

    /// What the melt will lack `[m]` once a slip that is sent at `now_s` acts: of `lacks_m` now, and of what those on
    /// their way leave out of `feed_m_s` while `slip` slips, what is left of either after the lag `lag_s` `[s]`.
    pub(crate) fn lacking_m(
        &self,
        lacks_m: f64,
        (now_s, slip): (f64, f64),
        feed_m_s: f64,
        lag_s: f64,
    ) -> f64 {
        let begin_s = now_s - self.delay_s;
        let left = |at_s: f64| ((at_s - now_s) / lag_s).exp();
        let ends = self.sent.iter().skip(1).map(|sent| sent.at_s).chain([now_s]);
        let lacking = self.sent.iter().zip(ends).map(|(sent, end_s)| {
            let (from_s, to_s) = (sent.at_s.max(begin_s), end_s.max(begin_s));
            (1.0 - (1.0 - slip) / (1.0 - sent.slip)) * (left(to_s) - left(from_s))
        });
        lacks_m * left(begin_s) + feed_m_s * lag_s * lacking.sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 Hz for 3 s, each slip its own.
    fn sent() -> Pending {
        let mut pending = Pending::new();
        (0..60).for_each(|step| pending.send(0.05 * f64::from(step), 0.01 + 1e-5 * f64::from(step)));
        pending
    }

    #[test]
    fn the_delay_is_that_of_the_slip_in_force() {
        let mut pending = sent();
        pending.on_in_force(3.0, 0.01 + 1e-5 * 30.0);
        assert!((pending.delay_s - 1.5).abs() < 1e-9);
        pending.on_in_force(3.1, 0.7);
        assert!((pending.delay_s - 1.5).abs() < 1e-9, "a slip that was never sent tells nothing");
        pending.clear();
        assert!(pending.sent.is_empty() && (pending.delay_s - 1.5).abs() < 1e-9);
    }

    #[test]
    fn of_many_that_are_the_same_the_one_with_the_usual_delay_counts() {
        let mut pending = sent();
        pending.on_in_force(3.0, 0.01 + 1e-5 * 40.0);
        (60..100).for_each(|step| pending.send(0.05 * f64::from(step), 0.5));
        pending.on_in_force(4.5, 0.5);
        assert!((pending.delay_s - 1.0).abs() < 0.026, "{}", pending.delay_s);
    }

    /// 0.1 mm, and for 1.5 s 10 % of 2 mm/s that those on their way leave out: what of either is left after as long, with a
    /// lag of 0.5 s.
    #[test]
    fn what_lacks_once_a_slip_acts_is_what_is_left_by_then() {
        let mut pending = Pending::new();
        (0..60).for_each(|step| pending.send(0.05 * f64::from(step), 0.02 + 1e-9 * f64::from(step)));
        pending.on_in_force(3.0, 0.02 + 1e-9 * 30.0);
        let left = (-1.5_f64 / 0.5).exp();
        let lacks_m = |slip: f64, lag_s: f64| pending.lacking_m(1e-4, (3.0, slip), 2e-3, lag_s);
        assert!((lacks_m(0.02, 0.5) - 1e-4 * left).abs() < 1e-9);
        assert!((lacks_m(0.118, 0.5) - (1e-4 * left + 2e-4 * 0.5 * (1.0 - left))).abs() < 1e-9);
        // a melt that loses nothing
        assert!((lacks_m(0.118, 1e6) - (1e-4 + 2e-4 * 1.5)).abs() < 1e-8);
    }

    #[test]
    fn what_is_remembered_has_an_end() {
        let mut pending = Pending::new();
        (0..100_000).for_each(|step| pending.send(0.05 * f64::from(step), 0.01));
        assert_eq!(pending.sent.len(), SENT);
        assert!(
            (pending.lacking_m(1e-4, (5000.0, 0.1), 2e-3, 0.5) - 1e-4).abs() < 1e-12,
            "no delay was told"
        );
    }
}
