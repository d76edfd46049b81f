//! Readings that come faster, or slower, than the checks are made for.
//!
//! How many readings in a row, or of how many, tell a fault from noise is a count of 10 Hz. Ten times as many in the same
//! time would make each of those checks as much rasher.

use models::units::Seconds;

/// Period of the readings that are counted `[s]`: slower ones have to agree for as long.
pub(super) const COUNTED_PERIOD_S: f64 = 0.1;
/// So many slow ones agree at least: a second spike may look like the first.
pub(super) const SLOW_SAMPLES: u32 = 3;
/// Least time between two readings that count `[s]`: at 10 Hz each does, however unevenly it is stamped.
const PERIOD_MIN_S: f64 = 0.07;

/// Lets readings through at the pace that is counted.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pace {
    newest: Option<Seconds>,
}

impl Pace {
    /// Whether the reading of `stamp` counts. One that is older than the last is for the checks to judge.
    pub fn counts(&mut self, stamp: Seconds) -> bool {
        let since_s = self.newest.map_or(PERIOD_MIN_S, |newest| (stamp - newest).0);
        let counts = !(0.0..PERIOD_MIN_S).contains(&since_s);
        if counts {
            self.newest = Some(stamp);
        }
        counts
    }
}

/// Readings over which their period is smoothed.
const SMOOTHED: f64 = 10.0;
/// Slowest readings that are judged `[s]`.
const PERIOD_MAX_S: f64 = 1.0;

/// How far apart readings come.
#[derive(Debug, Clone, Copy)]
pub(super) struct Period {
    mean_s: f64,
}

impl Period {
    /// Of 10 Hz, until it is known.
    pub(super) const USUAL: Self = Self { mean_s: 0.1 };

    /// Takes the time between two readings `[s]`.
    pub(super) fn on_span(&mut self, span_s: f64) {
        self.mean_s += (span_s.clamp(0.0, PERIOD_MAX_S) - self.mean_s) / SMOOTHED;
    }

    /// Longest span that is no gap `[s]`: `base_s`, and of slow readings so many periods.
    pub(super) fn gap_s(&self, base_s: f64, periods: f64) -> f64 {
        base_s.max(periods * self.mean_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(stamps_s: impl IntoIterator<Item = f64>) -> usize {
        let mut pace = Pace::default();
        stamps_s.into_iter().filter(|stamp_s| pace.counts(Seconds(*stamp_s))).count()
    }

    #[test]
    fn what_comes_at_ten_hertz_or_slower_counts_and_of_faster_streams_as_much() {
        let every = |period_s: f64| (0..200_u32).map(move |number| 50.0 + f64::from(number) * period_s);
        assert_eq!(counted(every(0.25)), 200);
        assert_eq!(counted(every(0.1)), 200);
        // Stamped 25 ms early and late in turn.
        let uneven =
            every(0.1).enumerate().map(|(number, s)| s + if number % 2 == 0 { 0.0125 } else { -0.0125 });
        assert_eq!(counted(uneven), 200);
        // 2 s of 100 Hz, every eighth or so.
        assert!((25..=29).contains(&counted(every(0.01))));
    }

    #[test]
    fn the_same_moment_counts_once_and_time_set_back_counts() {
        assert_eq!(counted([1.0, 1.0, 1.0]), 1);
        assert_eq!(counted([10.0, 1.0, 1.01, 1.1]), 3);
    }
}
