//! The slip of primes, as the encoder shows it.

/// Share of a prime's own slip in what the next one is given `[-]`: the encoder's steps are 1 % of a prime.
const LEARNED: f64 = 0.3;
/// Shortest prime that tells anything `[m]`.
const TOLD_M: f64 = 2e-4;

/// What the primes so far have lost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Prime {
    /// Less what the roads were said to lose at the time, as a fault of the gear shows in both `[-]`.
    less_than_roads: f64,
    /// Motor and encoder where the prime under way began `[m]`.
    began: Option<(f64, f64)>,
}

impl Prime {
    /// Slip to make up for now, where roads lose `of_roads`; `at` is the motor's and the encoder's position `[m]`.
    pub(super) fn slip(&mut self, of_roads: f64, primes: bool, at: (f64, f64)) -> f64 {
        match (self.began, primes) {
            (None, true) => self.began = Some(at),
            (Some((motor_m, encoder_m)), false) => {
                self.began = None;
                let pushed_m = at.0 - motor_m;
                if pushed_m > TOLD_M {
                    let lost = 1.0 - (at.1 - encoder_m) / pushed_m;
                    self.less_than_roads += LEARNED * (of_roads - lost - self.less_than_roads);
                }
            }
            (None, false) | (Some(_), true) => {}
        }
        if primes { (of_roads - self.less_than_roads).clamp(0.0, of_roads.max(0.0)) } else { of_roads }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Primes of 0.8 mm that lose `lost`, roads lose `of_roads`: what is made up for at the end.
    fn after(primes: usize, of_roads: f64, lost: f64) -> f64 {
        let (mut prime, mut at, mut slip) = (Prime::default(), (0.0, 0.0), 0.0);
        for _ in 0..primes {
            slip = prime.slip(of_roads, true, at);
            at = (at.0 + 8e-4, at.1 + 8e-4 * (1.0 - lost));
            prime.slip(of_roads, false, at);
        }
        slip
    }

    #[test]
    fn the_first_prime_is_given_what_a_road_loses() {
        assert!((after(1, 0.02, 0.005) - 0.02).abs() < 1e-12);
    }

    #[test]
    fn primes_to_come_are_given_what_primes_lose() {
        assert!((after(30, 0.02, 0.005) - 0.005).abs() < 1e-4);
    }

    #[test]
    fn a_slip_of_roads_and_primes_alike_is_left_as_it_is() {
        assert!((after(30, 0.1, 0.1) - 0.1).abs() < 1e-9);
    }

    #[test]
    fn no_prime_is_given_more_than_a_road() {
        assert!((after(30, 0.02, 0.3) - 0.02).abs() < 1e-12);
    }
}
