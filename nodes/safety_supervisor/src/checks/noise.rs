//! S4: readings that jump about: noise and spikes of a loose plug or a wire beside the heater's.
//!
//! A reading is off if it differs from the median of the five around it by more than a sound sensor's noise; the
//! median follows every ramp and every lasting step. One spike is one reading off, wherever it comes.

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
    seen: usize,
    /// Whether each of the last readings was off, newest at `next - 1`.
    off: [bool; WINDOW_MAX],
    next: usize,
}

impl NoiseCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: NoiseParams) -> Self {
        Self { params, recent_c: [0.0; SPAN], seen: 0, off: [false; WINDOW_MAX], next: 0 }
    }

    /// Takes a temperature.
    pub fn on_sample(&mut self, temp: Celsius) {
        self.recent_c.rotate_left(1);
        self.recent_c[SPAN - 1] = temp.0;
        self.seen = self.seen.saturating_add(1);
        if self.seen < SPAN {
            return;
        }
        let mut sorted_c = self.recent_c;
        sorted_c.sort_by(f64::total_cmp);
        let apart_k = (self.recent_c[SPAN / 2] - sorted_c[SPAN / 2]).abs();
        self.off[self.next] = apart_k > self.params.gate_k;
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
        readings_c.into_iter().for_each(|temp_c| check.on_sample(Celsius(temp_c)));
        check
    }

    #[test]
    fn a_single_spike_is_one_reading_off() {
        let check = after((0..60).map(|number| if number == 50 { 240.0 } else { 210.0 }));
        assert_eq!(check.off_among(50), 1);
        assert!(!check.is_suspect() && !check.tripped());
    }

    #[test]
    fn ramps_and_steps_that_stay_are_none() {
        assert_eq!(after((0..60).map(|number| 0.24 * f64::from(number))).off_among(50), 0);
        assert_eq!(after((0..60).map(|number| if number < 30 { 210.0 } else { 240.0 })).off_among(50), 0);
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
