//! Heater loop: PID on a measured temperature, with derivative on the measurement and anti-windup.
//!
//! Model book 1.3. It runs at the sensor's rate (model book 1.8), 10 Hz here.

use serde::Deserialize;

use crate::params::{ParamError, in_range};
use crate::units::{Kelvin, Seconds};

/// Gains of one heater loop. Built only from valid [`RawPid`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawPid")]
pub struct PidParams(RawPid);

read_only!(PidParams(RawPid));

/// The `heater` or `bed_heater` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawPid {
    /// Proportional gain `[W/K]`, above 0.
    pub proportional_w_k: f64,
    /// Integral gain `[W/(K s)]`, 0 or more.
    pub integral_w_k_s: f64,
    /// Derivative gain `[W s/K]`, 0 or more.
    pub derivative_w_s_k: f64,
    /// Time between two runs of the loop `[s]`, above 0.
    pub period_s: f64,
}

impl TryFrom<RawPid> for PidParams {
    type Error = ParamError;

    fn try_from(raw: RawPid) -> Result<Self, ParamError> {
        in_range("proportional_w_k", raw.proportional_w_k, "W/K", (0.001, 1e4))?;
        in_range("integral_w_k_s", raw.integral_w_k_s, "W/(K s)", (0.0, 1e3))?;
        in_range("derivative_w_s_k", raw.derivative_w_s_k, "W s/K", (0.0, 1e4))?;
        in_range("period_s", raw.period_s, "s", (0.001, 10.0))?;
        Ok(Self(raw))
    }
}

impl PidParams {
    /// Time between two runs of the loop.
    #[must_use]
    pub fn period(&self) -> Seconds {
        Seconds(self.period_s)
    }
}

/// One heater loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pid {
    params: PidParams,
    power_max_w: f64,
    integral_w: f64,
    last_k: Option<f64>,
}

impl Pid {
    /// A loop at rest, for a heater of `power_max_w` `[W]`.
    #[must_use]
    pub fn new(params: PidParams, power_max_w: f64) -> Self {
        Self { params, power_max_w, integral_w: 0.0, last_k: None }
    }

    /// A loop that holds `power_w` at `temp`: no transient when the print starts hot.
    #[must_use]
    pub fn settled(params: PidParams, power_max_w: f64, power_w: f64, temp: Kelvin) -> Self {
        Self { params, power_max_w, integral_w: power_w.clamp(0.0, power_max_w), last_k: Some(temp.0) }
    }

    /// Heater power `[W]` for one period; call it once a period. `None` where an argument is not finite: the heater
    /// must then be off, and the loop keeps its state.
    pub fn update(&mut self, setpoint: Kelvin, measured: Kelvin) -> Option<f64> {
        if !(setpoint.0.is_finite() && measured.0.is_finite()) {
            return None;
        }
        let period_s = self.params.period_s;
        let error_k = setpoint.0 - measured.0;
        let slope_k_s = self.last_k.map_or(0.0, |last_k| (measured.0 - last_k) / period_s);
        self.last_k = Some(measured.0);
        let integral_w = self.integral_w + self.params.integral_w_k_s * error_k * period_s;
        let others_w = self.params.proportional_w_k * error_k - self.params.derivative_w_s_k * slope_k_s;
        let wanted_w = others_w + integral_w;
        // Anti-windup: an integral that pushes further into the stop is not kept.
        let winds_up = (wanted_w > self.power_max_w && error_k > 0.0) || (wanted_w < 0.0 && error_k < 0.0);
        if !winds_up {
            self.integral_w = integral_w.clamp(0.0, self.power_max_w);
        }
        Some((others_w + self.integral_w).clamp(0.0, self.power_max_w))
    }

    /// Forgets the past: the heater was off.
    pub fn reset(&mut self) {
        self.integral_w = 0.0;
        self.last_k = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hotend::{Inputs, Thermal};

    fn gains() -> PidParams {
        PidParams::try_from(RawPid {
            proportional_w_k: 3.41,
            integral_w_k_s: 0.242,
            derivative_w_s_k: 12.0,
            period_s: 0.1,
        })
        .unwrap()
    }

    #[test]
    fn the_loop_heats_from_cold_without_a_large_overshoot_and_settles_on_the_set_point() {
        let hotend = crate::hotend::tests::ender3();
        let mut heater = Pid::new(gains(), hotend.heater_power_w);
        let mut temps = Thermal::uniform(298.15);
        let mut highest_k = 0.0_f64;
        for _ in 0..6000 {
            let heater_w = heater.update(Kelvin(483.15), Kelvin(temps.sensor_k)).unwrap();
            assert!((0.0..=hotend.heater_power_w).contains(&heater_w));
            let inputs = Inputs { heater_w, fan: 0.0, ambient_k: 298.15, filament_k: 298.15, melt_w_k: 0.0 };
            temps = hotend.step(temps, &inputs, Seconds(0.1));
            highest_k = highest_k.max(temps.sensor_k);
        }
        // An integral that winds up during the 80 s of full power would reach 0.242 * 100 K * 80 s = 1900 W.
        assert!(highest_k < 483.15 + 10.0, "overshoot to {highest_k} K");
        assert!((temps.sensor_k - 483.15).abs() < 0.1, "settled at {} K", temps.sensor_k);
    }

    /// A block that was too hot for a minute needs what it needed before: an integral that winds down would begin with nothing.
    #[test]
    fn at_the_lower_stop_the_integral_does_not_wind_down() {
        let set = Kelvin(483.15);
        let mut heater = Pid::settled(gains(), 40.0, 20.0, set);
        for _ in 0..600 {
            assert_eq!(heater.update(set, Kelvin(503.15)), Some(0.0));
        }
        heater.update(set, set).unwrap();
        let power_w = heater.update(set, set).unwrap();
        assert!((power_w - 20.0).abs() < 1e-9, "{power_w} W");
    }

    #[test]
    fn a_reading_that_is_not_a_number_yields_no_power() {
        let mut heater = Pid::new(gains(), 40.0);
        assert_eq!(heater.update(Kelvin(483.15), Kelvin(f64::NAN)), None);
        assert_eq!(heater.update(Kelvin(f64::INFINITY), Kelvin(300.0)), None);
        assert_eq!(heater, Pid::new(gains(), 40.0));
    }
}
