//! P3: the reading falls faster than any heater cools: the thermistor fell out.

use models::units::{Celsius, Seconds};

use crate::params::DetachedParams;

/// Samples over which the fall is measured.
const SPAN: usize = 4;

/// Watches one temperature.
#[derive(Debug, Clone)]
pub struct DetachedCheck {
    params: DetachedParams,
    recent: [Option<(Seconds, f64)>; SPAN],
    falling: u32,
    fall_k_s: f64,
}

impl DetachedCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: DetachedParams) -> Self {
        Self { params, recent: [None; SPAN], falling: 0, fall_k_s: 0.0 }
    }

    /// Takes a temperature received at `now`.
    pub fn on_sample(&mut self, now: Seconds, temp: Celsius) {
        let oldest = self.recent[0];
        self.recent.rotate_left(1);
        self.recent[SPAN - 1] = Some((now, temp.0));
        let Some((then, before_c)) = oldest else { return };
        let span_s = now.0 - then.0;
        let fall_k_s = (before_c - temp.0) / span_s;
        self.fall_k_s = fall_k_s;
        let fast = span_s > 0.0 && span_s < self.params.span_max_s && fall_k_s > self.params.fall_k_s;
        self.falling = if fast { self.falling.saturating_add(1) } else { 0 };
    }

    /// How fast it falls `[K/s]`.
    #[must_use]
    pub fn fall_k_s(&self) -> f64 {
        self.fall_k_s
    }

    /// Whether it fell out. One spike makes at most as many fast spans as the parameter demands less one.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.falling >= self.params.samples
    }

    /// Whether the reading falls so fast just now that it is not the block's.
    #[must_use]
    pub fn is_falling(&self) -> bool {
        self.falling > 0
    }

    /// Whether the reading has all but stopped: a fifth of what no block does is above its noise.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.fall_k_s.abs() < 0.2 * self.params.fall_k_s
    }

    /// Forgets the samples.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }
}
