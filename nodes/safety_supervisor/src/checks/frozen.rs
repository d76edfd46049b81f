//! S2: a reading that stands still, bit by bit, while it cannot.
//!
//! A sound thermistor shows noise. A still reading is a fault once the order has changed enough in the meantime,
//! or the heater is at its stop, or the balance says the temperature must have moved, or, with the heater in use,
//! after a span in which no converter repeats itself.
//!
//! A converter whose steps are coarser than the noise does repeat itself while nothing moves: of it the first two say
//! nothing, and the balance has to move by more than such steps.

use models::units::{Celsius, Seconds};

use crate::params::FrozenParams;

/// Smallest change between readings from which a converter is coarse `[K]`: noise of 0.15 K passes below it in each eighth.
const COARSE_K: f64 = 0.04;
/// By how much the smallest change grows with each one that is larger `[-]`: what a converter's steps were is soon forgotten.
const FORGET: f64 = 1.01;
/// Steps of a coarse converter that the balance must have moved by `[-]`.
const COARSE_STEPS: f64 = 3.0;

/// Watches one temperature.
#[derive(Debug, Clone)]
pub struct FrozenCheck {
    params: FrozenParams,
    reading: Option<(Seconds, Celsius)>,
    /// When it changed last.
    changed: Option<Seconds>,
    /// Smallest change of late `[K]`.
    finest_k: f64,
    newest: Seconds,
    duty: f64,
    duty_min: f64,
    duty_max: f64,
}

impl FrozenCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: FrozenParams) -> Self {
        let now = Seconds(0.0);
        Self {
            params,
            reading: None,
            changed: None,
            finest_k: 0.0,
            newest: now,
            duty: 0.0,
            duty_min: 0.0,
            duty_max: 0.0,
        }
    }

    /// Takes the duty in force.
    pub fn on_duty(&mut self, duty: f64) {
        self.duty = duty;
        self.duty_min = self.duty_min.min(duty);
        self.duty_max = self.duty_max.max(duty);
    }

    /// Takes a temperature received at `now`.
    pub fn on_sample(&mut self, now: Seconds, temp: Celsius) {
        self.newest = now;
        let held = self.reading.map(|(_, held)| held);
        if held.is_some_and(|held| held.0.to_bits() == temp.0.to_bits()) {
            return;
        }
        if let Some(held) = held {
            let step_k = (temp.0 - held.0).abs();
            let known = self.changed.replace(now).is_some();
            self.finest_k = if known { step_k.min(FORGET * self.finest_k) } else { step_k };
        }
        self.reading = Some((now, temp));
        (self.duty_min, self.duty_max) = (self.duty, self.duty);
    }

    /// When the reading changed last: one that has stood since the start, or since it was forgotten, has not.
    #[must_use]
    pub fn changed(&self) -> Option<Seconds> {
        self.changed
    }

    /// Time in which the supervisor itself stood still does not count; a clock that was set back takes the times with it.
    pub fn forgive(&mut self, now: Seconds, gap: Seconds) {
        let moved = |since: Seconds| Seconds((since + gap).0.min(now.0));
        self.reading = self.reading.map(|(since, held)| (moved(since), held));
        self.changed = self.changed.map(moved);
        if gap < Seconds(0.0) {
            self.newest = moved(self.newest);
        }
    }

    /// How long the reading has stood still.
    #[must_use]
    pub fn still(&self) -> Seconds {
        self.reading.map_or(Seconds(0.0), |(since, _)| self.newest - since)
    }

    /// Whether the reading is frozen; `moved_k` is how far the energy balance says it must have moved meanwhile.
    #[must_use]
    pub fn tripped(&self, moved_k: f64) -> bool {
        let still_s = self.still().0;
        let varied = self.duty_max - self.duty_min >= self.params.duty_change;
        let at_stop = self.duty_min >= self.params.duty_stop;
        // A balance that believes in a room of 25 degC moves every block that rests in another one.
        let rests =
            self.duty_max <= 0.0 && self.reading.is_none_or(|(_, held)| held.0 <= self.params.room_max_c);
        let coarse = self.finest_k >= COARSE_K;
        let least_k = self.params.moved_k.max(if coarse { COARSE_STEPS * self.finest_k } else { 0.0 });
        let moved = moved_k.abs() >= least_k && !rests;
        let in_use = self.duty_min >= self.params.duty_in_use;
        (still_s >= self.params.short_s && (at_stop || moved))
            || (still_s >= self.params.middle_s && varied && !coarse)
            || (still_s >= self.params.long_s && in_use && !coarse)
    }

    /// Forgets the reading.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }
}
