//! Medians of the readings of a second or more: spikes and noise move them little.

use models::units::{Celsius, Seconds};

/// Span of a median `[s]`, and the least readings of it.
const SPAN_S: f64 = 1.0;
const SPAN_READINGS: usize = 3;
/// Most readings of a median; further ones do not count.
const READINGS_MAX: usize = 32;

/// Gathers the readings of the next one.
#[derive(Debug, Clone)]
pub(super) struct Median {
    readings_c: [f64; READINGS_MAX],
    count: usize,
    since: Seconds,
}

impl Median {
    /// Nothing is gathered yet.
    pub(super) fn new() -> Self {
        Self { readings_c: [0.0; READINGS_MAX], count: 0, since: Seconds(0.0) }
    }

    /// When the first reading was taken that waits; `None` where none does.
    pub(super) fn since(&self) -> Option<Seconds> {
        (self.count > 0).then_some(self.since)
    }

    /// Takes a temperature of `stamp`; the median `[degC]` with the last reading of it.
    pub(super) fn on_sample(&mut self, stamp: Seconds, temp: Celsius) -> Option<f64> {
        if self.count == 0 {
            self.since = stamp;
        }
        if let Some(place) = self.readings_c.get_mut(self.count) {
            *place = temp.0;
            self.count += 1;
        }
        if self.count < SPAN_READINGS || (stamp - self.since).0 < SPAN_S {
            return None;
        }
        let readings_c = &mut self.readings_c[..self.count];
        readings_c.sort_by(f64::total_cmp);
        self.count = 0;
        readings_c.get(readings_c.len() / 2).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 2 Hz: three readings a median.
    #[test]
    fn what_waits_is_dated_by_its_first_reading() {
        let mut median = Median::new();
        assert_eq!(median.since(), None);
        for (stamp_s, temp_c, waits_since_s, told_c) in [
            (5.0, 30.0, Some(5.0), None),
            (5.5, 10.0, Some(5.0), None),
            (6.0, 20.0, None, Some(20.0)),
            (6.5, 40.0, Some(6.5), None),
        ] {
            assert_eq!(median.on_sample(Seconds(stamp_s), Celsius(temp_c)), told_c, "{stamp_s}");
            assert_eq!(median.since(), waits_since_s.map(Seconds), "{stamp_s}");
        }
    }
}
