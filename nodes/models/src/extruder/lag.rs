//! Linearised pressure lag `K du/dt + u = v`, propagated exactly (model book 2.2).

use crate::units::Seconds;

/// Lag K between filament feed and outlet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearLag {
    /// Time constant K `[s]`, above 0.
    pub lag_s: f64,
}

impl LinearLag {
    /// Outlet speed after `dt` under a constant feed: `u+ = u e^(-dt/K) + (1 - e^(-dt/K)) v`.
    #[must_use]
    pub fn step(&self, outlet_m_s: f64, feed_m_s: f64, dt: Seconds) -> f64 {
        feed_m_s + (outlet_m_s - feed_m_s) * (-dt.0 / self.lag_s).exp()
    }

    /// Mean outlet speed over that step: what was laid down is this times `dt`.
    #[must_use]
    pub fn mean(&self, outlet_m_s: f64, feed_m_s: f64, dt: Seconds) -> f64 {
        feed_m_s + (outlet_m_s - feed_m_s) * fading_mean(dt.0 / self.lag_s)
    }

    /// Outlet speed after `dt` while the feed goes linearly from `from_m_s` to `to_m_s`.
    #[must_use]
    pub fn step_ramp(&self, outlet_m_s: f64, (from_m_s, to_m_s): (f64, f64), dt: Seconds) -> f64 {
        let ratio = dt.0 / self.lag_s;
        let decay = (-ratio).exp();
        outlet_m_s * decay + from_m_s * (1.0 - decay) + (to_m_s - from_m_s) * (1.0 - fading_mean(ratio))
    }
}

/// Mean of `e^(-s)` over `[0, ratio]`: `(1 - e^(-ratio)) / ratio`.
pub(super) fn fading_mean(ratio: f64) -> f64 {
    if ratio < 1e-12 { 1.0 } else { -(-ratio).exp_m1() / ratio }
}
