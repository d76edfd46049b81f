//! P3 over seconds: a reading that sinks faster than any heater cools, though by little from one reading to the next.
//!
//! The balance takes such a reading for its own error and begins anew at the false level, while the firmware heats the block
//! to where the reading was. Medians of a second or more are compared: spikes and noise sink nothing.

use super::median::Median;
use models::units::{Celsius, Seconds};

/// Medians that are looked back on.
const MEDIANS: usize = 8;
/// Times over which two medians are compared `[s]`.
const BACK_S: std::ops::RangeInclusive<f64> = 2.5..=6.5;
/// A smaller fall is not judged `[K]`: the block's own, and noise.
const LEAST_K: f64 = 8.0;
/// Share of the fastest credible fall from reading to reading that no heater keeps up for seconds `[-]`.
const SHARE: f64 = 0.5;
/// Medians in a row that have to have sunk.
const SUNK: u32 = 2;
/// Readings further apart begin anew: a median of both ends would be of no moment `[s]`.
const GAP_MAX_S: f64 = 1.6;

/// Watches one temperature.
#[derive(Debug, Clone)]
pub(super) struct Sinking {
    /// Fastest fall that is kept up `[K/s]`.
    most_k_s: f64,
    median: Median,
    newest: Option<Seconds>,
    /// When they were taken, newest last.
    medians: [Option<(Seconds, f64)>; MEDIANS],
    sunk: u32,
    fall_k_s: f64,
}

impl Sinking {
    /// A check that has seen nothing; from reading to reading a fall of `fall_k_s` `[K/s]` is credible.
    pub(super) fn new(fall_k_s: f64) -> Self {
        Self {
            most_k_s: SHARE * fall_k_s,
            median: Median::new(),
            newest: None,
            medians: [None; MEDIANS],
            sunk: 0,
            fall_k_s: 0.0,
        }
    }

    /// Takes a temperature of `stamp`.
    pub(super) fn on_sample(&mut self, stamp: Seconds, temp: Celsius) {
        let begun = self.median.since().or(self.medians[MEDIANS - 1].map(|(at, _)| at));
        let was_silent = self.newest.is_some_and(|newest| (stamp - newest).0 > GAP_MAX_S);
        let was_set_back = begun.is_some_and(|begun| stamp < begun);
        if was_silent || was_set_back {
            *self = Self { most_k_s: self.most_k_s, ..Self::new(0.0) };
        }
        self.newest = Some(stamp);
        if let Some(median_c) = self.median.on_sample(stamp, temp) {
            self.compare(stamp, median_c);
        }
    }

    fn compare(&mut self, stamp: Seconds, median_c: f64) {
        let falls = self.medians.iter().flatten().filter_map(|(then, before_c)| {
            let (span_s, fall_k) = ((stamp - *then).0, before_c - median_c);
            (BACK_S.contains(&span_s) && fall_k > LEAST_K).then_some(fall_k / span_s)
        });
        self.fall_k_s = falls.fold(0.0, f64::max);
        self.sunk = if self.fall_k_s > self.most_k_s { self.sunk.saturating_add(1) } else { 0 };
        self.medians.rotate_left(1);
        self.medians[MEDIANS - 1] = Some((stamp, median_c));
    }

