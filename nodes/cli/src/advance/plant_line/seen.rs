//! Errors of a printed line, by way and by stretch.

use advance_predictor::compensation::calibration::Line;

/// Sums of errors over a way.
#[derive(Debug, Clone, Copy, Default)]
struct Unevenness {
    way_m: f64,
    sum_m: f64,
    squares_m: f64,
}

impl Unevenness {
    fn add(&mut self, error: f64, way_m: f64) {
        self.way_m += way_m;
        self.sum_m += error * way_m;
        self.squares_m += error * error * way_m;
    }

    /// Mean; `None` before any way.
    fn mean(&self) -> Option<f64> {
        (self.way_m > 0.0).then(|| self.sum_m / self.way_m)
    }

    /// Mean square about the mean; `None` before any way.
    fn mean_square(&self) -> Option<f64> {
        Some(self.squares_m / self.way_m - self.mean()?.powi(2))
    }
}

/// Errors of a line: of all of it, and of its slow and its fast stretches.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Seen {
    whole: Unevenness,
    slow: Unevenness,
    fast: Unevenness,
}

impl Seen {
    /// Adds an error over a way, on a slow stretch or on the fast one.
    pub(super) fn add(&mut self, error: f64, (way_m, slow): (f64, bool)) {
        let stretch = if slow { &mut self.slow } else { &mut self.fast };
        stretch.add(error, way_m);
        self.whole.add(error, way_m);
    }

    /// The line; `None` before any way on either.
    pub(super) fn line(&self) -> Option<Line> {
        Some(Line { square: self.whole.mean_square()?, thin: self.slow.mean()? - self.fast.mean()? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line that is wrong by as much everywhere is even.
    #[test]
    fn a_constant_error_is_no_unevenness() {
        let mut seen = Unevenness::default();
        assert_eq!(seen.mean_square(), None);
        for _ in 0..10 {
            seen.add(0.25, 1e-3);
        }
        assert!(seen.mean_square().unwrap().abs() < 1e-15);
    }

    /// 10 % too narrow over a fast third, 2 % over the slow rest: 8 % thinner, and 1/3 2/3 of 8 % squared about the mean.
    #[test]
    fn a_fast_stretch_is_thinner_by_its_mean() {
        let mut seen = Seen::default();
        seen.add(-0.02, (2e-3, true));
        assert_eq!(seen.line(), None);
        seen.add(-0.10, (1e-3, false));
        let Line { square, thin } = seen.line().unwrap();
        assert!(
            (thin - 0.08).abs() < 1e-12 && (square - 2.0 / 9.0 * 0.0064).abs() < 1e-12,
            "{square} {thin}"
        );
    }
}
