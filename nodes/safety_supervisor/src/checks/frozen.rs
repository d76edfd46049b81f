//! S2: a reading that stands still, bit by bit, while it cannot.
//!
//! A sound thermistor shows noise. A still reading is a fault once the order has changed enough in the meantime,
//! or the heater is at its stop, or the balance says the temperature must have moved, or, with the heater in use,
//! after a span in which no converter repeats itself.

use models::units::{Celsius, Seconds};

use crate::params::FrozenParams;

/// Watches one temperature.
#[derive(Debug, Clone)]
pub struct FrozenCheck {
    params: FrozenParams,
    reading: Option<(Seconds, Celsius)>,
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
        Self { params, reading: None, newest: now, duty: 0.0, duty_min: 0.0, duty_max: 0.0 }
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
        if self.reading.is_none_or(|(_, held)| held.0.to_bits() != temp.0.to_bits()) {
            self.reading = Some((now, temp));
            self.duty_min = self.duty;
            self.duty_max = self.duty;
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
        let moved = moved_k.abs() >= self.params.moved_k && !rests;
        let in_use = self.duty_min >= self.params.duty_in_use;
        (still_s >= self.params.short_s && (at_stop || moved))
            || (still_s >= self.params.middle_s && varied)
            || (still_s >= self.params.long_s && in_use)
    }

    /// Forgets the reading.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }
}
