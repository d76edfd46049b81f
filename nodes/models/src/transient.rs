//! A dip of the flow that passes by itself: a clog that has just narrowed, a bubble, a knot in the spool.
//!
//! While the encoder vouches for the feed, what goes in comes out: a section that jumps tells of filament that is being
//! compressed, and the error fades with the lag of the melt. Correcting it would only add the opposite error once it has
//! faded (model book 1.12: do not learn while the innovation is beyond its bound).

/// Least share of the error that may be left while its fading is still looked at `[-]`.
const LOOKED_AT_MIN: f64 = 0.05;
/// Longest time constant that is believed of a fading, over the least.
const SLOWER_MAX: f64 = 2.5;
/// Rounds in which the time constant is found.
const ROUNDS: u32 = 30;

/// A large error, how fast it fades, and how much of it is still in the road.
///
/// The time constant is read off what follows: the sum of the errors over time is what an exponential leaves below it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Transient {
    error: f64,
    at_s: f64,
    /// Newest error after it, and when `[s]`.
    newest: (f64, f64),
    /// Errors since it over time; unit of the errors times seconds.
    area: f64,
    /// Time constant that they tell `[s]`; 0 before they do.
    fade_s: f64,
}

impl Transient {
    /// Magnitude of what is left of it at `now_s` under a fading of time constant `least_s` > 0, or slower where it has been
    /// seen to be; unit of the errors.
    #[must_use]
    pub fn rest(&self, now_s: f64, least_s: f64) -> f64 {
        let fade_s = self.fade_s.clamp(least_s, SLOWER_MAX * least_s);
        self.error.abs() * (-(now_s - self.at_s).max(0.0) / fade_s).exp()
    }

    /// An error at `now_s` that was beyond its bound; a smaller one than the rest is the rest.
    pub fn on_error(&mut self, now_s: f64, error: f64, least_s: f64) {
        if error.abs() > self.rest(now_s, least_s) {
            *self = Self { error, at_s: now_s, newest: (error, now_s), area: 0.0, fade_s: 0.0 };
        }
    }

    /// Any error at `now_s` after it, in turn.
    pub fn on_rest(&mut self, now_s: f64, error: f64, least_s: f64) {
        let (before, before_s) = self.newest;
        let since_s = now_s - self.at_s;
        if now_s <= before_s || self.rest(now_s, least_s) <= LOOKED_AT_MIN * self.error.abs() {
            return;
        }
        self.area += 0.5 * (before + error) * (now_s - before_s);
        self.newest = (error, now_s);
        let mean = self.area / (self.error * since_s);
        self.fade_s = since_s / fadings(mean);
    }
}

/// Time constants `z` after which an exponential's mean is the share `mean` of its start: `(1 - exp(-z)) / z`.
fn fadings(mean: f64) -> f64 {
    if mean <= 0.0 {
        return f64::INFINITY;
    }
    (0..ROUNDS).fold(1.0 / mean, |z: f64, _| -(-z).exp_m1() / mean)
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

    /// Half a second between errors, as between frames: what is left 6 s after the start is that of the time constant that the
    /// errors themselves have, between the least and two and a half times as much.
    #[test]
    fn a_slower_fading_is_read_off_the_errors() {
        for (true_s, believed_s) in [(0.5, 1.0), (1.0, 1.0), (1.5, 1.5), (2.2, 2.2), (f64::INFINITY, 2.5)] {
            let mut transient = Transient::default();
            transient.on_error(10.0, -0.4, 1.0);
            for step in 1..=12 {
                let since_s = 0.5 * f64::from(step);
                let noise = if step % 2 == 0 { 0.02 } else { -0.02 };
                transient.on_rest(10.0 + since_s, noise - 0.4 * (-since_s / true_s).exp(), 1.0);
            }
            let fade_s = -6.0 / (transient.rest(16.0, 1.0) / 0.4).ln();
            assert!((fade_s / believed_s - 1.0).abs() < 0.08, "{true_s} s read as {fade_s} s");
        }
    }

    /// Errors that change their sign are no rest of it.
    #[test]
    fn an_error_of_the_other_sign_does_not_lengthen_it() {
        let mut transient = Transient::default();
        transient.on_error(0.0, 0.3, 1.0);
        transient.on_rest(0.5, -0.3, 1.0);
        transient.on_rest(1.0, -0.3, 1.0);
        assert!((transient.rest(2.0, 1.0) - 0.3 * (-2.0_f64).exp()).abs() < 1e-12);
    }

    /// An error of nothing before any that was beyond its bound: the next one is still followed.
    #[test]
    fn before_the_first_error_nothing_is_read_off() {
        let mut transient = Transient::default();
        transient.on_rest(1.0, 0.0, 1.0);
        assert!(transient.rest(2.0, 1.0).abs() < 1e-15);
        transient.on_error(3.0, 0.3, 1.0);
        assert!((transient.rest(3.0, 1.0) - 0.3).abs() < 1e-15);
    }
}
