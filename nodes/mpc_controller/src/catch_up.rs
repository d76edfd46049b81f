//! Extruder loop for hosts that have none: the shortfall of filament, folded into the slip that is sent.
//!
//! A native host feeds `v/(1-ŝ) + k (L_cmd - L_enc)` at 100 Hz (model book 1.7). Other hosts only divide the feed by
//! one minus the slip, so they get the slip that gives the same feed at the mean feed `v̄`:
//! `1/(1 - s_eff) = 1/(1 - ŝ) + k (L_cmd - L_enc)/v̄`. Pressure advance drives the motor forth and back: what is divided by
//! one minus the slip is the feed forth, several times of what is laid, and its mean is `v̄`.
//!
//! What is lacking has been laid thin, and only as much as the melt still lacks of its pressure is made up for: a shortfall
//! beyond `serial_kept_m` fades with `serial_fades_s`, as long as filament is fed. All of it, pushed into later roads, would
//! make them fat.
//!
//! Such hosts act late: a shortfall counts as it will be once a correction acts, and less what is on its way (`pending`).

use crate::params::RawSlip;
use crate::pending::Pending;
use std::collections::VecDeque;

/// Encoder samples kept to meet a status: 0.16 s at 100 Hz.
const SAMPLES: usize = 16;

/// Time over which the feed forth is averaged `[s]`: some ten strokes.
const FORTH_S: f64 = 5.0;

/// Shortfall of filament since the loop closed.
#[derive(Debug, Clone)]
pub(crate) struct CatchUp {
    settings: RawSlip,
    pending: Pending,
    samples: VecDeque<(f64, f64)>,
    waiting: Option<(f64, f64)>,
    newest_wanted: Option<(f64, f64)>,
    /// Mean feed forth `[m/s]`.
    forth_m_s: f64,
    /// Filament is fed.
    feeds: bool,
    /// Wanted less measured position when the loop closed `[m]`: closing it moves nothing.
    origin_m: Option<f64>,
    shortfall_m: f64,
    /// Shortfall that was told as excess `[m]`.
    told_m: f64,
}

impl CatchUp {
    pub(crate) fn new(settings: RawSlip) -> Self {
        Self {
            settings,
            pending: Pending::new(),
            samples: VecDeque::with_capacity(SAMPLES),
            waiting: None,
            newest_wanted: None,
            forth_m_s: 0.0,
            feeds: false,
            origin_m: None,
            shortfall_m: 0.0,
            told_m: 0.0,
        }
    }

    /// Opens the loop; it closes again with the next pair.
    pub(crate) fn open(&mut self) {
        self.origin_m = None;
        (self.shortfall_m, self.told_m) = (0.0, 0.0);
        self.pending.clear();
    }

