//! Small errors are left alone: without a disturbance corrections only add noise (model book 1.9).

use crate::params::RawDeadband;

impl RawDeadband {
    /// Relative error that is acted on.
    #[must_use]
    pub fn relative(&self, error: f64) -> f64 {
        shaped(error, self.start, self.full)
    }

    /// Temperature error that is acted on `[K]`.
    #[must_use]
    pub fn temperature_k(&self, error_k: f64) -> f64 {
        shaped(error_k, self.start_k, self.full_k)
    }
}

/// Zero up to `start`, the error itself from `full` on, a straight line between: no jump anywhere.
fn shaped(error: f64, start: f64, full: f64) -> f64 {
    ((error.abs() - start) / (full - start) * full).clamp(0.0, error.abs()).copysign(error)
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAND: RawDeadband = RawDeadband { start: 0.01, full: 0.02, start_k: 2.0, full_k: 4.0 };

    #[test]
    fn it_is_odd_continuous_and_the_identity_outside() {
        let mut before = BAND.relative(-0.05);
        for step in -500..=500 {
            let error = f64::from(step) * 1e-4;
            let acted = BAND.relative(error);
            // steepest slope: full / (full - start) = 2
            assert!((acted - before).abs() <= 2.0 * 1e-4 + 1e-12);
            assert!((acted + BAND.relative(-error)).abs() < 1e-15);
            before = acted;
        }
        assert!(BAND.relative(0.009_9).abs() < 1e-15);
        assert!((BAND.relative(0.03) - 0.03).abs() < 1e-15);
        assert!((BAND.temperature_k(-5.0) + 5.0).abs() < 1e-15);
    }
}
