//! How rough a reading, or a heater's duty, is: the noise that the heater's balance has to live with.
//!
//! A reading off the line between those before and after it holds next to nothing of its temperature (2.4 K/s set in over
//! the lag of a thermistor bend a line by 3 mK in 0.1 s). With shares `a` and `1 - a` of its neighbours its variance is
//! `1 + a^2 + (1 - a)^2` times that of one reading's noise.

use models::units::Seconds;

/// Readings over which the variance is smoothed: 3 s at 10 Hz, known to a fifth.
const SMOOTHED: f64 = 30.0;
/// Between readings that are farther apart a temperature bends by more than its noise `[s]`.
const APART_MAX_S: f64 = 0.6;

/// Follows the standard deviation of a reading's noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Roughness {
    /// The last reading and the one before it.
    last: [Option<(Seconds, f64)>; 2],
    variance: f64,
}

impl Roughness {
    /// Begins with what is usual, in the unit of the readings.
    pub(super) fn new(usual: f64) -> Self {
        Self { last: [None; 2], variance: usual.powi(2) }
    }

    /// Takes a reading of `stamp`; one that is left out, or the first after a gap, ends the row.
    pub(super) fn on_sample(&mut self, stamp: Seconds, value: Option<f64>) {
        let reading = value.map(|value| (stamp, value));
        let follows = |before: Seconds, after: Seconds| {
            let apart_s = (after - before).0;
            apart_s > 0.0 && apart_s <= APART_MAX_S
        };
        if let (Some((after, end)), [Some((at, middle)), Some((before, start))]) = (reading, self.last)
            && follows(before, at)
            && follows(at, after)
        {
            let share = (at - before).0 / (after - before).0;
            let off = middle - start - share * (end - start);
            let variances = 1.0 + share.powi(2) + (1.0 - share).powi(2);
            self.variance += (off.powi(2) / variances - self.variance) / SMOOTHED;
        }
        self.last = [reading, reading.and(self.last[0])];
    }

    /// Standard deviation of a reading, in its unit.
    pub(super) fn deviation(&self) -> f64 {
        self.variance.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes readings these times apart in turn.
    fn take(check: &mut Roughness, count: u32, apart_s: [f64; 2], reading_c: impl Fn(u32, f64) -> f64) {
        let mut stamp_s = 0.0;
        for number in 0..count {
            check.on_sample(Seconds(stamp_s), Some(reading_c(number, stamp_s)));
            stamp_s += apart_s[(number % 2) as usize];
        }
    }

    /// Readings of +-a in turn lie 2a off their neighbours' line, hence 4 a^2 / 1.5.
    #[test]
    fn a_zigzag_shows_and_a_ramp_does_not_however_it_is_sampled() {
        let zigzag = |number: u32, _| if number.is_multiple_of(2) { 0.3 } else { -0.3 };
        for apart_s in [[0.1, 0.1], [0.05, 0.25], [0.6, 0.6]] {
            let mut ramp = Roughness::new(0.15);
            take(&mut ramp, 400, apart_s, |_, stamp_s| 2.4 * stamp_s);
            assert!(ramp.deviation() < 1e-3, "{apart_s:?}");
        }
        let mut even = Roughness::new(0.15);
        take(&mut even, 400, [0.1, 0.1], zigzag);
        assert!((even.deviation() - 0.3 * (4.0_f64 / 1.5).sqrt()).abs() < 1e-6);
        // A sixth and five sixths: 1 + 1/36 + 25/36.
        let mut uneven = Roughness::new(0.15);
        take(&mut uneven, 400, [0.05, 0.25], zigzag);
        assert!((uneven.deviation() - 0.6 / (62.0_f64 / 36.0).sqrt()).abs() < 1e-6);
    }

    #[test]
    fn what_is_left_out_or_far_apart_ends_the_row() {
        let mut check = Roughness::new(0.15);
        let readings_c = [Some(210.0), Some(210.0), None, Some(250.0), Some(250.0), None, Some(10.0)];
        for (stamp_s, temp_c) in [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6].into_iter().zip(readings_c) {
            check.on_sample(Seconds(stamp_s), temp_c);
        }
        take(&mut check, 50, [0.7, 0.7], |number, _| f64::from(number % 2));
        assert!((check.deviation() - 0.15).abs() < 1e-12);
        take(&mut check, 3, [0.1, 0.1], |_, _| 10.0);
        assert!(check.deviation() < 0.15);
    }
}
