//! Shares of the wanted flow over a time that rises.

use std::collections::VecDeque;

/// The newest of them.
#[derive(Debug, Clone)]
pub(super) struct Shares {
    kept_s: f64,
    /// Time `[s]` and share `[-]`, oldest first.
    points: VecDeque<(f64, f64)>,
}

impl Shares {
    pub(super) fn new(kept_s: f64) -> Self {
        Self { kept_s, points: VecDeque::new() }
    }

    pub(super) fn kept_s(&self) -> f64 {
        self.kept_s
    }

    /// Takes the share at a time later than the last, and forgets what is too old; `None` where nothing is laid.
    pub(super) fn keep(&mut self, at_s: f64, share: Option<f64>) {
        let forgotten_s = at_s - self.kept_s;
        while self.points.front().is_some_and(|(at_s, _)| *at_s < forgotten_s) {
            self.points.pop_front();
        }
        self.points.extend(share.filter(|share| share.is_finite()).map(|share| (at_s, share)));
    }

    /// Share at a time, between two that are not farther apart than `gap_max_s`.
    pub(super) fn at(&self, at_s: f64, gap_max_s: f64) -> Option<f64> {
        let after = self.points.partition_point(|(point_s, _)| *point_s < at_s);
        let (from, to) = (self.points.get(after.checked_sub(1)?)?, self.points.get(after)?);
        let gap_s = to.0 - from.0;
        (gap_s <= gap_max_s).then(|| from.1 + (to.1 - from.1) * (at_s - from.0) / gap_s)
    }
}
