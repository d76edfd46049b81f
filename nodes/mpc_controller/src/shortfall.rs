//! Filament that was wanted and did not pass the encoder, compared at the printer's own times.

use crate::params::RawSlip;
use std::collections::VecDeque;

/// Encoder samples kept to meet a status: 0.16 s at 100 Hz.
const SAMPLES: usize = 16;

/// Shortfall of filament since the loop closed.
#[derive(Debug, Clone)]
pub(crate) struct Shortfall {
    settings: RawSlip,
    samples: VecDeque<(f64, f64)>,
    waiting: Option<(f64, f64)>,
    newest_wanted: Option<(f64, f64)>,
    /// Wanted less measured position when the loop closed `[m]`: closing it moves nothing.
    origin_m: Option<f64>,
    shortfall_m: f64,
    /// Shortfall that was told as excess `[m]`.
    told_m: f64,
}

impl Shortfall {
    pub(crate) fn new(settings: RawSlip) -> Self {
        Self {
            settings,
            samples: VecDeque::with_capacity(SAMPLES),
            waiting: None,
            newest_wanted: None,
            origin_m: None,
            shortfall_m: 0.0,
            told_m: 0.0,
        }
    }

    /// Opens the loop; it closes again with the next pair.
    pub(crate) fn open(&mut self) {
        self.origin_m = None;
        (self.shortfall_m, self.told_m) = (0.0, 0.0);
    }

    /// Whether a pair has closed the loop.
    pub(crate) fn is_closed(&self) -> bool {
        self.origin_m.is_some()
    }

    /// Filament still owed `[m]`.
    pub(crate) fn owed_m(&self) -> f64 {
        self.shortfall_m
    }

    /// Forgets `m` of what is owed `[m]`.
    pub(crate) fn forget(&mut self, m: f64) {
        if let Some(origin_m) = self.origin_m.as_mut() {
            *origin_m += m;
            self.shortfall_m -= m;
        }
    }

    /// Filament delivered beyond what was wanted since it was last asked for `[m]`.
    pub(crate) fn take_excess_m(&mut self) -> f64 {
        let excess_m = self.told_m - self.shortfall_m;
        self.told_m = self.shortfall_m;
        excess_m
    }

    pub(crate) fn newest_sample_s(&self) -> Option<f64> {
        self.samples.back().map(|sample| sample.0)
    }

    /// Takes a wanted position; what it moved by since the last one, and in which time `[m, s]`. `None` where none came
    /// before, or the count is a new one: that opens the loop.
    pub(crate) fn on_wanted(&mut self, stamp_s: f64, wanted_m: f64) -> Option<(f64, f64)> {
        let before = self.newest_wanted.replace((stamp_s, wanted_m));
        let moved = before.map(|(before_s, before_m)| (wanted_m - before_m, stamp_s - before_s));
        let jumped = moved.is_some_and(|(moved_m, _)| moved_m.abs() > self.settings.wanted_jump_m);
        if jumped {
            self.open();
        }
        self.waiting = Some((stamp_s, wanted_m));
        self.pair();
        moved.filter(|_| !jumped)
    }

    /// Takes a measured position; whether its count is a new one, which opens the loop.
    pub(crate) fn on_encoder(&mut self, stamp_s: f64, position_m: f64) -> bool {
        let jump = |before: &(f64, f64)| (position_m - before.1).abs() > self.settings.wanted_jump_m;
        let jumped = self.samples.back().is_some_and(jump);
        if jumped {
            self.open();
            self.samples.clear();
        }
        if self.samples.len() == SAMPLES {
            self.samples.pop_front();
        }
        self.samples.push_back((stamp_s, position_m));
        self.pair();
        jumped
    }

    /// Compares both positions at the status' own time.
    fn pair(&mut self) {
        let Some((stamp_s, wanted_m)) = self.waiting else { return };
        let after = self.samples.partition_point(|sample| sample.0 < stamp_s);
        let (Some(left), Some(right)) =
            (after.checked_sub(1).and_then(|index| self.samples.get(index)), self.samples.get(after))
        else {
            return;
        };
        self.waiting = None;
        let span_s = right.0 - left.0;
        if span_s > self.settings.pairing_s {
            return;
        }
        let measured_m = left.1 + (right.1 - left.1) * (stamp_s - left.0) / span_s;
        let origin_m = *self.origin_m.get_or_insert(wanted_m - measured_m);
        self.shortfall_m = wanted_m - measured_m - origin_m;
    }
}
