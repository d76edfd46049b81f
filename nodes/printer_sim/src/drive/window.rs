//! A triangular window: two running means, one after the other.

use std::collections::VecDeque;

/// Running mean over a fixed number of samples.
#[derive(Debug, Clone, PartialEq)]
struct Mean {
    values: VecDeque<f64>,
}

impl Mean {
    fn step(&mut self, value: f64) -> f64 {
        self.values.pop_front();
        self.values.push_back(value);
        #[allow(clippy::cast_precision_loss, reason = "a few dozen samples")]
        let count = self.values.len() as f64;
        self.values.iter().sum::<f64>() / count
    }
}

/// The window: what goes in comes out smoothed, half a window later.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Window {
    means: [Mean; 2],
}

impl Window {
    /// A window that has seen nothing but `value`; it reaches `half_s` either way in steps of `dt_s`.
    pub(super) fn new(value: f64, (half_s, dt_s): (f64, f64)) -> Self {
        // half a window is 1 s at most and a step 1 ms or so
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "bounded above and positive"
        )]
        let samples = (half_s / dt_s).round().max(1.0) as usize;
        let mean = Mean { values: std::iter::repeat_n(value, samples).collect() };
        Self { means: [mean.clone(), mean] }
    }

    pub(super) fn step(&mut self, value: f64) -> f64 {
        self.means.iter_mut().fold(value, |value, mean| mean.step(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step comes out as the window's integral: half of it after half a window, all of it after the whole.
    #[test]
    fn a_step_is_spread_evenly_around_half_a_window() {
        let mut window = Window::new(0.0, (0.02, 1e-3));
        let out: Vec<f64> = (0..45).map(|_| window.step(1.0)).collect();
        // 20 samples a mean: after k samples k/20 of the first mean, summed by the second: 210/400 after 20
        assert!((out[19] - 0.525).abs() < 1e-12 && (out[38] - 1.0).abs() < 1e-12);
        assert!(out.windows(2).all(|pair| pair[1] >= pair[0]));
    }
}
