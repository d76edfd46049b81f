//! How rough a reading is: the noise that its heater's balance has to live with.
//!
//! The second difference `y_k - 2 y_{k-1} + y_{k-2}` of a heater's readings holds next to nothing of its temperature
//! (2.4 K/s set in over the lag of a thermistor bend a line by 5 mK in 0.1 s) and six times the variance of their
//! noise.

/// Readings over which the variance is smoothed: 3 s at 10 Hz, known to a fifth.
const SMOOTHED: f64 = 30.0;

/// Variance of a second difference over that of one reading.
const SECOND_DIFFERENCE: f64 = 6.0;

/// Follows the standard deviation of a reading's noise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Roughness {
    last_c: [Option<f64>; 2],
    variance_k2: f64,
}

impl Roughness {
    /// Begins with what is usual `[K]`.
    pub(super) fn new(usual_k: f64) -> Self {
        Self { last_c: [None; 2], variance_k2: usual_k.powi(2) }
    }

    /// Takes a reading; one that is left out, or the first after a gap, ends the row.
    pub(super) fn on_sample(&mut self, temp_c: Option<f64>) {
        if let (Some(temp_c), [Some(before_c), Some(first_c)]) = (temp_c, self.last_c) {
            let bend_k = temp_c - 2.0 * before_c + first_c;
            self.variance_k2 += (bend_k.powi(2) / SECOND_DIFFERENCE - self.variance_k2) / SMOOTHED;
        }
        self.last_c = [temp_c, temp_c.and(self.last_c[0])];
    }

    /// Standard deviation of a reading `[K]`.
    pub(super) fn deviation_k(&self) -> f64 {
        self.variance_k2.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Readings of +-a in turn have second differences of +-4a, hence 16 a^2 / 6.
    #[test]
    fn a_zigzag_shows_and_a_ramp_does_not() {
        let mut zigzag = Roughness::new(0.15);
        let mut ramp = zigzag;
        for number in 0..400_u32 {
            zigzag.on_sample(Some(if number % 2 == 0 { 0.3 } else { -0.3 }));
            ramp.on_sample(Some(0.24 * f64::from(number)));
        }
        assert!((zigzag.deviation_k() - 0.3 * (16.0_f64 / 6.0).sqrt()).abs() < 1e-6);
        assert!(ramp.deviation_k() < 1e-3);
    }

    #[test]
    fn what_is_left_out_ends_the_row() {
        let mut check = Roughness::new(0.15);
        for temp_c in [Some(210.0), Some(210.0), None, Some(250.0), Some(250.0), None, Some(10.0)] {
            check.on_sample(temp_c);
        }
        assert!((check.deviation_k() - 0.15).abs() < 1e-12);
        check.on_sample(Some(10.0));
        check.on_sample(Some(10.0));
        assert!(check.deviation_k() < 0.15);
    }
}
