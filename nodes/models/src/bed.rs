//! Heated bed as one heat capacity: `C dT/dt = P - UA (T - T_amb)` (model book 1.3).

use serde::Deserialize;

use crate::params::{ParamError, in_range};
use crate::units::{Kelvin, Seconds};

/// Constants of one bed. Built only from a valid [`RawBed`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawBed")]
pub struct Bed(RawBed);

read_only!(Bed(RawBed));

/// The `bed` block of a printer file as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawBed {
    /// Heat capacity `[J/K]`, above 0.
    pub capacity_j_k: f64,
    /// Loss to air UA `[W/K]`, above 0.
    pub loss_w_k: f64,
    /// Highest heater power `[W]`, above 0.
    pub heater_power_w: f64,
}

impl TryFrom<RawBed> for Bed {
    type Error = ParamError;

    fn try_from(raw: RawBed) -> Result<Self, ParamError> {
        in_range("capacity_j_k", raw.capacity_j_k, "J/K", (1.0, 1e6))?;
        in_range("loss_w_k", raw.loss_w_k, "W/K", (0.001, 1000.0))?;
        in_range("heater_power_w", raw.heater_power_w, "W", (1.0, 1e5))?;
        Ok(Self(raw))
    }
}

impl Bed {
    /// Temperature after `dt` at constant power `[W]`; exact, so independent of the step size.
    #[must_use]
    pub fn step(&self, temp: Kelvin, heater_w: f64, ambient: Kelvin, dt: Seconds) -> Kelvin {
        let settled_k = ambient.0 + heater_w / self.loss_w_k;
        let decay = (-self.loss_w_k * dt.0 / self.capacity_j_k).exp();
        Kelvin(settled_k + (temp.0 - settled_k) * decay)
    }

    /// Power `[W]` that holds a temperature.
    #[must_use]
    pub fn steady_power_w(&self, temp: Kelvin, ambient: Kelvin) -> f64 {
        self.loss_w_k * (temp.0 - ambient.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Model book 1.3: 25 to 60 degC in 110 s, 25 to 110 degC in 327 s, 44 W at 60 degC.
    #[test]
    fn the_reference_bed_heats_in_the_reference_times() {
        let bed =
            Bed::try_from(RawBed { capacity_j_k: 620.0, loss_w_k: 1.25, heater_power_w: 220.0 }).unwrap();
        let ambient = Kelvin(298.15);
        for (seconds, target_k) in [(110.0, 333.15), (327.0, 383.15)] {
            let temp = bed.step(ambient, 220.0, ambient, Seconds(seconds));
            // Times are rounded to 1 s: at most 220 W / 620 J/K = 0.35 K.
            assert!((temp.0 - target_k).abs() < 0.36, "{} K after {seconds} s", temp.0);
        }
        assert!((bed.steady_power_w(Kelvin(333.15), ambient) - 43.75).abs() < 1e-9);
    }

    #[test]
    fn many_short_steps_give_what_one_long_step_gives() {
        let bed =
            Bed::try_from(RawBed { capacity_j_k: 620.0, loss_w_k: 1.25, heater_power_w: 220.0 }).unwrap();
        let ambient = Kelvin(298.15);
        let once = bed.step(ambient, 100.0, ambient, Seconds(100.0));
        let stepped = (0..1000).fold(ambient, |temp, _| bed.step(temp, 100.0, ambient, Seconds(0.1)));
        assert!((once.0 - stepped.0).abs() < 1e-9);
    }
}
