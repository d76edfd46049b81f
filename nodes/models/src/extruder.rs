//! Extruder: drive gear with slip, compressed filament, melt outlet.
//!
//! The compressed length x obeys `dx/dt = v_fil - u` with `u = q / A_f`; the static law is
//! `x = c F(q) / kappa + K_lin u`, kappa in `(0, 1]` being the clog factor (model book 1.2).

use std::f64::consts::PI;

use serde::Deserialize;

use crate::params::{ParamError, in_range};

mod lag;
mod law;
mod melting;
mod outflow;
mod slip;

pub use lag::LinearLag;
pub use law::{Outlet, Pressure, StaticLaw};
pub use melting::Melting;
pub use slip::{RawSlip, SlipParams};

/// Constants of one extruder. Built only from a valid [`RawExtruder`], whose fields it shows.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawExtruder")]
pub struct Extruder(RawExtruder);

read_only!(Extruder(RawExtruder));

/// The `extruder` block of a printer file as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawExtruder {
    /// Filament compressed per force c `[m/N]`, above 0.
    pub compliance_m_n: f64,
    /// Linear part of the pressure lag K_lin `[s]`, above 0.
    pub linear_lag_s: f64,
    /// Force at which the drive gear starts to lose grip F_max `[N]`, above 0.
    pub force_max_n: f64,
    /// Flow at which the melt leaves 63 % heated q_c `[m3/s]`, above 0.
    pub melting_flow_m3_s: f64,
    /// Nozzle radius R `[m]`, above 0.
    pub nozzle_radius_m: f64,
    /// Land length plus entrance equivalent L_eff `[m]`, above 0.
    pub nozzle_length_m: f64,
    /// Nominal filament diameter `[m]`, above 0.
    pub filament_diameter_m: f64,
    /// Whether pressure carries the Rabinowitsch factor; the paper's form does not.
    pub rabinowitsch: bool,
}

impl TryFrom<RawExtruder> for Extruder {
    type Error = ParamError;

    fn try_from(raw: RawExtruder) -> Result<Self, ParamError> {
        in_range("compliance_m_n", raw.compliance_m_n, "m/N", (1e-8, 0.1))?;
        in_range("linear_lag_s", raw.linear_lag_s, "s", (1e-4, 10.0))?;
        in_range("force_max_n", raw.force_max_n, "N", (0.1, 1e4))?;
        in_range("melting_flow_m3_s", raw.melting_flow_m3_s, "m3/s", (1e-10, 1e-5))?;
        in_range("nozzle_radius_m", raw.nozzle_radius_m, "m", (2e-5, 2e-3))?;
        in_range("nozzle_length_m", raw.nozzle_length_m, "m", (1e-4, 0.1))?;
        in_range("filament_diameter_m", raw.filament_diameter_m, "m", (1e-3, 4e-3))?;
        Ok(Self(raw))
    }
}

impl Extruder {
    /// Cross section of the nominal filament A_f `[m2]`.
    #[must_use]
    pub fn filament_area_m2(&self) -> f64 {
        0.25 * PI * self.filament_diameter_m.powi(2)
    }
}

/// How the diameter of a filament wanders along its length. Built only from valid [`RawFilament`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawFilament")]
pub struct Filament(RawFilament);

read_only!(Filament(RawFilament));

/// The `filament` block of a plant file as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawFilament {
    /// Mean diameter `[m]`, in `[1e-3, 4e-3]`.
    pub diameter_m: f64,
    /// Standard deviation of the diameter `[m]`, 0 or more.
    pub diameter_sigma_m: f64,
    /// Length over which deviations are correlated `[m]`, above 0.
    pub correlation_length_m: f64,
}

impl TryFrom<RawFilament> for Filament {
    type Error = ParamError;

    fn try_from(raw: RawFilament) -> Result<Self, ParamError> {
        in_range("diameter_m", raw.diameter_m, "m", (1e-3, 4e-3))?;
        in_range("diameter_sigma_m", raw.diameter_sigma_m, "m", (0.0, 2e-4))?;
        in_range("correlation_length_m", raw.correlation_length_m, "m", (1e-4, 1000.0))?;
        Ok(Self(raw))
    }
}

impl Filament {
    /// Deviation from the mean diameter `[m]` after `length_m` more filament: exact step of an Ornstein-Uhlenbeck
    /// process, `normal` being a standard normal number of the caller's generator.
    #[must_use]
    pub fn deviation_after_m(&self, deviation_m: f64, length_m: f64, normal: f64) -> f64 {
        let decay = (-length_m.abs() / self.correlation_length_m).exp();
        deviation_m * decay + self.diameter_sigma_m * (1.0 - decay * decay).sqrt() * normal
    }
}

#[cfg(test)]
pub(crate) mod tests;
