//! S4: readings that jump about: noise and spikes of a loose plug or a wire beside the heater's.
//!
//! A reading is off if it differs from the median of the five around it by more than a sound sensor's noise, if it lies
//! beyond both its neighbours by as much, where every other one is off, or if no hot end can be so hot or cold. The median
//! follows every ramp and every lasting step. One spike is one reading off, wherever it comes.

use models::units::Celsius;

use crate::params::NoiseParams;

/// Readings of the median.
const SPAN: usize = 5;
/// Most readings that a parameter may ask for.
pub const WINDOW_MAX: usize = 128;

/// Watches one temperature.
#[derive(Debug, Clone)]
pub struct NoiseCheck {
    params: NoiseParams,
    recent_c: [f64; SPAN],
    /// Whether each of them was possible.
    possible: [bool; SPAN],
    seen: usize,
    /// Whether each of the last readings was off, newest at `next - 1`.
    off: [bool; WINDOW_MAX],
    next: usize,
}

impl NoiseCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: NoiseParams) -> Self {
        Self {
            params,
            recent_c: [0.0; SPAN],
            possible: [true; SPAN],
            seen: 0,
            off: [false; WINDOW_MAX],
            next: 0,
        }
    }

    /// Takes a temperature, and whether a hot end can have it.
    pub fn on_sample(&mut self, temp: Celsius, possible: bool) {
        self.recent_c.rotate_left(1);
        self.recent_c[SPAN - 1] = temp.0;
        self.possible.rotate_left(1);
        self.possible[SPAN - 1] = possible;
        self.seen = self.seen.saturating_add(1);
        if self.seen < SPAN {
            return;
        }
        let mut sorted_c = self.recent_c;
        sorted_c.sort_by(f64::total_cmp);
        const MIDDLE: usize = SPAN / 2;
        let from = |other_c: f64| self.recent_c[MIDDLE] - other_c;
        let (before_k, after_k) = (from(self.recent_c[MIDDLE - 1]), from(self.recent_c[MIDDLE + 1]));
        let beyond_k = if before_k * after_k > 0.0 { before_k.abs().min(after_k.abs()) } else { 0.0 };
        let apart_k = from(sorted_c[MIDDLE]).abs().max(beyond_k);
        self.off[self.next] = apart_k > self.params.gate_k || !self.possible[MIDDLE];
        self.next = (self.next + 1) % WINDOW_MAX;
    }

    fn off_among(&self, readings: usize) -> usize {
        (1..=readings.min(WINDOW_MAX))
            .filter(|back| self.off[(self.next + WINDOW_MAX - back) % WINDOW_MAX])
            .count()
    }

    /// Whether too large a share of the window is off.
    #[must_use]
    pub fn tripped(&self) -> bool {
        let share_max = self.params.share_max * self.params.window as f64;
        self.off_among(self.params.window) as f64 > share_max
    }

    /// Share of the window that is off `[-]`.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.off_among(self.params.window) as f64 / self.params.window as f64
    }

    /// Whether so many of the newest readings are off that what moves fast in them means nothing.
    #[must_use]
    pub fn is_suspect(&self) -> bool {
        self.off_among(self.params.suspect_window) >= self.params.suspect_count
    }

    /// Forgets the readings.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(readings_c: impl IntoIterator<Item = f64>) -> NoiseCheck {
        let mut check = NoiseCheck::new(NoiseParams {
            gate_k: 1.0,
            window: 50,
            share_max: 0.2,
            suspect_window: 20,
            suspect_count: 2,
        });
        readings_c.into_iter().for_each(|temp_c| check.on_sample(Celsius(temp_c), temp_c < 400.0));
        check
    }

    #[test]
    fn a_single_spike_is_one_reading_off() {
        let check = after((0..60).map(|number| if number == 50 { 240.0 } else { 210.0 }));
        assert_eq!(check.off_among(50), 1);
        assert!((check.share() - 0.02).abs() < 1e-12);
        assert!(!check.is_suspect() && !check.tripped());
    }

    #[test]
    fn ramps_and_steps_that_stay_are_none() {
        assert_eq!(after((0..60).map(|number| 0.24 * f64::from(number))).off_among(50), 0);
        assert_eq!(after((0..60).map(|number| if number < 30 { 210.0 } else { 240.0 })).off_among(50), 0);
    }

    /// Between two levels no median tells which of them is off.
    #[test]
    fn readings_that_leap_to_and_fro_are_all_off() {
        let to_and_fro = (0..60).map(|number| if number % 2 == 0 { 212.0 } else { 210.0 });
        assert_eq!(after(to_and_fro).off_among(50), 50);
        // Two of three are impossible: the median calls them sound, and the sound one off.
        let short = (0..63).map(|number| if number % 3 == 0 { 210.0 } else { 450.0 });
        assert_eq!(after(short).off_among(48), 48);
        assert_eq!(after((0..60).map(|_| 450.0)).off_among(50), 50, "and none of them need differ");
    }

    /// 20 % of 50 readings are 10: one more trips.
    #[test]
    fn more_than_the_share_trips() {
        let every = |period: u32| (0..60_u32).map(move |n| if n % period == 0 { 240.0 } else { 210.0 });
        assert!(after(every(4)).tripped());
        assert!(!after(every(6)).tripped());
        assert!(after(every(6)).is_suspect());
    }
}
