//! A dip of the flow that passes by itself: a clog that has just narrowed, a bubble, a knot in the spool.
//!
//! While the encoder vouches for the feed, what goes in comes out: a section that jumps tells of filament that is being
//! compressed, and the error fades with the lag of the melt. Correcting it would only add the opposite error once it has
//! faded (model book 1.12: do not learn while the innovation is beyond its bound).

/// A large error, and how much of it is still in the road.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Transient {
    error: f64,
    at_s: f64,
}

impl Transient {
    /// Magnitude of what is left of it at `now_s` under a fading of time constant `fade_s` > 0; unit of the errors.
    #[must_use]
    pub fn rest(&self, now_s: f64, fade_s: f64) -> f64 {
        self.error * (-(now_s - self.at_s).max(0.0) / fade_s).exp()
    }

    /// An error at `now_s` that was beyond its bound; a smaller one than the rest is the rest.
    pub fn on_error(&mut self, now_s: f64, error: f64, fade_s: f64) {
        if error.abs() > self.rest(now_s, fade_s) {
            (self.error, self.at_s) = (error.abs(), now_s);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_error_counts_until_it_has_faded() {
        let mut transient = Transient::default();
        assert!(transient.rest(5.0, 2.0).abs() < 1e-15);
        transient.on_error(10.0, -0.3, 2.0);
        transient.on_error(11.0, -0.1, 2.0);
        // 0.3 exp(-0.5) = 0.182 is more than 0.1: the second one is the first one's rest
        assert!((transient.rest(12.0, 2.0) - 0.3 * (-1.0_f64).exp()).abs() < 1e-12);
        transient.on_error(12.0, 0.2, 2.0);
        assert!((transient.rest(12.0, 2.0) - 0.2).abs() < 1e-12);
        assert!(transient.rest(20.0, 2.0) < 0.01);
    }
}
