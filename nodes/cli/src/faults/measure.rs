//! A time that was measured many times, as quantiles beside their limits.

use super::catalogue::Bound;
use serde::Serialize;
use std::fmt::Write;

/// What was measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Measure {
    /// What it is.
    pub name: String,
    /// How often it was measured.
    pub count: usize,
    /// Median `[s]`.
    pub p50_s: Option<f64>,
    /// 99 % lie below `[s]`.
    pub p99_s: Option<f64>,
    /// 99.9 % lie below `[s]`; the worst where there are fewer than a thousand.
    pub p999_s: Option<f64>,
    /// Worst `[s]`.
    pub worst_s: Option<f64>,
    /// What is asked for.
    pub limit: Bound,
    /// Whether it is kept; a limit of what was never measured is not.
    pub within_limit: bool,
}

impl Measure {
    /// Sums up the samples.
    #[must_use]
    pub fn of(name: &str, mut samples: Vec<f64>, limit: Bound) -> Self {
        samples.sort_by(f64::total_cmp);
        let (p99_s, p999_s) = (quantile(&samples, 0.99), quantile(&samples, 0.999));
        let kept = |time: Option<f64>, limit: Option<f64>| match (time, limit) {
            (_, None) => true,
            (time, Some(limit_s)) => time.is_some_and(|time| time <= limit_s),
        };
        Self {
            name: name.to_owned(),
            count: samples.len(),
            p50_s: quantile(&samples, 0.5),
            p99_s,
            p999_s,
            worst_s: samples.last().copied(),
            limit,
            within_limit: kept(p99_s, limit.p99_s) && kept(p999_s, limit.p999_s),
        }
    }

    /// In milliseconds, for people.
    #[must_use]
    pub fn text(&self) -> String {
        let quantiles =
            [("p50", self.p50_s), ("p99", self.p99_s), ("p99.9", self.p999_s), ("worst", self.worst_s)];
        let mut text = format!("{} of {}:", self.name, self.count);
        for (name, time) in quantiles {
            // Writing to a string cannot fail.
            _ = write!(
                text,
                " {name} {},",
                time.map_or("-".to_owned(), |time| format!("{:.2} ms", time * 1e3))
            );
        }
        for (name, limit) in [("p99", self.limit.p99_s), ("p99.9", self.limit.p999_s)] {
            if let Some(limit_s) = limit {
                _ = write!(text, " limit of {name} {:.0} ms,", limit_s * 1e3);
            }
        }
        text.trim_end_matches(',').to_owned()
    }
}

/// The smallest sample that a share of all do not exceed.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    #[allow(clippy::cast_precision_loss, reason = "far fewer than 2^53")]
    let rank = (share * sorted.len() as f64).ceil();
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and the length")]
    let rank = rank as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nearest rank: of 1000 samples the 990th and the 999th.
    #[test]
    fn quantiles_are_samples_and_a_limit_of_one_is_kept_or_not() {
        let samples: Vec<f64> = (1..=1000).rev().map(f64::from).collect();
        let limit = Bound { p99_s: Some(990.0), p999_s: Some(998.0) };
        let measure = Measure::of("x", samples, limit);
        assert_eq!((measure.p50_s, measure.p99_s), (Some(500.0), Some(990.0)));
        assert_eq!((measure.p999_s, measure.worst_s), (Some(999.0), Some(1000.0)));
        assert!(!measure.within_limit, "99.9 % lie above 998");
        let kept = Measure::of("x", vec![990.0], Bound { p999_s: None, ..limit });
        assert!(kept.within_limit);
    }

    #[test]
    fn what_was_never_measured_keeps_no_limit() {
        let limit = Bound { p99_s: Some(1.0), p999_s: None };
        assert!(!Measure::of("x", Vec::new(), limit).within_limit);
        assert!(Measure::of("x", Vec::new(), Bound::default()).within_limit);
    }
}
