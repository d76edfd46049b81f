//! Signed width error along slicer time, in bins: two runs of a file can be compared although their speeds differ.

/// Width of a bin of slicer time `[s]`.
const BIN_S: f64 = 0.05;
/// Window of the averaged width error of `recovery_time_s` `[s]`.
const WINDOW_S: f64 = 0.5;
/// Least time of deposition in a window `[s]`: half of it.
const LEAST_S: f64 = 0.25;
/// Averaged width error that counts as recovered `[-]`.
const RECOVERED_REL: f64 = 0.02;

/// Sum of error times time, and time, a bin.
#[derive(Debug, Clone, Default)]
pub struct WidthTrace {
    bins: Vec<(f64, f64)>,
}

impl WidthTrace {
    /// Adds a step of `dt_s` with a relative width error at this slicer time.
    pub fn add(&mut self, path_time_s: f64, error_rel: f64, dt_s: f64) {
        let bin = bin_of(path_time_s);
        if bin >= self.bins.len() {
            self.bins.resize(bin + 1, (0.0, 0.0));
        }
        self.bins[bin].0 += error_rel * dt_s;
        self.bins[bin].1 += dt_s;
    }

    /// Time-weighted mean error over bins; `None` where too little was deposited to speak of a width.
    fn mean(&self, bins: std::ops::RangeInclusive<usize>) -> Option<f64> {
        let held = self.bins.get(bins)?;
        let (sum, dt_s) = held.iter().fold((0.0, 0.0), |(sum, time), (error, dt)| (sum + error, time + dt));
        (dt_s >= LEAST_S).then(|| sum / dt_s)
    }

    /// Slicer time from `onset_s` until the averaged error, less that of the fault-free run of the same seed, stays
    /// within 2 %; `None` if it never does.
    #[must_use]
    pub fn recovery_s(&self, fault_free: &Self, onset_s: f64) -> Option<f64> {
        self.recovery_for_s(fault_free, onset_s, f64::INFINITY)
    }

    /// As [`WidthTrace::recovery_s`], but the error has to stay within 2 % for `hold_s` only: what a later corner or
    /// another fault does is not this one's. `None` too where the trace ends earlier. 0.2 s, the least that can be told, is a
    /// width that did not leave 2 % for `hold_s` from the onset on: what acts later than that is not seen here.
    #[must_use]
    pub fn recovery_for_s(&self, fault_free: &Self, onset_s: f64, hold_s: f64) -> Option<f64> {
        let first = bin_of(onset_s);
        let window = bin_of(WINDOW_S).max(1);
        let mut recovered = None;
        for end in first..self.bins.len() {
            if recovered.is_some_and(|since| seconds(end - first - since) >= hold_s) {
                break;
            }
            let bins = first.max((end + 1).saturating_sub(window))..=end;
            let Some(excess) = self.mean(bins.clone()).zip(fault_free.mean(bins)) else { continue };
            if (excess.0 - excess.1).abs() >= RECOVERED_REL {
                recovered = None;
            } else if recovered.is_none() {
                recovered = Some(end - first);
            }
        }
        // The trace has to go on for long enough after it, where the time is bounded.
        let left_s = |since: usize| seconds(self.bins.len().saturating_sub(first + since));
        recovered.filter(|&since| hold_s.is_infinite() || left_s(since) >= hold_s).map(seconds)
    }
}

fn seconds(bins: usize) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "bins of a print are far below 2^52")]
    let count = bins as f64;
    count * BIN_S
}

fn bin_of(time_s: f64) -> usize {
    // Slicer time is finite, not negative and below a month.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded above")]
    let bin = (time_s / BIN_S) as usize;
    bin
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(error: impl Fn(f64) -> f64) -> WidthTrace {
        let mut trace = WidthTrace::default();
        for ms in 0..60_000 {
            let time_s = f64::from(ms) * 1e-3;
            trace.add(time_s, error(time_s), 1e-3);
        }
        trace
    }

    #[test]
    fn recovery_counts_from_the_onset_to_the_last_moment_outside_two_percent() {
        // A dip of 9 % that decays with 1 s: exp(-t) x 9 % = 2 % at ln 4.5 = 1.50 s, later by half the window.
        let hurt = trace(|t| if t < 30.0 { 0.01 } else { 0.01 - 0.09 * (30.0 - t).exp() });
        let recovery_s = hurt.recovery_s(&trace(|_| 0.01), 30.0).unwrap();
        assert!((1.5..2.1).contains(&recovery_s), "{recovery_s}");
    }

    #[test]
    fn a_lasting_error_never_recovers() {
        let hurt = trace(|t| if t < 30.0 { 0.0 } else { -0.05 });
        assert_eq!(hurt.recovery_s(&trace(|_| 0.0), 30.0), None);
    }

    /// Back at 58 s of 60 s: nobody knows what the next 5 s would have shown. 0.45 s later than the error, as the window is.
    #[test]
    fn a_width_that_is_back_just_before_the_end_was_not_back_for_5_s() {
        let sound = trace(|_| 0.0);
        let back_at = |back_s: f64| trace(move |t| if (30.0..back_s).contains(&t) { 0.05 } else { 0.0 });
        assert_eq!(back_at(58.0).recovery_for_s(&sound, 30.0, 5.0), None);
        assert!(back_at(58.0).recovery_s(&sound, 30.0).is_some(), "for good, as far as the print goes");
        let recovery_s = back_at(54.0).recovery_for_s(&sound, 30.0, 5.0).unwrap();
        assert!((24.2..24.5).contains(&recovery_s), "{recovery_s}");
        // a later fault is another one's
        let again = trace(|t| if (30.0..31.0).contains(&t) || t > 50.0 { 0.05 } else { 0.0 });
        let recovery_s = again.recovery_for_s(&sound, 30.0, 5.0).unwrap();
        assert!((1.2..1.5).contains(&recovery_s), "{recovery_s}");
    }

    #[test]
    fn an_error_that_both_runs_share_is_not_counted() {
        let ripple = |t: f64| 0.1 * (7.0 * t).sin();
        // As soon as half a window is known.
        assert_eq!(trace(ripple).recovery_s(&trace(ripple), 30.0), Some(0.2));
    }
}
