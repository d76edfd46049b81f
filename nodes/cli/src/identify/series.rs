//! Signals between their samples.

use super::record::At;

/// Value of a line through samples in the order of time; the ends are held. Zero where there is no sample.
pub(super) fn at(samples: &[At], time_s: f64) -> f64 {
    let next = samples.partition_point(|(at_s, _)| *at_s <= time_s);
    match (next.checked_sub(1).and_then(|before| samples.get(before)), samples.get(next)) {
        (Some(&(from_s, from)), Some(&(to_s, to))) => {
            from + (to - from) * (time_s - from_s) / (to_s - from_s)
        }
        (Some(&(_, value)), None) | (None, Some(&(_, value))) => value,
        (None, None) => 0.0,
    }
}

/// What a sample says of the time around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Says {
    /// It holds until the next one, as what a firmware has just switched.
    Onward,
    /// It is the mean of the time since the one before.
    Mean,
    /// It is of its own moment: between two the signal is a line.
    Moment,
}

/// Integral of a signal: a line between its samples, so [`at`] is exact for a mean.
pub(super) fn integral(samples: impl Iterator<Item = At>, says: Says) -> Vec<At> {
    let mut sum = Vec::new();
    let (mut total, mut last): (f64, Option<At>) = (0.0, None);
    for (at_s, value) in samples {
        if let Some((before_s, before)) = last {
            let mean = match says {
                Says::Onward => before,
                Says::Mean => value,
                Says::Moment => 0.5 * (before + value),
            };
            total += mean * (at_s - before_s);
        }
        sum.push((at_s, total));
        last = Some((at_s, value));
    }
    sum
}

/// Mean of the signal behind an [`integral`] between two times.
pub(super) fn mean(integral: &[At], from_s: f64, to_s: f64) -> f64 {
    (at(integral, to_s) - at(integral, from_s)) / (to_s - from_s)
}

/// How often there is a sample `[1/s]`, by the median gap.
pub(super) fn rate_hz(times: impl Iterator<Item = f64>) -> f64 {
    let times: Vec<f64> = times.collect();
    let mut gaps_s: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    gaps_s.sort_by(f64::total_cmp);
    gaps_s.get(gaps_s.len() / 2).map_or(0.0, |gap_s| 1.0 / gap_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_holds_onward_or_is_a_mean_or_a_moment() {
        let samples = [(0.0, 1.0), (1.0, 3.0), (3.0, 0.0), (4.0, 0.0)];
        // 0.5 s of 1 and 1 s of 3 over 1.5 s.
        let held = integral(samples.into_iter(), Says::Onward);
        assert!((mean(&held, 0.5, 2.0) - 3.5 / 1.5).abs() < 1e-12);
        // 0.5 s of 3 and 1 s of 0 over 1.5 s.
        let told = integral(samples.into_iter(), Says::Mean);
        assert!((mean(&told, 0.5, 2.0) - 1.0).abs() < 1e-12);
        // 0.5 s of 2 and 2 s of 1.5.
        let seen = integral(samples.into_iter(), Says::Moment);
        assert!((mean(&seen, 0.5, 3.0) - (0.5 * 2.0 + 2.0 * 1.5) / 2.5).abs() < 1e-12);
        assert!((at(&[(0.0, 0.0), (2.0, 4.0)], 0.5) - 1.0).abs() < 1e-12);
        assert!((at(&[(0.0, 7.0)], 9.0) - 7.0).abs() < 1e-12 && at(&[], 1.0).abs() < 1e-12);
    }
}
