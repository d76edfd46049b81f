//! What a metal needs to melt, and how its melt flows.

use serde::Deserialize;

use crate::params::{ParamError, in_range, ordered};

/// A metal. Built only from a valid [`RawMaterial`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawMaterial")]
pub struct Material(RawMaterial);

read_only!(Material(RawMaterial));

/// One block of `config/wire/materials.yaml` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawMaterial {
    /// Density of the solid wire `[kg/m3]`, above 0.
    pub density_kg_m3: f64,
    /// Specific heat between start and melting point `[J/(kg K)]`, above 0.
    pub heat_capacity_j_kg_k: f64,
    /// Heat of fusion lambda `[J/kg]`, above 0.
    pub fusion_j_kg: f64,
    /// Melting point, of an alloy the liquidus `[K]`.
    pub melting_k: f64,
    /// Temperature at which the wire arrives `[K]`, above 0, below the melting point.
    pub start_k: f64,
    /// Dynamic viscosity of the melt at the melting point `[Pa s]`, above 0.
    pub viscosity_pa_s: f64,
    /// Density of the melt at the melting point `[kg/m3]`, above 0.
    pub melt_density_kg_m3: f64,
    /// Share of the laser's light that the wire takes up `[-]`, in `[0.001, 1]`.
    pub absorptivity: f64,
}

impl TryFrom<RawMaterial> for Material {
    type Error = ParamError;

    fn try_from(raw: RawMaterial) -> Result<Self, ParamError> {
        in_range("density_kg_m3", raw.density_kg_m3, "kg/m3", (100.0, 5e4))?;
        in_range("heat_capacity_j_kg_k", raw.heat_capacity_j_kg_k, "J/(kg K)", (10.0, 1e5))?;
        in_range("fusion_j_kg", raw.fusion_j_kg, "J/kg", (1000.0, 1e7))?;
        in_range("start_k", raw.start_k, "K", (1.0, 5000.0))?;
        in_range("melting_k", raw.melting_k, "K", (1.0, 5000.0))?;
        ordered(("start_k", raw.start_k), ("melting_k", raw.melting_k))?;
        in_range("viscosity_pa_s", raw.viscosity_pa_s, "Pa s", (1e-6, 100.0))?;
        in_range("melt_density_kg_m3", raw.melt_density_kg_m3, "kg/m3", (100.0, 5e4))?;
        in_range("absorptivity", raw.absorptivity, "-", (0.001, 1.0))?;
        Ok(Self(raw))
    }
}

impl Material {
    /// Heat that takes a kilogram from the start to the melt `[J/kg]`: `c dT + lambda`, above 0.
    #[must_use]
    pub fn heat_j_kg(&self) -> f64 {
        self.heat_capacity_j_kg_k * (self.melting_k - self.start_k) + self.fusion_j_kg
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Aluminium of the golden vectors.
    pub(crate) const ALUMINIUM: RawMaterial = RawMaterial {
        density_kg_m3: 2700.0,
        heat_capacity_j_kg_k: 897.0,
        fusion_j_kg: 397e3,
        melting_k: 933.47,
        start_k: 293.15,
        viscosity_pa_s: 1.3e-3,
        melt_density_kg_m3: 2375.0,
        absorptivity: 0.065,
    };

    #[test]
    fn a_wire_that_arrives_molten_is_refused() {
        let error = Material::try_from(RawMaterial { start_k: 1000.0, ..ALUMINIUM }).unwrap_err();
        assert_eq!(error.to_string(), "start_k = 1000: must be below melting_k = 933.47");
    }

    /// 897 * 640.32 + 397000 = 971367.04 J/kg.
    #[test]
    fn the_heat_of_melting_is_sensible_and_latent() {
        let metal = Material::try_from(ALUMINIUM).unwrap();
        assert!((metal.heat_j_kg() - 971_367.04).abs() < 1e-6);
    }
}
