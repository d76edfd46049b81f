//! What was sent and does not act yet: a host that attaches trims to moves, or takes them over HTTP, executes what it was sent
//! seconds ago.
//!
//! The printer's state tells the slip in force, and each slip that was sent is told from the next by its digits: so the delay
//! is measured. What the corrections under way will still bring is taken off the shortfall before another one is sent
//! (Smith 1957): without that a gain of 1 1/s and a delay of 1.5 s push to and fro for ever.

use std::collections::VecDeque;

/// Slips that are remembered: 6 s at 20 Hz, three times what a host over HTTP takes.
const SENT: usize = 120;

/// A slip that was sent.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sent {
    at_s: f64,
    slip: f64,
    /// Feed beyond the one that makes up for what slips `[m/s]`.
    extra_m_s: f64,
}

/// Slips on their way.
#[derive(Debug, Clone)]
pub(crate) struct Pending {
    sent: VecDeque<Sent>,
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

    /// Time from sending to effect, as last seen `[s]`; 0 before.
    pub(crate) fn delay_s(&self) -> f64 {
        self.delay_s
    }

    pub(crate) fn send(&mut self, at_s: f64, slip: f64, extra_m_s: f64) {
        if self.sent.len() == SENT {
            self.sent.pop_front();
        }
        self.sent.push_back(Sent { at_s, slip, extra_m_s });
    }

    /// The slip in force at `stamp_s`. Of several that are the same it is the one that fits the delay so far; one that was
    /// never sent (limited on its way, or another's) tells nothing.
    pub(crate) fn on_in_force(&mut self, stamp_s: f64, slip: f64) {
        let misfit = |sent: &&Sent| (stamp_s - sent.at_s - self.delay_s).abs();
        let same = self.sent.iter().filter(|sent| sent.slip.to_bits() == slip.to_bits());
        let fitting = same.min_by(|left, right| misfit(left).total_cmp(&misfit(right)));
        self.delay_s = fitting.map_or(self.delay_s, |sent| (stamp_s - sent.at_s).max(0.0));
    }

    /// Filament that what is on its way at `now_s` will push beyond what makes up for the slip `[m]`.
    pub(crate) fn extra_m(&self, now_s: f64) -> f64 {
        let ends = self.sent.iter().skip(1).map(|sent| sent.at_s).chain([now_s]);
        let pushed = self.sent.iter().zip(ends).map(|(sent, end_s)| {
            let begin_s = sent.at_s.max(now_s - self.delay_s);
            sent.extra_m_s * (end_s - begin_s).max(0.0)
        });
        pushed.sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 Hz for 3 s, each slip its own, and 0.1 mm/s more each.
    fn sent() -> Pending {
        let mut pending = Pending::new();
        (0..60).for_each(|step| pending.send(0.05 * f64::from(step), 0.01 + 1e-5 * f64::from(step), 1e-4));
        pending
    }

    #[test]
    fn the_delay_is_that_of_the_slip_in_force() {
        let mut pending = sent();
        assert!(pending.delay_s().abs() < 1e-12 && pending.extra_m(3.0).abs() < 1e-15);
        pending.on_in_force(3.0, 0.01 + 1e-5 * 30.0);
        assert!((pending.delay_s() - 1.5).abs() < 1e-9);
        // 1.5 s of 0.1 mm/s
        assert!((pending.extra_m(3.0) - 1.5e-4).abs() < 1e-12);
        pending.on_in_force(3.1, 0.7);
        assert!((pending.delay_s() - 1.5).abs() < 1e-9, "a slip that was never sent tells nothing");
        pending.clear();
        assert!(pending.extra_m(3.2).abs() < 1e-15 && (pending.delay_s() - 1.5).abs() < 1e-9);
    }

    #[test]
    fn of_many_that_are_the_same_the_one_with_the_usual_delay_counts() {
        let mut pending = sent();
        pending.on_in_force(3.0, 0.01 + 1e-5 * 40.0);
        (60..100).for_each(|step| pending.send(0.05 * f64::from(step), 0.5, 0.0));
        pending.on_in_force(4.5, 0.5);
        assert!((pending.delay_s() - 1.0).abs() < 0.026, "{}", pending.delay_s());
    }

    #[test]
    fn what_is_remembered_has_an_end() {
        let mut pending = Pending::new();
        (0..100_000).for_each(|step| pending.send(0.05 * f64::from(step), 0.01, 1e-4));
        assert_eq!(pending.sent.len(), SENT);
        assert!(pending.extra_m(f64::NAN).is_finite());
    }
}
