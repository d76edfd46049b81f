//! Melt through the nozzle: power law with Arrhenius consistency.
//!
//! `gamma = 4 q / (pi R^3)`, `eta = K(T) gamma^(n-1)`, `dp = 8 eta L q / (pi R^4)`,
//! `K(T) = K_ref exp[E_a/R_g (1/T - 1/T_ref)]`; [QC] (4)-(6) as corrected in model book 1.2.

use std::f64::consts::PI;

use crate::extruder::Extruder;
use crate::material::Material;
use crate::units::Kelvin;

/// Molar gas constant `[J/(mol K)]`, CODATA 2018.
pub const GAS_CONSTANT_J_MOL_K: f64 = 8.314_462_618;

/// One material in one nozzle: everything of the flow that does not depend on temperature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Melt {
    flow_index: f64,
    consistency_pa_sn: f64,
    reference_temp_k: f64,
    activation_temp_k: f64,
    radius_m: f64,
    length_m: f64,
    filament_area_m2: f64,
    /// `gamma^n` of a filament that leaves at 1 m/s.
    unit_shear: f64,
    shear_factor: f64,
    melting_flow_m3_s: f64,
    force_max_n: f64,
}

impl Melt {
    /// Combines a material with the extruder's nozzle.
    #[must_use]
    pub fn new(material: &Material, extruder: &Extruder) -> Self {
        let flow_index = material.flow_index;
        // Rabinowitsch: the wall rate of a power law melt is (3n+1)/(4n) times the Newtonian one.
        let shear_factor = if extruder.rabinowitsch {
            ((3.0 * flow_index + 1.0) / (4.0 * flow_index)).powf(flow_index)
        } else {
            1.0
        };
        let filament_area_m2 = extruder.filament_area_m2();
        let radius_m = extruder.nozzle_radius_m;
        Self {
            flow_index,
            consistency_pa_sn: material.consistency_pa_sn,
            reference_temp_k: material.reference_temp_k,
            activation_temp_k: material.activation_energy_j_mol / GAS_CONSTANT_J_MOL_K,
            radius_m,
            length_m: extruder.nozzle_length_m,
            filament_area_m2,
            unit_shear: shear_rate_1_s(filament_area_m2, radius_m).powf(flow_index),
            shear_factor,
            melting_flow_m3_s: extruder.melting_flow_m3_s,
            force_max_n: extruder.force_max_n,
        }
    }

    /// Power law index n `[-]`.
    #[must_use]
    pub fn flow_index(&self) -> f64 {
        self.flow_index
    }

    /// Cross section of the nominal filament `[m2]`.
    #[must_use]
    pub fn filament_area_m2(&self) -> f64 {
        self.filament_area_m2
    }

    /// Consistency K(T) `[Pa s^n]`; falls strictly with temperature.
    #[must_use]
    pub fn consistency_pa_sn(&self, temp: Kelvin) -> f64 {
        self.consistency_pa_sn * (self.activation_temp_k * (1.0 / temp.0 - 1.0 / self.reference_temp_k)).exp()
    }

    /// Newtonian apparent shear rate at the wall `[1/s]` of a flow `[m3/s]`, 0 or more.
    #[must_use]
    pub fn shear_rate_1_s(&self, flow_m3_s: f64) -> f64 {
        shear_rate_1_s(flow_m3_s, self.radius_m)
    }

    /// Apparent viscosity `[Pa s]` of a flow `[m3/s]` above 0.
    #[must_use]
    pub fn viscosity_pa_s(&self, flow_m3_s: f64, temp: Kelvin) -> f64 {
        self.consistency_pa_sn(temp) * self.shear_rate_1_s(flow_m3_s).powf(self.flow_index - 1.0)
    }

    /// Pressure `[Pa]` that drives a flow `[m3/s]` of 0 or more: `2 L K gamma^n / R`, times the Rabinowitsch factor
    /// where the extruder asks for it.
    #[must_use]
    pub fn pressure_pa(&self, flow_m3_s: f64, temp: Kelvin) -> f64 {
        self.pressure_scale_pa(temp) * self.shear_rate_1_s(flow_m3_s).powf(self.flow_index)
    }

