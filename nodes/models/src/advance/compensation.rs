//! Linear lag with compensation: `K dy/dt + y = v0 + K_A dv0/dt` (equation 4, corrected; model book 2.2).

use crate::extruder::LinearLag;
use crate::units::Seconds;

/// A lag and what is set against it.
///
/// Exact for piecewise linear `v0`: with `y = z + (K_A/K) v0` the jump of `dv0/dt` drops out and
/// `K dz/dt + z = (1 - K_A/K) v0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compensation {
    /// Lag K `[s]`, above 0.
    pub lag_s: f64,
    /// Compensation `K_A` `[s]`, 0 or more.
    pub advance_s: f64,
}

impl Compensation {
    /// Internal state z of a steady outlet at speed `v0` `[m/s]`.
    #[must_use]
    pub fn steady(&self, speed_m_s: f64) -> f64 {
        (1.0 - self.share()) * speed_m_s
    }

    /// State after `dt` in which `v0` goes linearly from one speed to the other `[m/s]`.
    #[must_use]
    pub fn step(&self, state_m_s: f64, (from_m_s, to_m_s): (f64, f64), dt: Seconds) -> f64 {
        let rest = 1.0 - self.share();
        LinearLag { lag_s: self.lag_s }.step_ramp(state_m_s, (rest * from_m_s, rest * to_m_s), dt)
    }

    /// Outlet y `[m/s]` at a state and a speed `v0`.
    #[must_use]
    pub fn outlet(&self, state_m_s: f64, speed_m_s: f64) -> f64 {
        state_m_s + self.share() * speed_m_s
    }

    fn share(&self) -> f64 {
        self.advance_s / self.lag_s
    }
}
