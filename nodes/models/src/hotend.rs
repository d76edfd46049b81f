//! Hot end as two heat capacities, and the thermistor in the block.
//!
//! ```text
//! C_e dT_e/dt = P - K_en (T_e - T_n) - h_e (T_e - T_amb)
//! C_n dT_n/dt = K_en (T_e - T_n) - h_n (T_n - T_amb) - m_dot c_p (T_n - T_f)
//!     dT_s/dt = (T_e - T_s) / tau_s
//! ```
//! [QC] (2), (3) as corrected in model book 1.2 and 1.10; the part fan adds to `h_e` and `h_n`.

use serde::Deserialize;

use crate::params::{ParamError, in_range};
use crate::units::Seconds;

/// Constants of one hot end. Built only from a valid [`RawHotend`], whose fields it shows.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawHotend")]
pub struct Hotend(RawHotend);

read_only!(Hotend(RawHotend));

/// The `hotend` block of a printer file as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawHotend {
    /// Heat capacity of heater block C_e `[J/K]`, above 0.
    pub block_capacity_j_k: f64,
    /// Heat capacity of nozzle and melt C_n `[J/K]`, above 0.
    pub nozzle_capacity_j_k: f64,
    /// Conductance between block and nozzle K_en `[W/K]`, above 0.
    pub coupling_w_k: f64,
    /// Loss of the block to air h_e `[W/K]`, above 0.
    pub block_loss_w_k: f64,
    /// Loss of the nozzle to air h_n `[W/K]`, above 0.
    pub nozzle_loss_w_k: f64,
    /// What the full part fan adds to h_e `[W/K]`, 0 or more.
    pub block_loss_fan_w_k: f64,
    /// What the full part fan adds to h_n `[W/K]`, 0 or more.
    pub nozzle_loss_fan_w_k: f64,
    /// Highest heater power `[W]`, above 0.
    pub heater_power_w: f64,
    /// Time constant of the thermistor in the block tau_s `[s]`, above 0.
    pub sensor_lag_s: f64,
}

impl TryFrom<RawHotend> for Hotend {
    type Error = ParamError;

    fn try_from(raw: RawHotend) -> Result<Self, ParamError> {
        in_range("block_capacity_j_k", raw.block_capacity_j_k, "J/K", (0.1, 1e4))?;
        in_range("nozzle_capacity_j_k", raw.nozzle_capacity_j_k, "J/K", (0.01, 1e4))?;
        in_range("coupling_w_k", raw.coupling_w_k, "W/K", (1e-4, 100.0))?;
        in_range("block_loss_w_k", raw.block_loss_w_k, "W/K", (1e-5, 100.0))?;
        in_range("nozzle_loss_w_k", raw.nozzle_loss_w_k, "W/K", (1e-5, 100.0))?;
        in_range("block_loss_fan_w_k", raw.block_loss_fan_w_k, "W/K", (0.0, 1.0))?;
        in_range("nozzle_loss_fan_w_k", raw.nozzle_loss_fan_w_k, "W/K", (0.0, 1.0))?;
        in_range("heater_power_w", raw.heater_power_w, "W", (1.0, 2000.0))?;
        in_range("sensor_lag_s", raw.sensor_lag_s, "s", (0.001, 600.0))?;
        Ok(Self(raw))
    }
}

/// Temperatures of the hot end; also their derivatives `[K/s]` where a function says so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thermal {
    /// Heater block T_e `[K]`.
    pub block_k: f64,
    /// Nozzle T_n `[K]`.
    pub nozzle_k: f64,
    /// Thermistor T_s `[K]`.
    pub sensor_k: f64,
}

impl Thermal {
    /// Everything at one temperature.
    #[must_use]
    pub fn uniform(temp_k: f64) -> Self {
        Self { block_k: temp_k, nozzle_k: temp_k, sensor_k: temp_k }
    }
}

/// What acts on the hot end; constant over a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// Heater power P `[W]`, in `[0, heater_power_w]`.
    pub heater_w: f64,
    /// Part fan `[-]`, in `[0, 1]`.
    pub fan: f64,
    /// Surrounding air `[K]`.
    pub ambient_k: f64,
    /// Filament that enters T_f `[K]`.
    pub filament_k: f64,
    /// Heat the melt takes away per kelvin m_dot c_p `[W/K]`: [`crate::material::Material::heat_flow_w_k`].
    pub melt_w_k: f64,
}

/// Steady state for a nozzle temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steady {
    /// Heater block `[K]`.
    pub block_k: f64,
    /// Heater power that holds it `[W]`; may exceed what the heater has.
    pub heater_w: f64,
}

impl Hotend {
    /// Losses of block and nozzle `[W/K]` at a part fan share.
    fn losses_w_k(&self, fan: f64) -> (f64, f64) {
        (
            self.block_loss_w_k + self.block_loss_fan_w_k * fan,
            self.nozzle_loss_w_k + self.nozzle_loss_fan_w_k * fan,
        )
    }

