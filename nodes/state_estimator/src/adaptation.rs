//! Noise of a channel, adapted from its own innovations.
//!
//! A consistent filter's normalised innovations squared have the mean 1. Where the mean over a window is another one,
//! all variances behind the channel's innovation are scaled towards it, slowly and within bounds: at a rate `k` per
//! sample the scale `a` follows `a <- a m^k` with the windowed mean `m`. Since the noise of the measurement and of the
//! states behind it are scaled alike, the filter's gain stays what it was: not what is believed changes, but how
//! firmly. Innovations that the gate rejected, and those before a step that was taken as given, tell of a fault and
//! are not learnt from.

use crate::history::Ring;
use crate::params::RawAdaptation;

/// Smallest windowed mean that is followed `[-]`: twenty innovations of zero are no reason for a jump.
const MEAN_MIN: f64 = 0.05;

/// Most innovations that a window has: `samples` is 100 at most.
const WINDOW_MAX: usize = 100;

/// Scale of a channel's variances.
#[derive(Debug, Clone)]
pub(crate) struct NoiseScale {
    params: RawAdaptation,
    recent: Ring<f64>,
    scale: f64,
}

impl NoiseScale {
    pub(crate) fn new(params: RawAdaptation) -> Self {
        Self { params, recent: Ring::new(WINDOW_MAX), scale: 1.0 }
    }

    /// Other window, bounds and rate from now on; what was learnt stays.
    pub(crate) fn retune(&mut self, params: RawAdaptation) {
        self.params = params;
    }

    /// Variance over the configured one `[-]`.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// Whether more noise would be learnt if the bound let it.
    pub(crate) fn is_at_its_most(&self) -> bool {
        self.scale >= self.params.high
    }

    /// Takes an innovation that passed the gate.
    pub(crate) fn on_accepted(&mut self, nis: f64) {
        self.recent.push(nis);
        let samples = self.params.samples as usize;
        if self.recent.iter().len() >= samples {
            let mean = self.recent.iter().rev().take(samples).sum::<f64>() / f64::from(self.params.samples);
            let followed = self.scale * (mean.max(MEAN_MIN) / self.params.aim).powf(self.params.rate);
            self.scale = followed.clamp(self.params.low, self.params.high);
        }
    }

    /// The innovations so far tell of a step, not of noise.
    pub(crate) fn forget(&mut self) {
        self.recent.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMS: RawAdaptation = RawAdaptation { low: 0.2, high: 4.0, aim: 1.0, rate: 0.05, samples: 10 };

    /// A channel whose true variance is `truth` of the configured one; squares of uniform noise of variance one.
    fn after(samples: u32, truth: f64) -> NoiseScale {
        let mut scale = NoiseScale::new(PARAMS);
        for index in 0..samples {
            // evenly spread over [-sqrt 3, sqrt 3], in a scrambled order
            let uniform = f64::from(index * 37 % 101) / 50.0 - 1.0;
            scale.on_accepted(truth * 3.0 * uniform * uniform / scale.scale());
        }
        scale
    }

    #[test]
    fn it_finds_the_true_variance_from_either_side() {
        for truth in [0.4, 1.0, 2.5] {
            let found = after(600, truth).scale();
            // ten samples of a mean with a relative scatter of 0.9 / sqrt 10, averaged by the rate of 1/20
            assert!((found / truth - 1.0).abs() < 0.15, "{found} for {truth}");
        }
    }

    #[test]
    fn it_stays_within_its_bounds_and_says_when_it_stands_at_the_upper_one() {
        assert!((after(2000, 0.01).scale() - PARAMS.low).abs() < 1e-12);
        let wide = after(2000, 100.0);
        assert!((wide.scale() - PARAMS.high).abs() < 1e-12 && wide.is_at_its_most());
        assert!(!after(600, 2.5).is_at_its_most());
    }

    #[test]
    fn it_moves_slowly_and_not_before_a_full_window() {
        assert!((after(9, 0.1).scale() - 1.0).abs() < 1e-15);
        // one window of a mean of 9 each: below one step of the rate
        let mut scale = NoiseScale::new(PARAMS);
        (0..10).for_each(|_| scale.on_accepted(9.0));
        assert!((scale.scale() - 9.0_f64.powf(PARAMS.rate)).abs() < 1e-12);
        scale.forget();
        let before = scale.scale();
        (0..9).for_each(|_| scale.on_accepted(9.0));
        assert!((scale.scale() - before).abs() < 1e-15, "a forgotten window counts anew");
    }
}
