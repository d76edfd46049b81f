//! Where a balance begins: a reading alone does not say how far the block is ahead of its thermistor.
//!
//! In a heat-up at 2.4 K/s a thermistor with 4.5 s lag is 11 K behind; an observer that began at the reading would see
//! that difference as heat that nobody ordered. A line through the first samples gives the rate, and
//! `T = T_s + tau dT_s/dt` the block.

use models::units::{Celsius, Seconds};

/// Samples of the line: 1 s at 10 Hz; with 0.15 K of noise the rate is known to 0.17 K/s, the block to 0.8 K.
const SAMPLES: usize = 10;

/// A begun balance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Begun {
    /// Thermistor, smoothed `[degC]`.
    pub sensor_c: f64,
    /// Block `[degC]`.
    pub block_c: f64,
}

/// Gathers the first samples.
#[derive(Debug, Clone, Default)]
pub struct Start {
    samples: [(f64, f64); SAMPLES],
    count: usize,
}

impl Start {
    /// Takes a sample; the balance may begin with the last one.
    pub fn on_sample(&mut self, stamp: Seconds, temp: Celsius, lag_s: f64) -> Option<Begun> {
        self.samples[self.count] = (stamp.0, temp.0);
        self.count += 1;
        if self.count < SAMPLES {
            return None;
        }
        self.count = 0;
        #[allow(clippy::cast_precision_loss, reason = "ten")]
        let count = SAMPLES as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| self.samples.iter().map(of).sum::<f64>() / count;
        let (mean_s, mean_c) = (mean(|sample| sample.0), mean(|sample| sample.1));
        let spread: f64 = self.samples.iter().map(|(s, _)| (s - mean_s).powi(2)).sum();
        let rise: f64 = self.samples.iter().map(|(s, c)| (s - mean_s) * (c - mean_c)).sum();
        let rate_k_s = if spread > 0.0 { rise / spread } else { 0.0 };
        let sensor_c = mean_c + rate_k_s * (stamp.0 - mean_s);
        Some(Begun { sensor_c, block_c: sensor_c + lag_s * rate_k_s })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_gives_the_block_ahead_of_its_thermistor() {
        let mut start = Start::default();
        let mut begun = None;
        for number in 0..SAMPLES {
            assert_eq!(begun, None);
            let stamp_s = 5.0 + 0.1 * number as f64;
            begun = start.on_sample(Seconds(stamp_s), Celsius(100.0 + 2.4 * stamp_s), 4.5);
        }
        let begun = begun.unwrap();
        assert!((begun.sensor_c - (100.0 + 2.4 * 5.9)).abs() < 1e-9);
        assert!((begun.block_c - begun.sensor_c - 4.5 * 2.4).abs() < 1e-9);
    }
}
