//! Simulated time as a whole number of nanoseconds: a sum of rounded steps would drift.

use models::units::Seconds;

/// Time since the start.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Elapsed {
    ns: u64,
}

impl Elapsed {
    /// The time after another step.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, clippy::cast_precision_loss)]
    pub(super) fn step(&mut self, dt: Seconds) -> Seconds {
        self.ns += (dt.0 * 1e9).round() as u64;
        Seconds(self.ns as f64 / 1e9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_hour_of_milliseconds_is_an_hour() {
        let mut elapsed = Elapsed::default();
        let now = (0..3_600_000).map(|_| elapsed.step(Seconds(1e-3))).last();
        assert_eq!(now, Some(Seconds(3600.0)));
    }
}