    /// Flow `[m3/s]` that a pressure `[Pa]` drives; 0 for a pressure of 0 or less. Inverse of [`Self::pressure_pa`].
    #[must_use]
    pub fn flow_m3_s(&self, pressure_pa: f64, temp: Kelvin) -> f64 {
        if pressure_pa <= 0.0 {
            return 0.0;
        }
        let shear_rate_1_s = (pressure_pa / self.pressure_scale_pa(temp)).powf(1.0 / self.flow_index);
        0.25 * PI * self.radius_m.powi(3) * shear_rate_1_s
    }

    /// Force on the filament `[N]` per power n of its speed through the outlet `[N (s/m)^n]`.
    #[must_use]
    pub fn force_scale(&self, temp: Kelvin) -> f64 {
        self.pressure_scale_pa(temp) * self.unit_shear * self.filament_area_m2
    }

    /// Force on the filament `[N]`: `F = dp A_f`.
    #[must_use]
    pub fn force_n(&self, flow_m3_s: f64, temp: Kelvin) -> f64 {
        self.pressure_pa(flow_m3_s, temp) * self.filament_area_m2
    }

    /// Temperature of the melt at the nozzle's end: `T_m = T_f + (T_n - T_f)(1 - exp(-q_c/q))`.
    ///
    /// A faster flow has less time to take heat up. Our assumption (model book 1.2); it makes the flow ceiling real.
    #[must_use]
    pub fn melt_temperature(&self, nozzle: Kelvin, filament: Kelvin, flow_m3_s: f64) -> Kelvin {
        melt_temperature(nozzle, filament, flow_m3_s, self.melting_flow_m3_s)
    }

    /// By how much more than the flow index the force of a melt grows that a flow `[m3/s]` above 0 lets leave at `melt` from a
    /// nozzle at `nozzle`, `d ln K(T_m(q)) / d ln q` `[-]`; below 0 where the filament is the warmer of the two.
    #[must_use]
    pub fn cooling_index(&self, nozzle: Kelvin, melt: Kelvin, flow_m3_s: f64) -> f64 {
        let turns = self.melting_flow_m3_s / flow_m3_s;
        self.activation_temp_k / melt.0.powi(2) * (nozzle.0 - melt.0) * turns
    }

    /// Largest flow `[m3/s]` whose force, at its own melt temperature, stays within `margin` times the drive's limit.
    ///
    /// `margin` in `(0, 1]`. Force grows with flow by both shear and cooling, so the root is unique: bisection to
    /// the last bit that matters.
    #[must_use]
    pub fn flow_max_m3_s(&self, nozzle: Kelvin, filament: Kelvin, margin: f64) -> f64 {
        let limit_n = margin * self.force_max_n;
        let force_n = |flow| self.force_n(flow, self.melt_temperature(nozzle, filament, flow));
        // At the nozzle's own temperature the force is the smallest possible: an upper bound of the flow.
        let mut high = self.flow_m3_s(limit_n / self.filament_area_m2, nozzle);
        let mut low = 0.0;
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if force_n(middle) > limit_n { high = middle } else { low = middle }
        }
        low
    }

    fn pressure_scale_pa(&self, temp: Kelvin) -> f64 {
        2.0 * self.length_m * self.consistency_pa_sn(temp) / self.radius_m * self.shear_factor
    }
}

/// Halvings that bring any bracket below f64 resolution.
const BISECTIONS: usize = 60;

fn shear_rate_1_s(flow_m3_s: f64, radius_m: f64) -> f64 {
    4.0 * flow_m3_s / (PI * radius_m.powi(3))
}

/// [`Melt::melt_temperature`] for a melting flow q_c `[m3/s]` given apart.
#[must_use]
pub fn melt_temperature(nozzle: Kelvin, filament: Kelvin, flow_m3_s: f64, melting_flow_m3_s: f64) -> Kelvin {
    if flow_m3_s <= 0.0 {
        return nozzle;
    }
    let taken_up = -(-melting_flow_m3_s / flow_m3_s).exp_m1();
    Kelvin(filament.0 + (nozzle.0 - filament.0) * taken_up)
}

#[cfg(test)]
mod tests;