    /// Derivatives of the three temperatures `[K/s]`.
    #[must_use]
    pub fn rhs(&self, at: Thermal, inputs: &Inputs) -> Thermal {
        let (block_loss, nozzle_loss) = self.losses_w_k(inputs.fan);
        let across_w = self.coupling_w_k * (at.block_k - at.nozzle_k);
        let block_w = inputs.heater_w - across_w - block_loss * (at.block_k - inputs.ambient_k);
        let nozzle_w = across_w
            - nozzle_loss * (at.nozzle_k - inputs.ambient_k)
            - inputs.melt_w_k * (at.nozzle_k - inputs.filament_k);
        Thermal {
            block_k: block_w / self.block_capacity_j_k,
            nozzle_k: nozzle_w / self.nozzle_capacity_j_k,
            sensor_k: (at.block_k - at.sensor_k) / self.sensor_lag_s,
        }
    }

    /// Temperatures that constant inputs lead to: the zero of [`Self::rhs`].
    #[must_use]
    pub fn equilibrium(&self, inputs: &Inputs) -> Thermal {
        let (block_loss, nozzle_loss) = self.losses_w_k(inputs.fan);
        let coupling = self.coupling_w_k;
        let block_sum = coupling + block_loss;
        let nozzle_sum = coupling + nozzle_loss + inputs.melt_w_k;
        let block_rhs = inputs.heater_w + block_loss * inputs.ambient_k;
        let nozzle_rhs = nozzle_loss * inputs.ambient_k + inputs.melt_w_k * inputs.filament_k;
        let det = block_sum * nozzle_sum - coupling * coupling;
        let block_k = (block_rhs * nozzle_sum + coupling * nozzle_rhs) / det;
        let nozzle_k = (block_sum * nozzle_rhs + coupling * block_rhs) / det;
        Thermal { block_k, nozzle_k, sensor_k: block_k }
    }

    /// Temperatures after `dt`, exactly: the linear system's two modes and the thermistor that follows them.
    ///
    /// Stable and exact for any `dt` with constant inputs, so the result does not depend on the step size.
    #[must_use]
    pub fn step(&self, from: Thermal, inputs: &Inputs, dt: Seconds) -> Thermal {
        let (block_loss, nozzle_loss) = self.losses_w_k(inputs.fan);
        let settled = self.equilibrium(inputs);
        let block_rate = (self.coupling_w_k + block_loss) / self.block_capacity_j_k;
        let nozzle_rate = (self.coupling_w_k + nozzle_loss + inputs.melt_w_k) / self.nozzle_capacity_j_k;
        let to_nozzle = self.coupling_w_k / self.nozzle_capacity_j_k;
        let to_block = self.coupling_w_k / self.block_capacity_j_k;
        // to_nozzle * to_block > 0: the two rates are real and distinct.
        let half_gap = (0.25 * (block_rate - nozzle_rate).powi(2) + to_nozzle * to_block).sqrt();
        let middle = 0.5 * (block_rate + nozzle_rate);
        let (slow, fast) = (middle - half_gap, middle + half_gap);
        let block_off = from.block_k - settled.block_k;
        let nozzle_off = from.nozzle_k - settled.nozzle_k;
        // Block part of each mode from value and derivative at the start.
        let slope = -block_rate * block_off + to_block * nozzle_off;
        let slow_part = (slope + fast * block_off) / (fast - slow);
        let fast_part = block_off - slow_part;
        let slow_now = slow_part * (-slow * dt.0).exp();
        let fast_now = fast_part * (-fast * dt.0).exp();
        let nozzle_now = ((block_rate - slow) * slow_now + (block_rate - fast) * fast_now) / to_block;
        let sensor_off = from.sensor_k - settled.block_k;
        let sensor_now = sensor_off * (-dt.0 / self.sensor_lag_s).exp()
            + slow_part * followed(slow, self.sensor_lag_s, dt.0)
            + fast_part * followed(fast, self.sensor_lag_s, dt.0);
        Thermal {
            block_k: settled.block_k + slow_now + fast_now,
            nozzle_k: settled.nozzle_k + nozzle_now,
            sensor_k: settled.block_k + sensor_now,
        }
    }

    /// Block temperature and heater power that hold the nozzle at `nozzle_k`; the heater power in `inputs` is not read.
    ///
    /// `T_e = T_n + [h_n (T_n - T_amb) + m_dot c_p (T_n - T_f)] / K_en`, `P = K_en (T_e - T_n) + h_e (T_e - T_amb)`.
    #[must_use]
    pub fn steady(&self, nozzle_k: f64, inputs: &Inputs) -> Steady {
        let (block_loss, nozzle_loss) = self.losses_w_k(inputs.fan);
        let across_w =
            nozzle_loss * (nozzle_k - inputs.ambient_k) + inputs.melt_w_k * (nozzle_k - inputs.filament_k);
        let block_k = nozzle_k + across_w / self.coupling_w_k;
        Steady { block_k, heater_w: across_w + block_loss * (block_k - inputs.ambient_k) }
    }
}

/// First-order lag's answer at `t_s` to `exp(-rate t)`, from rest: `(e^(-rate t) - e^(-t/lag)) / (1 - rate lag)`,
/// written with `expm1` so that it holds through `rate lag = 1` as well.
fn followed(rate_1_s: f64, lag_s: f64, t_s: f64) -> f64 {
    let ratio = t_s / lag_s;
    let gap = ratio - rate_1_s * t_s;
    let shape = if gap.abs() < 1e-9 { 1.0 } else { gap.exp_m1() / gap };
    ratio * (-ratio).exp() * shape
}

#[cfg(test)]
pub(crate) mod tests;