    /// How fast it sinks, and what no heater does `[K/s]`, where it has sunk.
    pub(super) fn sunk_k_s(&self) -> Option<(f64, f64)> {
        (self.sunk >= SUNK).then_some((self.fall_k_s, self.most_k_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// When a reading of 10 Hz that stands at 210 degC for 10 s and then changes trips, from then on `[s]`.
    fn sunk_s(change_k: impl Fn(f64, u32) -> f64) -> Option<f64> {
        let mut check = Sinking::new(5.0);
        let tick = (0..700_u32).find(|tick| {
            let time_s = 0.1 * f64::from(*tick) - 10.0;
            let change_k = if time_s < 0.0 { 0.0 } else { change_k(time_s, *tick) };
            check.on_sample(Seconds(110.0 + time_s), Celsius(210.0 + change_k));
            check.sunk_k_s().is_some()
        });
        tick.map(|tick| 0.1 * f64::from(tick) - 10.0)
    }

    /// Steps of 0.5 K from reading to reading, which no spike is and no step.
    #[test]
    fn a_fall_over_seconds_is_found_before_the_block_is_hot() {
        for (fall_k, over_s) in [(24.0, 5.0), (24.0, 6.0), (32.0, 6.0), (40.0, 10.0)] {
            let found_s = sunk_s(|time_s, _| -fall_k * (time_s / over_s).min(1.0));
            assert!(found_s.is_some_and(|found_s| found_s < 5.5), "{fall_k} K in {over_s} s: {found_s:?}");
        }
        assert!(sunk_s(|_, _| -12.0).is_some_and(|found_s| found_s < 5.0), "a step that stays");
    }

    /// All losses together cool a block by 1.7 K/s, and nothing that passes counts.
    #[test]
    fn what_cools_what_is_rough_and_what_passes_is_no_fall() {
        assert_eq!(sunk_s(|time_s, _| -1.7 * time_s), None);
        for step_k in [-7.0, -8.0] {
            assert_eq!(sunk_s(|_, _| step_k), None, "{step_k}");
        }
        assert_eq!(sunk_s(|_, tick| if tick.is_multiple_of(2) { 6.0 } else { -6.0 }), None);
        assert_eq!(sunk_s(|_, tick| if tick % 10 < 4 { -60.0 } else { 0.0 }), None);
        assert_eq!(sunk_s(|time_s, _| if time_s < 0.8 { -20.0 } else { 0.0 }), None);
    }

    #[test]
    fn slow_readings_are_judged_and_time_that_is_set_back_begins_anew() {
        let mut check = Sinking::new(5.0);
        let found_s = (0..30_u32).find(|second| {
            let fallen_k = 4.8 * (f64::from(*second) - 15.0).clamp(0.0, 6.0);
            check.on_sample(Seconds(f64::from(*second)), Celsius(210.0 - fallen_k));
            check.sunk_k_s().is_some()
        });
        assert_eq!(found_s, Some(23), "medians of three readings, two of which have sunk");
        let mut check = Sinking::new(5.0);
        for (from_s, temp_c) in [(100.0, 210.0), (50.0, 180.0)] {
            for tick in 0..50_u32 {
                check.on_sample(Seconds(from_s + 0.1 * f64::from(tick)), Celsius(temp_c));
            }
        }
        assert_eq!(check.sunk_k_s(), None);
    }

    /// Set back by 50 s, and told each reading twice: what follows is judged as ever.
    #[test]
    fn a_fall_is_found_after_time_was_set_back_and_of_readings_that_are_told_twice() {
        let mut check = Sinking::new(5.0);
        let found_s = [100.0, 50.0]
            .into_iter()
            .flat_map(|from_s| (0..200_u32).map(move |tick| (from_s, tick)))
            .find_map(|(from_s, tick)| {
                let time_s = 0.1 * f64::from(tick);
                let fallen_k = if from_s < 100.0 { 4.8 * (time_s - 10.0).clamp(0.0, 6.0) } else { 0.0 };
                for _ in 0..2 {
                    check.on_sample(Seconds(from_s + time_s), Celsius(210.0 - fallen_k));
                }
                check.sunk_k_s().is_some().then_some(time_s - 10.0)
            });
        assert!(found_s.is_some_and(|found_s| (2.0..5.5).contains(&found_s)), "{found_s:?}");
    }

    /// The limit outlives a silence: a block that cools as fast as any can, after one.
    #[test]
    fn what_cools_after_a_silence_is_no_fall() {
        let mut check = Sinking::new(5.0);
        check.on_sample(Seconds(0.0), Celsius(210.0));
        for tick in 0..300_u32 {
            let time_s = 0.1 * f64::from(tick);
            check.on_sample(Seconds(10.0 + time_s), Celsius(210.0 - 1.7 * time_s));
            assert_eq!(check.sunk_k_s(), None, "{time_s}");
        }
    }

    /// A block that cools by 12 K in a silence of 9 s, in the middle of a median.
    #[test]
    fn what_a_silence_hides_has_not_sunk() {
        let mut check = Sinking::new(5.0);
        for (from_s, temp_c) in [(100.0, 210.0), (114.6, 198.0)] {
            for tick in 0..56_u32 {
                check.on_sample(Seconds(from_s + 0.1 * f64::from(tick)), Celsius(temp_c));
                assert_eq!(check.sunk_k_s(), None, "{temp_c} {tick}");
            }
        }
    }
}
