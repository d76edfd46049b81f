//! Fewer samples for tools: means of blocks.

use models::units::Seconds;

/// The mean of a block of samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thinned {
    /// Middle of the block.
    pub stamp: Seconds,
    /// Mean acceleration, gravity included `[m/s2]`.
    pub mean_m_s2: [f64; 3],
    /// Variance of each axis of the mean, noise being white: `sigma^2/n` `[m2/s4]`.
    pub variance_m2_s4: f64,
}

/// Cuts a stream into blocks of equal length that have no gap inside.
#[derive(Debug, Clone)]
pub(crate) struct Thinner {
    block: u32,
    sigma_m_s2: f64,
    count: u32,
    begin: Seconds,
    sum_m_s2: [f64; 3],
}

impl Thinner {
    /// From `rate_hz` down to at most `output_hz`.
    /// Another noise of a sample `[m/s2]`.
    pub(crate) fn retune(&mut self, sigma_m_s2: f64) {
        self.sigma_m_s2 = sigma_m_s2;
    }

    pub(crate) fn new(rate_hz: f64, output_hz: f64, sigma_m_s2: f64) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the parameters bound it")]
        let block = (rate_hz / output_hz).ceil().clamp(1.0, 1e6) as u32;
        Self { block, sigma_m_s2, count: 0, begin: Seconds(0.0), sum_m_s2: [0.0; 3] }
    }

    /// Drops the block that is open.
    pub(crate) fn restart(&mut self) {
        self.count = 0;
        self.sum_m_s2 = [0.0; 3];
    }

    pub(crate) fn add(&mut self, stamp: Seconds, period: Seconds, sample: [f64; 3]) -> Option<Thinned> {
        if self.count == 0 {
            self.begin = stamp;
        }
        for (sum, value) in self.sum_m_s2.iter_mut().zip(sample) {
            *sum += value;
        }
        self.count += 1;
        if self.count < self.block {
            return None;
        }
        let samples = f64::from(self.block);
        let thinned = Thinned {
            stamp: self.begin + Seconds(0.5 * (samples - 1.0) * period.0),
            mean_m_s2: self.sum_m_s2.map(|sum| sum / samples),
            variance_m2_s4: self.sigma_m_s2.powi(2) / samples,
        };
        self.restart();
        Some(thinned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_has_the_mean_the_middle_and_the_variance_of_its_samples() {
        let mut thinner = Thinner::new(1000.0, 250.0, 0.3);
        let found: Vec<_> = (0..8)
            .filter_map(|index| {
                let time_s = 1e-3 * f64::from(index);
                thinner.add(Seconds(time_s), Seconds(1e-3), [f64::from(index), 0.0, 9.81])
            })
            .collect();
        assert_eq!(found.len(), 2);
        // samples 4..=7: mean 5.5 at 5.5 ms; 0.3^2/4
        assert!((found[1].mean_m_s2[0] - 5.5).abs() < 1e-12);
        assert!((found[1].stamp.0 - 5.5e-3).abs() < 1e-12);
        assert!((found[1].variance_m2_s4 - 0.0225).abs() < 1e-12);
    }

    #[test]
    fn a_rate_that_is_no_multiple_stays_below_the_limit() {
        // 1600 Hz / 100 Hz = 16; 1066 / 100 -> 11, not 10
        for (rate_hz, block) in [(1600.0, 16), (1066.0, 11), (50.0, 1)] {
            assert_eq!(Thinner::new(rate_hz, 100.0, 0.3).block, block);
        }
    }
}
