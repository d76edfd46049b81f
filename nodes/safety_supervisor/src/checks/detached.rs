//! P3: the reading falls faster than any heater cools: the thermistor fell out.

use models::units::{Celsius, Seconds};

use super::sinking::Sinking;
use crate::params::DetachedParams;

/// Most samples before the newest over which the fall is measured.
const SPAN: u32 = 4;
/// Time over which it is measured at least, where so many samples span it `[s]`.
const SPAN_MIN_S: f64 = 0.38;

/// Watches one temperature.
#[derive(Debug, Clone)]
pub struct DetachedCheck {
    params: DetachedParams,
    recent: [Option<(Seconds, f64)>; SPAN as usize],
    falling: u32,
    /// Spans in a row with a fall that trip at this pace.
    needed: u32,
    fall_k_s: f64,
    sinking: Sinking,
}

impl DetachedCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: DetachedParams) -> Self {
        let sinking = Sinking::new(params.fall_k_s);
        Self {
            params,
            recent: [None; SPAN as usize],
            falling: 0,
            needed: params.samples,
            fall_k_s: 0.0,
            sinking,
        }
    }

    /// Takes a temperature received at `now`.
    pub fn on_sample(&mut self, now: Seconds, temp: Celsius) {
        self.sinking.on_sample(now, temp);
        let from = self.span_from(now);
        self.recent.rotate_left(1);
        self.recent[SPAN as usize - 1] = Some((now, temp.0));
        let Some((back, (then, before_c))) = from else { return };
        // A spike lies within as many spans as a span has samples: slower readings make fewer of them.
        self.needed = self.params.samples.saturating_sub(SPAN - back).max(back + 1);
        let span_s = now.0 - then.0;
        let fall_k_s = (before_c - temp.0) / span_s;
        self.fall_k_s = fall_k_s;
        let fast = span_s > 0.0 && span_s < self.params.span_max_s && fall_k_s > self.params.fall_k_s;
        self.falling = if fast { self.falling.saturating_add(1) } else { 0 };
    }

    /// How many samples back a span up to `now` begins, and that sample.
    fn span_from(&self, now: Seconds) -> Option<(u32, (Seconds, f64))> {
        let mut spans =
            (1_u32..).zip(self.recent.iter().rev()).map_while(|(back, sample)| Some((back, (*sample)?)));
        let long = |(_, (then, _)): &(u32, (Seconds, f64))| (now - *then).0 >= SPAN_MIN_S;
        spans.find(long).or(self.recent[0].map(|oldest| (SPAN, oldest)))
    }

    /// How fast it falls, and what no heater does `[K/s]`: over seconds where that tells, else from reading to reading.
    #[must_use]
    pub fn fall_k_s(&self) -> (f64, f64) {
        let sunk = self.sinking.sunk_k_s().filter(|_| self.falling < self.needed);
        sunk.unwrap_or((self.fall_k_s, self.params.fall_k_s))
    }

    /// Whether it fell out. One spike makes at most as many fast spans as the parameter demands less one.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.falling >= self.needed || self.sinking.sunk_k_s().is_some()
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
