//! P1 behind a latch: a hot end that warms although its heater is to be off.
//!
//! Heaters off is an order, and a switch that conducts by itself does not hear it. Without orders, stamps and constants
//! this asks the reading alone: what is off cools once the lag of the sensor has passed. It looks on beyond the range of
//! S1, where the balance of the block is no longer judged.

use models::units::{Celsius, Seconds};

/// Time in which a reading still follows a block that was heated until then, 1.3 lags of a slow sensor `[s]`.
const SETTLE_S: f64 = 6.0;
/// Rise above the least reading that no cooling block shows, ten deviations of a noisy reading `[K]`.
const RISE_K: f64 = 15.0;
/// A larger step from reading to reading is not the block's `[K]`.
const JUMP_K: f64 = 10.0;
/// Readings in a row that have to be above.
const SAMPLES: u32 = 3;

/// Watches one temperature.
#[derive(Debug, Clone, Default)]
pub struct RisingCheck {
    off_since: Option<Seconds>,
    newest_c: Option<f64>,
    least_c: Option<f64>,
    above: u32,
}

impl RisingCheck {
    /// Takes a temperature received at `now`; `is_off` while the heater is to be off.
    pub fn on_sample(&mut self, now: Seconds, temp: Celsius, is_off: bool) {
        let near = self.newest_c.is_some_and(|newest_c| (temp.0 - newest_c).abs() <= JUMP_K);
        self.newest_c = Some(temp.0);
        let Some(since) = self.off_since.filter(|since| is_off && near && *since <= now) else {
            (self.off_since, self.least_c, self.above) = (is_off.then_some(now), None, 0);
            return;
        };
        if (now - since).0 < SETTLE_S {
            return;
        }
        let least_c = self.least_c.map_or(temp.0, |least_c| least_c.min(temp.0));
        self.least_c = Some(least_c);
        self.above = if temp.0 > least_c + RISE_K { self.above.saturating_add(1) } else { 0 };
    }

    /// Whether it warms while it is to be off.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.above >= SAMPLES
    }

    /// Forgets the readings.
    pub fn reset(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings of 10 Hz from 290 degC on, which change by `rate_k_s`, one in twenty by `spike_k`; when it trips `[s]`.
    fn tripped_s(rate_k_s: f64, is_off: bool, spike_k: f64) -> Option<f64> {
        let mut check = RisingCheck::default();
        let tick = (0..600_u32).find(|tick| {
            let time_s = 0.1 * f64::from(*tick);
            let spike_k = if tick % 20 == 7 { spike_k } else { 0.0 };
            check.on_sample(Seconds(100.0 + time_s), Celsius(290.0 + rate_k_s * time_s + spike_k), is_off);
            check.tripped()
        });
        tick.map(|tick| 0.1 * f64::from(tick))
    }

    /// 15 K at 2 K/s after 6 s, and three readings.
    #[test]
    fn what_warms_while_it_is_to_be_off_is_found() {
        assert!(tripped_s(2.0, true, 0.0).is_some_and(|time_s| (13.5..14.0).contains(&time_s)));
        assert_eq!(tripped_s(2.0, false, 0.0), None, "it is to heat");
        assert_eq!(tripped_s(-0.5, true, 0.0), None);
        assert_eq!(tripped_s(0.0, true, -9.0), None, "a spike is no rise");
    }

    #[test]
    fn a_reading_that_leaps_and_time_set_back_begin_anew() {
        let mut check = RisingCheck::default();
        let mut take = |stamp_s: f64, temp_c: f64| {
            check.on_sample(Seconds(stamp_s), Celsius(temp_c), true);
            check.tripped()
        };
        for (stamp_s, temp_c) in [(0.0, 25.0), (7.0, 25.0), (7.1, 200.0), (7.2, 200.0), (7.3, 200.0)] {
            assert!(!take(stamp_s, temp_c), "a thermistor that was put back");
        }
        for stamp_s in [1.0, 1.1, 8.0, 8.1, 8.2] {
            assert!(!take(stamp_s, 200.0));
        }
        let rise = [(8.3, 209.0), (8.4, 216.0), (8.5, 216.0)].map(|(stamp_s, temp_c)| take(stamp_s, temp_c));
        assert!(rise.iter().all(|tripped| !tripped) && take(8.6, 216.0));
    }
}