    /// Filament still owed `[m]`.
    pub(crate) fn shortfall_m(&self) -> f64 {
        self.shortfall_m
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

    /// The slip that is in force.
    pub(crate) fn on_in_force(&mut self, stamp_s: f64, slip: f64) {
        self.pending.on_in_force(stamp_s, slip);
    }

    pub(crate) fn on_wanted(&mut self, stamp_s: f64, wanted_m: f64) {
        if let Some((before_s, before_m)) = self.newest_wanted.replace((stamp_s, wanted_m)) {
            let (dt_s, moved_m) = (stamp_s - before_s, wanted_m - before_m);
            if moved_m.abs() > self.settings.wanted_jump_m {
                self.open();
            } else if dt_s > 0.0 {
                let share = 1.0 - (-dt_s / FORTH_S).exp();
                self.forth_m_s += share * (moved_m.max(0.0) / dt_s - self.forth_m_s);
                self.feeds = moved_m > 0.0;
            }
        }
        self.waiting = Some((stamp_s, wanted_m));
        self.pair();
    }

    pub(crate) fn on_encoder(&mut self, stamp_s: f64, position_m: f64) {
        let jump = |before: &(f64, f64)| (position_m - before.1).abs() > self.settings.wanted_jump_m;
        if self.samples.back().is_some_and(jump) {
            self.open();
            self.samples.clear();
        }
        if self.samples.len() == SAMPLES {
            self.samples.pop_front();
        }
        self.samples.push_back((stamp_s, position_m));
        self.pair();
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

    /// Slip to send at `at_s`, `dt_s` after the last one; what the limit cannot catch up is forgotten, so that nothing winds up.
    pub(crate) fn effective_slip(
        &mut self,
        slip: f64,
        reference_feed_m_s: f64,
        (at_s, dt_s): (f64, f64),
    ) -> f64 {
        let settings = &self.settings;
        let slip = slip.clamp(settings.low, settings.high);
        if settings.serial_gain_1_s <= 0.0 {
            return slip;
        }
        let feed_m_s = reference_feed_m_s.max(self.forth_m_s);
        let most_m = settings.serial_limit * feed_m_s / settings.serial_gain_1_s;
        let lasting_m = self.shortfall_m.clamp(-settings.serial_kept_m, settings.serial_kept_m);
        let fading_m = self.shortfall_m - lasting_m;
        let faded_m =
            if self.feeds { fading_m * (1.0 - (-dt_s / settings.serial_fades_s).exp()) } else { 0.0 };
        let kept_m = (self.shortfall_m - faded_m).clamp(-most_m, most_m);
        if let Some(origin_m) = self.origin_m.as_mut() {
            *origin_m += self.shortfall_m - kept_m;
        }
        self.shortfall_m = kept_m;
        let left_m = (kept_m - lasting_m) * (-self.pending.delay_s() / settings.serial_fades_s).exp();
        let due_m = (lasting_m + left_m - self.pending.extra_m(at_s)).clamp(-most_m, most_m);
        let extra_m_s = settings.serial_gain_1_s * due_m;
        let feed = 1.0 / (1.0 - slip) + extra_m_s / feed_m_s;
        let sent = (1.0 - 1.0 / feed).clamp(settings.low, settings.high);
        self.pending.send(at_s, sent, extra_m_s);
        sent
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: RawSlip = RawSlip {
        encoder_fitted: true,
        low: -0.05,
        high: 0.5,
        serial_gain_1_s: 0.5,
        serial_limit: 0.1,
        serial_kept_m: 1.0,
        serial_fades_s: 0.5,
        pairing_s: 0.05,
        wanted_jump_m: 0.05,
    };

    #[test]
    fn without_a_shortfall_the_slip_itself_is_sent_and_clipped() {
        let mut loop_ = CatchUp::new(SETTINGS);
        assert!((loop_.effective_slip(0.09, 2e-3, (0.0, 0.05)) - 0.09).abs() < 1e-12);
        assert!((loop_.effective_slip(0.9, 2e-3, (0.0, 0.05)) - 0.5).abs() < 1e-12);
        assert!((loop_.effective_slip(-0.9, 2e-3, (0.0, 0.05)) + 0.05).abs() < 1e-12);
    }

    /// The feed that results is the inner loop's: `v/(1-s) + k e`.
    #[test]
    fn a_shortfall_raises_the_feed_by_gain_times_shortfall() {
        let mut loop_ = CatchUp::new(SETTINGS);
        loop_.on_encoder(0.0, 0.0);
        loop_.on_wanted(0.005, 1e-5);
        loop_.on_encoder(0.01, 2e-5);
        assert!(loop_.shortfall_m().abs() < 1e-12, "closing the loop moves nothing");
        loop_.on_wanted(0.015, 1e-5 + 1e-4);
        loop_.on_encoder(0.02, 2e-5);
        // wanted 0.11 mm, measured 0.02 mm, difference at the origin 0
        assert!((loop_.shortfall_m() - 0.9e-4).abs() < 1e-12);
        let feed = 2e-3 / (1.0 - loop_.effective_slip(0.02, 2e-3, (0.0, 0.05)));
        assert!((feed - (2e-3 / 0.98 + 0.5 * 0.9e-4)).abs() < 1e-12);
    }

    /// A status and samples around it.
    fn pair(loop_: &mut CatchUp, at_s: f64, wanted_m: f64, measured_m: f64) {
        loop_.on_encoder(at_s - 0.005, measured_m);
        loop_.on_wanted(at_s, wanted_m);
        loop_.on_encoder(at_s + 0.005, measured_m);
    }

    /// 0.3 mm short, of which 0.1 are kept: `0.1 + 0.2 exp(-t/0.5 s)` mm, and no less while none is fed.
    #[test]
    fn what_was_laid_thin_fades_while_filament_is_fed() {
        let mut loop_ = CatchUp::new(RawSlip { serial_kept_m: 1e-4, ..SETTINGS });
        let (mut wanted_m, mut at_s) = (0.0, 0.0);
        pair(&mut loop_, at_s, wanted_m, 0.0);
        let after_half_m = 1e-4 + 2e-4 * (-1.0_f64).exp();
        for (steps, fed_m, expected_m) in
            [(10, 1e-4, after_half_m), (10, 0.0, after_half_m), (100, 1e-4, 1e-4)]
        {
            for _ in 0..steps {
                (wanted_m, at_s) = (wanted_m + fed_m, at_s + 0.05);
                pair(&mut loop_, at_s, wanted_m, wanted_m - 3e-4);
                loop_.effective_slip(0.0, 2e-3, (0.0, 0.05));
            }
            assert!((loop_.shortfall_m() - expected_m).abs() < 1e-6, "{}", loop_.shortfall_m());
        }
    }

    /// Three steps forth and two back: what is divided by one minus the slip is three times what is laid.
    #[test]
    fn in_strokes_the_shortfall_is_spread_over_what_goes_forth() {
        let mut loop_ = CatchUp::new(SETTINGS);
        let (mut wanted_m, mut at_s) = (0.0, 0.0);
        for step in 0..2000 {
            let stroke_m = if step % 2 == 0 { 3e-4 } else { -2e-4 };
            (wanted_m, at_s) = (wanted_m + stroke_m, at_s + 0.025);
            pair(&mut loop_, at_s, wanted_m, wanted_m - if step > 0 { 1e-4 } else { 0.0 });
        }
        // 3e-4 in 0.05 s are 6 mm/s: 0.5 1/s of 0.1 mm
        let feed = 1.0 / (1.0 - loop_.effective_slip(0.0, 2e-3, (0.0, 0.05)));
        assert!((feed - 1.0 - 0.5 * 1e-4 / 6e-3).abs() < 1e-4, "{feed}");
    }

    /// Largest shortfall in the last 10 of 20 s behind 0.1 mm that is lacking at first, with a gain of 1.5 1/s on a host that
    /// acts 1.5 s late, and tells so or does not.
    fn rest_of_a_late_loop(tells: bool) -> f64 {
        let mut loop_ = CatchUp::new(RawSlip { serial_gain_1_s: 1.5, serial_limit: 0.3, ..SETTINGS });
        let mut sent = vec![0.0; 30];
        let (mut wanted_m, mut delivered_m, mut rest_m) = (0.0, 0.0, 0.0_f64);
        for step in 0..400 {
            let (at_s, in_force) = (0.05 * f64::from(step), sent[sent.len() - 30]);
            wanted_m += 1e-4;
            delivered_m += if step == 1 { 0.0 } else { 1e-4 / (1.0 - in_force) };
            pair(&mut loop_, at_s, wanted_m, delivered_m);
            if tells {
                loop_.on_in_force(at_s, in_force);
            }
            sent.push(loop_.effective_slip(0.0, 2e-3, (at_s, 0.05)));
            rest_m = if step < 200 { 0.0 } else { rest_m.max(loop_.shortfall_m().abs()) };
        }
        rest_m
    }

    #[test]
    fn what_is_on_its_way_is_not_sent_once_more() {
        let (known_m, unknown_m) = (rest_of_a_late_loop(true), rest_of_a_late_loop(false));
        assert!(known_m < 5e-6 && unknown_m > 1e-4, "{known_m} m, {unknown_m} m where the delay is not told");
    }

    #[test]
    fn what_the_limit_cannot_catch_up_is_forgotten() {
        let mut loop_ = CatchUp::new(SETTINGS);
        loop_.on_encoder(0.0, 0.0);
        loop_.on_wanted(0.005, 0.0);
        loop_.on_encoder(0.01, 0.0);
        loop_.on_wanted(0.015, 0.01);
        loop_.on_encoder(0.02, 0.0);
        loop_.effective_slip(0.0, 2e-3, (0.0, 0.05));
        // 10 % of 2 mm/s at 0.5 1/s
        assert!((loop_.shortfall_m() - 0.4e-3).abs() < 1e-12);
        loop_.on_wanted(0.025, 0.01);
        loop_.on_encoder(0.03, 0.0);
        assert!((loop_.shortfall_m() - 0.4e-3).abs() < 1e-12);
    }
}
