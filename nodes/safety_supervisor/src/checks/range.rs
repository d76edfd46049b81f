//! S1: thermistor open (far too cold) or short (far too hot).

use models::units::{Celsius, Seconds};

use super::pace::{COUNTED_PERIOD_S, Pace};

use crate::params::RangeParams;

/// Readings in a row that are sound.
const SOUND: u32 = 10;
/// So many slow readings in a row are no spike, where they lie as far apart as `samples` of 10 Hz do.
const SLOW: u32 = 2;

/// Watches one temperature.
#[derive(Debug, Clone)]
pub struct RangeCheck {
    params: RangeParams,
    pace: Pace,
    newest: Option<Celsius>,
    inside: bool,
    outside: u32,
    /// Since when they are outside.
    since: Option<Seconds>,
    /// For how long the newest ones have been outside `[s]`.
    for_s: f64,
    /// Readings in a row that were inside.
    sound: u32,
}

impl RangeCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: RangeParams) -> Self {
        Self {
            params,
            pace: Pace::default(),
            newest: None,
            inside: true,
            outside: 0,
            since: None,
            for_s: 0.0,
            sound: 0,
        }
    }

    /// Takes a temperature received at `now`.
    pub fn on_sample(&mut self, now: Seconds, temp: Celsius) {
        self.newest = Some(temp);
        self.inside = (self.params.min_c..=self.params.max_c).contains(&temp.0);
        let counts = self.pace.counts(now);
        self.sound = if self.inside { self.sound.saturating_add(u32::from(counts)) } else { 0 };
        self.outside = if self.inside { 0 } else { self.outside.saturating_add(u32::from(counts)) };
        self.since = if self.inside { None } else { self.since.or(Some(now)) };
        self.for_s = self.since.map_or(0.0, |since| (now - since).0);
    }

    /// Whether enough samples in a row were outside; a single spike is not.
    #[must_use]
    pub fn tripped(&self) -> bool {
        let span_s = COUNTED_PERIOD_S * f64::from(self.params.samples);
        self.outside >= self.params.samples || self.outside >= SLOW && self.for_s >= span_s
    }

    /// The newest sample; `None` before the first.
    #[must_use]
    pub fn newest(&self) -> Option<Celsius> {
        self.newest
    }

    /// The end of the range `[degC]` that the newest sample lies beyond; `None` inside.
    #[must_use]
    pub fn limit_c(&self) -> Option<f64> {
        let Celsius(newest_c) = self.newest?;
        let Self { params: RangeParams { min_c, max_c, .. }, .. } = self;
        if newest_c > *max_c { Some(*max_c) } else { (newest_c < *min_c).then_some(*min_c) }
    }

    /// Whether the newest samples were inside, so many in a row that no loose plug shows: ten, or 1 s.
    #[must_use]
    pub fn is_well(&self) -> bool {
        self.sound >= SOUND
    }

    /// Whether the newest sample was inside.
    #[must_use]
    pub fn is_inside(&self) -> bool {
        self.inside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Open or short within 0.5 s at 10 Hz, and two periods more where they are longer.
    #[test]
    fn a_range_of_slow_readings_trips_with_the_second_one() {
        for (period_s, within_s) in [(0.1, 0.2), (0.25, 0.5), (0.5, 0.5), (1.0, 1.0)] {
            let mut check = RangeCheck::new(RangeParams { min_c: 0.0, max_c: 285.0, samples: 3 });
            check.on_sample(Seconds(9.0), Celsius(300.0));
            check.on_sample(Seconds(9.0 + period_s), Celsius(210.0));
            let mut since_s = 0.0;
            loop {
                assert!(!check.tripped(), "{period_s} s: a spike, or too soon");
                check.on_sample(Seconds(20.0 + since_s), Celsius(-20.0));
                if since_s >= within_s {
                    break;
                }
                since_s += period_s;
            }
            assert!(check.tripped(), "{period_s} s");
        }
    }
}
