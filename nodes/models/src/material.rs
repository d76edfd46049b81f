//! Filament materials: what the `material` block of `config/materials/*.yaml` holds, and how a real spool differs from it.
//!
//! Source of the numbers: [QC], model book 1.3; of the deviations: model book 1.5.

use serde::Deserialize;

use crate::params::{ParamError, in_range, ordered};
use crate::units::Kelvin;

/// One filament material. Built only from a valid [`RawMaterial`], whose fields it shows.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawMaterial")]
pub struct Material(RawMaterial);

read_only!(Material(RawMaterial));

/// The `material` block as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawMaterial {
    /// Name as the G-code files write it (`PLA`).
    pub name: String,
    /// Density `[kg/m3]`, above 0.
    pub density_kg_m3: f64,
    /// Specific heat of the melt `[J/(kg K)]`, above 0.
    pub heat_capacity_j_kg_k: f64,
    /// Power law index n `[-]`, in `[0.1, 1]`: 1 is a Newtonian melt.
    pub flow_index: f64,
    /// Consistency K at the reference temperature `[Pa s^n]`, above 0.
    pub consistency_pa_sn: f64,
    /// Temperature at which the consistency was taken `[K]`.
    pub reference_temp_k: f64,
    /// Activation energy of the flow `[J/mol]`, above 0.
    pub activation_energy_j_mol: f64,
    /// Nozzle set-point `[K]`, inside the window below.
    pub nozzle_temp_k: f64,
    /// Bed set-point `[K]`.
    pub bed_temp_k: f64,
    /// Lowest nozzle temperature to print at `[K]`.
    pub min_temp_k: f64,
    /// Highest nozzle temperature to print at `[K]`.
    pub max_temp_k: f64,
    /// Glass transition `[K]`: below it layers stop bonding.
    pub glass_temp_k: f64,
    /// Time constant of the bond between layers `[s]`, (8) of [QC].
    pub adhesion_time_s: f64,
    /// Share of the part fan to print with `[-]`, in `[0, 1]`.
    pub fan: f64,
    /// Linearised lag between filament and outlet `[s]`, model book 2.2.
    pub lag_s: f64,
}

/// Temperatures a polymer or its surroundings can take here `[K]`.
const TEMP_RANGE_K: (f64, f64) = (200.0, 800.0);

impl TryFrom<RawMaterial> for Material {
    type Error = ParamError;

    fn try_from(raw: RawMaterial) -> Result<Self, ParamError> {
        in_range("density_kg_m3", raw.density_kg_m3, "kg/m3", (100.0, 2e4))?;
        in_range("heat_capacity_j_kg_k", raw.heat_capacity_j_kg_k, "J/(kg K)", (10.0, 1e5))?;
        in_range("flow_index", raw.flow_index, "-", (0.1, 1.0))?;
        in_range("consistency_pa_sn", raw.consistency_pa_sn, "Pa s^n", (0.1, 1e7))?;
        in_range("activation_energy_j_mol", raw.activation_energy_j_mol, "J/mol", (1.0, 1e6))?;
        for (name, temp_k) in [
            ("reference_temp_k", raw.reference_temp_k),
            ("min_temp_k", raw.min_temp_k),
            ("max_temp_k", raw.max_temp_k),
            ("bed_temp_k", raw.bed_temp_k),
            ("glass_temp_k", raw.glass_temp_k),
        ] {
            in_range(name, temp_k, "K", TEMP_RANGE_K)?;
        }
        ordered(("glass_temp_k", raw.glass_temp_k), ("min_temp_k", raw.min_temp_k))?;
        ordered(("min_temp_k", raw.min_temp_k), ("max_temp_k", raw.max_temp_k))?;
        in_range("nozzle_temp_k", raw.nozzle_temp_k, "K", (raw.min_temp_k, raw.max_temp_k))?;
        in_range("adhesion_time_s", raw.adhesion_time_s, "s", (0.001, 1000.0))?;
        in_range("fan", raw.fan, "-", (0.0, 1.0))?;
        in_range("lag_s", raw.lag_s, "s", (0.001, 60.0))?;
        Ok(Self(raw))
    }
}

impl Material {
    /// Heat that a flow carries per kelvin `[W/K]`: `m_dot c_p = rho q c_p`.
    #[must_use]
    pub fn heat_flow_w_k(&self, flow_m3_s: f64) -> f64 {
        self.density_kg_m3 * flow_m3_s * self.heat_capacity_j_kg_k
    }

    /// Nozzle set-point.
    #[must_use]
    pub fn nozzle_temp(&self) -> Kelvin {
        Kelvin(self.nozzle_temp_k)
    }
}

/// How a plant's material differs from the one the estimator believes in. Built only from a valid [`RawDeviation`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawDeviation")]
pub struct Deviation(RawDeviation);

read_only!(Deviation(RawDeviation));

/// The `material_deviation` block as it is written (model book 1.5).
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawDeviation {
    /// Added to the power law index `[-]`, in `[-0.05, 0.05]`.
    pub flow_index_offset: f64,
    /// Multiplies the consistency `[-]`, in `[0.5, 2]`.
    pub consistency_factor: f64,
    /// Multiplies the activation energy `[-]`, in `[0.5, 2]`.
    pub activation_energy_factor: f64,
    /// Multiplies the specific heat `[-]`, in `[0.5, 2]`.
    pub heat_capacity_factor: f64,
}

impl TryFrom<RawDeviation> for Deviation {
    type Error = ParamError;

    fn try_from(raw: RawDeviation) -> Result<Self, ParamError> {
        in_range("flow_index_offset", raw.flow_index_offset, "-", (-0.05, 0.05))?;
        in_range("consistency_factor", raw.consistency_factor, "-", (0.5, 2.0))?;
        in_range("activation_energy_factor", raw.activation_energy_factor, "-", (0.5, 2.0))?;
        in_range("heat_capacity_factor", raw.heat_capacity_factor, "-", (0.5, 2.0))?;
        Ok(Self(raw))
    }
}

impl Deviation {
    /// The material with these deviations.
    ///
    /// # Errors
    /// [`ParamError`] where the deviation leaves the range of a material: an index beyond 1, say.
    pub fn apply(&self, nominal: &Material) -> Result<Material, ParamError> {
        let raw = nominal.0.clone();
        Material::try_from(RawMaterial {
            flow_index: raw.flow_index + self.flow_index_offset,
            consistency_pa_sn: raw.consistency_pa_sn * self.consistency_factor,
            activation_energy_j_mol: raw.activation_energy_j_mol * self.activation_energy_factor,
            heat_capacity_j_kg_k: raw.heat_capacity_j_kg_k * self.heat_capacity_factor,
            ..raw
        })
    }
}

#[cfg(test)]
pub(crate) mod tests;
