//! What a print hides: bond between layers, porosity, layer shift ([QC] (8)-(10), model book 1.2).

use serde::Deserialize;

use crate::material::Material;
use crate::params::{ParamError, in_range};
use crate::units::Kelvin;

/// How a laid bead cools. Built only from a valid [`RawCooling`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawCooling")]
pub struct Cooling(RawCooling);

read_only!(Cooling(RawCooling));

/// The `cooling` block of a printer file as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawCooling {
    /// Heat transfer of a bead to still air `[W/(m2 K)]`, above 0.
    pub still_air_w_m2_k: f64,
    /// What the full part fan adds `[W/(m2 K)]`, 0 or more.
    pub fan_w_m2_k: f64,
}

impl TryFrom<RawCooling> for Cooling {
    type Error = ParamError;

    fn try_from(raw: RawCooling) -> Result<Self, ParamError> {
        in_range("still_air_w_m2_k", raw.still_air_w_m2_k, "W/(m2 K)", (0.1, 1e4))?;
        in_range("fan_w_m2_k", raw.fan_w_m2_k, "W/(m2 K)", (0.0, 1e4))?;
        Ok(Self(raw))
    }
}

/// A bead as it is laid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaidBead {
    /// Nozzle temperature `[K]`.
    pub nozzle_k: f64,
    /// Temperature of the layer below `[K]`.
    pub below_k: f64,
    /// Surrounding air `[K]`.
    pub ambient_k: f64,
    /// Layer height `[m]`, above 0.
    pub height_m: f64,
    /// Bead width `[m]`, above 0.
    pub width_m: f64,
    /// Part fan `[-]`, in `[0, 1]`.
    pub fan: f64,
}

impl Cooling {
    /// Time `[s]` for which the seam stays above the glass transition.
    ///
    /// `t_bond = t_c ln((T_i - T_amb)/(T_g - T_amb))`, `T_i = (T_n + T_sub)/2`, `t_c = rho c_p h w / (h_c (w + 2h))`.
    /// 0 for a seam that starts below T_g; infinite in air at or above T_g. Our closure (model book 1.2).
    #[must_use]
    pub fn bond_time_s(&self, material: &Material, bead: &LaidBead) -> f64 {
        let seam_k = 0.5 * (bead.nozzle_k + bead.below_k);
        let glass: Kelvin = Kelvin(material.glass_temp_k);
        if seam_k <= glass.0 {
            return 0.0;
        }
        if bead.ambient_k >= glass.0 {
            return f64::INFINITY;
        }
        let transfer_w_m2_k = self.still_air_w_m2_k + self.fan_w_m2_k * bead.fan;
        let heat_j_m_k =
            material.density_kg_m3 * material.heat_capacity_j_kg_k * bead.height_m * bead.width_m;
        let cooling_s = heat_j_m_k / (transfer_w_m2_k * (bead.width_m + 2.0 * bead.height_m));
        cooling_s * ((seam_k - bead.ambient_k) / (glass.0 - bead.ambient_k)).ln()
    }
}

/// Share of the bond that has formed `[-]`, in `[0, 1]`: `alpha = 1 - exp(-t_bond/tau)`, (8).
#[must_use]
pub fn adhesion(bond_time_s: f64, adhesion_time_s: f64) -> f64 {
    -(-bond_time_s / adhesion_time_s).exp_m1()
}

/// How full a layer is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fill {
    /// Share of the layer left empty phi `[-]`, in `[0, 1]`.
    pub porosity: f64,
    /// Share extruded beyond the layer's volume `[-]`, 0 or more.
    pub overfill: f64,
}

/// Fill from extruded and wanted volume, in the same unit; wanted above 0. The paper's (9) turns negative where
/// too much was extruded: here that is a figure of its own.
#[must_use]
pub fn fill(extruded: f64, wanted: f64) -> Fill {
    let ratio = extruded / wanted;
    Fill { porosity: (1.0 - ratio).max(0.0), overfill: (ratio - 1.0).max(0.0) }
}

/// Distance between actual and wanted position in the layer's plane `[m]`.
#[must_use]
pub fn layer_shift_m(actual_m: [f64; 2], wanted_m: [f64; 2]) -> f64 {
    (actual_m[0] - wanted_m[0]).hypot(actual_m[1] - wanted_m[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::tests::pla;

    fn bead() -> LaidBead {
        LaidBead {
            nozzle_k: 483.15,
            below_k: 328.15,
            ambient_k: 300.0,
            height_m: 2e-4,
            width_m: 4.8e-4,
            fan: 1.0,
        }
    }

    fn cooling() -> Cooling {
        Cooling::try_from(RawCooling { still_air_w_m2_k: 60.0, fan_w_m2_k: 90.0 }).unwrap()
    }

    /// Model book 1.2: PLA at 210 degC on a layer at 55 degC bonds to 0.905.
    #[test]
    fn the_reference_bead_bonds_as_the_model_book_says() {
        let bond_s = cooling().bond_time_s(&pla(), &bead());
        assert!((adhesion(bond_s, pla().adhesion_time_s) - 0.905).abs() < 5e-4);
    }

    #[test]
    fn a_seam_below_the_glass_transition_does_not_bond() {
        let cold = LaidBead { nozzle_k: 340.0, below_k: 300.0, ..bead() };
        let bond_s = cooling().bond_time_s(&pla(), &cold);
        assert!(bond_s.abs() < f64::EPSILON && adhesion(bond_s, 0.8).abs() < f64::EPSILON);
    }

    #[test]
    fn a_chamber_above_the_glass_transition_bonds_fully() {
        let hot = LaidBead { ambient_k: 340.0, ..bead() };
        assert!((adhesion(cooling().bond_time_s(&pla(), &hot), 0.8) - 1.0).abs() < f64::EPSILON);
    }

    #[test]
    fn the_fan_shortens_the_bond() {
        let still = LaidBead { fan: 0.0, ..bead() };
        assert!(cooling().bond_time_s(&pla(), &still) > cooling().bond_time_s(&pla(), &bead()));
    }

    #[test]
    fn porosity_and_overfill_exclude_each_other() {
        let (short, long) = (fill(0.9, 1.0), fill(1.05, 1.0));
        assert!((short.porosity - 0.1).abs() < 1e-12 && short.overfill.abs() < f64::EPSILON);
        assert!((long.overfill - 0.05).abs() < 1e-12 && long.porosity.abs() < f64::EPSILON);
    }
}
