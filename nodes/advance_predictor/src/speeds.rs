//! Lag over the changes of speed that are printed.
//!
//! `K_A` of the paper belongs to its test line, 20 and 80 mm/s. The lag is a secant of the static law `x(u)`, and the law
//! is steeper for slow flows: a corner taken at 8 mm/s needs more. Over changes `du` that hold `dx` more or less filament
//! compressed the `K_A` with the least squares of what is out of place, `dx - K_A du`, is `sum dx du / sum du^2`. A road
//! that begins or ends is such a change too, from and to rest: there the secant is longest.

/// Nothing flows, nothing is compressed.
const REST: [f64; 2] = [0.0, 0.0];

/// Sums over the changes of the last roads, older ones fading.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Speeds {
    product: f64,
    square: f64,
    /// Outlet speed and compressed length at the end of the road before; `None` where none came right before.
    before: Option<[f64; 2]>,
}

impl Speeds {
    /// Adds a road: outlet speed and compressed length at entry, cruise and exit, which fade with `memory_s`.
    pub(crate) fn add(&mut self, [entry, cruise, exit]: [[f64; 2]; 3], duration_s: f64, memory_s: f64) {
        let kept = (-duration_s / memory_s).exp();
        self.product *= kept;
        self.square *= kept;
        if self.before.replace(exit).is_none() {
            self.change(REST, entry);
        }
        self.change(entry, cruise);
        self.change(cruise, exit);
    }

    /// The road has ended: a travel or a stroke of filament follows.
    pub(crate) fn end(&mut self) {
        if let Some(last) = self.before.take() {
            self.change(last, REST);
        }
    }

    fn change(&mut self, from: [f64; 2], to: [f64; 2]) {
        let (outlet, compression) = (to[0] - from[0], to[1] - from[1]);
        self.product += compression * outlet;
        self.square += outlet * outlet;
    }

    /// The lag `[s]`; `None` where no speed has changed.
    pub(crate) fn lag_s(&self) -> Option<f64> {
        // Below a square of (1 nm/s)^2 there is only rounding.
        (self.square > 1e-18).then(|| self.product / self.square)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn before_the_first_road_there_is_no_lag() {
        let mut speeds = Speeds::default();
        speeds.end();
        assert_eq!(speeds.lag_s(), None);
    }

    /// A road at constant speed changes nothing but at its ends: `x(2)/2 = 1/2` for both.
    #[test]
    fn the_ends_of_a_road_are_changes_from_and_to_rest() {
        let mut speeds = Speeds::default();
        speeds.add([[2e-3, 1e-3]; 3], 1.0, 10.0);
        let begun_s = speeds.lag_s().unwrap();
        speeds.end();
        assert!((begun_s - 0.5).abs() < 1e-12 && (speeds.lag_s().unwrap() - 0.5).abs() < 1e-12);
        assert!((speeds.square - 8e-6).abs() < 1e-12);
    }

    /// `x = 0.6 u`: whatever changes, the lag is 0.6 s.
    #[test]
    fn a_linear_law_has_one_lag() {
        let mut speeds = Speeds::default();
        let at = |outlet: f64| [outlet, 0.6 * outlet];
        speeds.add([at(1e-3), at(2e-3), at(1.5e-3)], 1.0, 10.0);
        speeds.add([at(1.5e-3), at(3e-3), at(0.0)], 1.0, 10.0);
        assert!((speeds.lag_s().unwrap() - 0.6).abs() < 1e-12);
    }

    /// Secants 0.8 and 0.6 s over equal changes, the older one faded to `1/e`: `(0.8/e + 0.6)/(1/e + 1)`.
    #[test]
    fn older_changes_fade() {
        let mut speeds = Speeds::default();
        speeds.add([[1e-3, 0.8e-3]; 3], 1.0, 10.0);
        speeds.before = None;
        speeds.add([[1e-3, 0.6e-3]; 3], 10.0, 10.0);
        let share = (-1.0_f64).exp();
        assert!((speeds.lag_s().unwrap() - (0.8 * share + 0.6) / (share + 1.0)).abs() < 1e-12);
    }
}
