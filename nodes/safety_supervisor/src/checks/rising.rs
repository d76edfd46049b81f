//! P1 where no balance tells: a hot end or bed that warms although its heater is to be off.
//!
//! Behind a latch, heaters off is an order, and a switch that conducts by itself does not hear it; an idle heater is one
//! that nobody orders. Without stamps and constants this asks the reading alone: what is off cools once the lag of the
//! sensor has passed. It looks on beyond the range of S1, where the balance of the block is no longer judged, and through
//! readings that are rough, spiked or mostly lost, where it begins anew over and over: the median of those of a second or
//! more is what is compared.

use super::median::Median;
use models::units::{Celsius, Seconds};

/// Time in which a reading still follows a block that was heated until then, 1.3 lags of a slow sensor `[s]`.
const SETTLE_S: f64 = 6.0;
/// Rise above the least median that no cooling block shows `[K]`.
const RISE_K: f64 = 15.0;
/// A larger step from median to median is not the block's `[K]`.
const JUMP_K: f64 = 25.0;
/// Medians in a row that have to be above.
const ABOVE: u32 = 2;

/// Watches one temperature.
#[derive(Debug, Clone)]
pub struct RisingCheck {
    drift_k_s: f64,
    heard: Seconds,
    off_since: Option<Seconds>,
    median: Median,
    /// The last median and when it was taken.
    newest: Option<(Seconds, f64)>,
    least_c: Option<f64>,
    above: u32,
}

impl RisingCheck {
    /// A check that has seen nothing; what else warms the heater does so by `drift_k_s` at most `[K/s]`.
    #[must_use]
    pub fn new(drift_k_s: f64) -> Self {
        Self {
            drift_k_s,
            heard: Seconds(f64::NEG_INFINITY),
            off_since: None,
            median: Median::new(),
            newest: None,
            least_c: None,
            above: 0,
        }
    }

    /// Takes a temperature received at `now`, and whether the heater is to be off; `None` where nobody knows just now.
    pub fn on_sample(&mut self, now: Seconds, temp: Celsius, is_off: Option<bool>) {
        let set_back = now < std::mem::replace(&mut self.heard, now);
        if is_off == Some(false) || set_back {
            return self.reset();
        }
        let Some(off_since) = self.off_since.or(is_off.map(|_| now)) else { return };
        self.off_since = Some(off_since);
        if (now - off_since).0 < SETTLE_S {
            return;
        }
        if let Some(median_c) = self.median.on_sample(now, temp) {
            self.compare(now, median_c);
        }
    }

    fn compare(&mut self, now: Seconds, median_c: f64) {
        let (then, before_c) = self.newest.replace((now, median_c)).unwrap_or((now, median_c));
        if (median_c - before_c).abs() > JUMP_K {
            (self.least_c, self.above) = (None, 0);
        }
        let drifted_k = self.drift_k_s * (now - then).0;
        let least_c = self.least_c.map_or(median_c, |least_c| median_c.min(least_c + drifted_k));
        self.least_c = Some(least_c);
        self.above = if median_c > least_c + RISE_K { self.above.saturating_add(1) } else { 0 };
    }

    /// Whether it warms while it is to be off.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.above >= ABOVE
    }

    /// Forgets the readings.
    pub fn reset(&mut self) {
        *self = Self::new(self.drift_k_s);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings of 10 Hz from 290 degC on, which change by `rate_k_s`, and by what is added to each; when it trips `[s]`.
    fn tripped_s(rate_k_s: f64, is_off: Option<bool>, added_k: impl Fn(u32) -> f64) -> Option<f64> {
        let mut check = RisingCheck::new(0.05);
        check.on_sample(Seconds(100.0), Celsius(290.0), Some(true));
        let tick = (1..1200_u32).find(|tick| {
            let time_s = 0.1 * f64::from(*tick);
            check.on_sample(
                Seconds(100.0 + time_s),
                Celsius(290.0 + rate_k_s * time_s + added_k(*tick)),
                is_off,
            );
            check.tripped()
        });
        tick.map(|tick| 0.1 * f64::from(tick))
    }

    /// 6 s, the first median at 6.5 s, one that is 15 K above and another: 7.9 s, at 2 K/s less 0.1.
    #[test]
    fn what_warms_while_it_is_to_be_off_is_found() {
        let found = |time_s: Option<f64>| time_s.is_some_and(|time_s| (14.0..18.0).contains(&time_s));
        let (off, sound) = (Some(true), |_| 0.0);
        assert!(found(tripped_s(2.0, off, sound)), "{:?}", tripped_s(2.0, off, sound));
        assert!(found(tripped_s(2.0, None, sound)), "it was to be off when that was known last");
        assert_eq!(tripped_s(2.0, Some(false), sound), None, "it is to heat");
        assert_eq!(tripped_s(-0.5, off, sound), None);
        assert_eq!(tripped_s(0.04, off, sound), None, "the bed below warms it");
    }

    /// Noise of 4 K in turn, and two spikes of 60 K in five readings: neither trips, nor hides a rise.
    #[test]
    fn rough_readings_and_spikes_neither_trip_nor_hide() {
        let rough = |tick: u32| if tick.is_multiple_of(2) { 4.0 } else { -4.0 };
        let spiked = |tick: u32| if tick % 5 < 2 { 60.0 } else { 0.0 };
        for added_k in [rough, spiked] {
            assert_eq!(tripped_s(-0.3, Some(true), added_k), None);
            let time_s = tripped_s(2.0, Some(true), added_k);
            assert!(time_s.is_some_and(|time_s| time_s < 22.0), "{time_s:?}");
        }
    }

    #[test]
    fn a_reading_that_leaps_time_set_back_and_an_order_begin_anew() {
        let mut check = RisingCheck::new(0.05);
        // Takes 3 s of readings; whether it trips.
        let mut take = |from_s: f64, temp_c: f64, is_off: bool| {
            for tick in 0..30 {
                check.on_sample(Seconds(from_s + 0.1 * f64::from(tick)), Celsius(temp_c), Some(is_off));
            }
            check.tripped()
        };
        for (from_s, temp_c) in [(0.0, 25.0), (7.0, 25.0), (10.0, 200.0), (13.0, 200.0)] {
            assert!(!take(from_s, temp_c, true), "a thermistor that was put back");
        }
        assert!(!take(1.0, 216.0, true) && !take(4.0, 216.0, true), "the clock was set back");
        assert!(take(7.0, 220.0, true) || take(10.0, 240.0, true));
        assert!(!take(13.0, 260.0, false) && !take(16.0, 280.0, true) && !take(19.0, 280.0, true));
    }
}
