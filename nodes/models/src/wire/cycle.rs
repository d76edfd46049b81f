//! Feed of the wire and speed of the head from material and power.

use serde::Deserialize;

use crate::params::{ParamError, in_range};

use super::drop::{cap_lower_limit_m, missing_m3, radius_m};
use super::material::Material;
use super::melting::{Film, energy_j, wire_volume_m3};

/// Wire and power of a process. Built only from a valid [`RawFeed`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawFeed")]
pub struct Feed(RawFeed);

read_only!(Feed(RawFeed));

/// The `feed` block of `config/wire/process.yaml` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawFeed {
    /// Diameter of the wire `[m]`, in `[1e-4, 0.02]`.
    pub diameter_m: f64,
    /// Length of wire that makes one drop `[m]`, in `[1e-4, 0.1]`.
    pub drop_length_m: f64,
    /// Laser power that the wire takes up `[W]`, above 0.
    pub absorbed_w: f64,
    /// Coefficient k_c of the head's way per drop `[-]`, in `[0.1, 2]`; 2/3 is the mass balance.
    pub spacing: f64,
}

/// Diameters of a wire `[m]`.
pub const DIAMETER_RANGE_M: (f64, f64) = (1e-4, 0.02);
/// Lengths of wire that make one drop `[m]`.
pub const DROP_LENGTH_RANGE_M: (f64, f64) = (1e-4, 0.1);

impl TryFrom<RawFeed> for Feed {
    type Error = ParamError;

    fn try_from(raw: RawFeed) -> Result<Self, ParamError> {
        in_range("diameter_m", raw.diameter_m, "m", DIAMETER_RANGE_M)?;
        in_range("drop_length_m", raw.drop_length_m, "m", DROP_LENGTH_RANGE_M)?;
        in_range("absorbed_w", raw.absorbed_w, "W", (0.01, 1e6))?;
        in_range("spacing", raw.spacing, "-", (0.1, 2.0))?;
        Ok(Self(raw))
    }
}

/// One drop, from wire to bead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycle {
    /// Mass of the drop `[kg]`.
    pub mass_kg: f64,
    /// Energy that melts it `[J]`, above 0.
    pub energy_j: f64,
    /// Time of melting and drainage `[s]`.
    pub period_s: f64,
    /// Volume of the drop `[m3]`.
    pub volume_m3: f64,
    /// Radius and height of the drop, the layer's height `[m]`.
    pub radius_m: f64,
    /// What the drop lacks to a cylinder `[m3]`.
    pub missing_m3: f64,
    /// Way of the head per drop before the coefficient k_c `[m]`: the radius.
    pub uncorrected_m: f64,
    /// Way of the head per drop a `[m]`.
    pub pitch_m: f64,
    /// Speed of the wire `[m/s]`: `h_w/t`.
    pub wire_m_s: f64,
    /// Speed of the head `[m/s]`: `k_c a/t`.
    pub head_m_s: f64,
    /// Cross section of the bead `[m2]`: `V/a`, with k_c = 2/3 `pi R^2`.
    pub section_m2: f64,
}

impl Feed {
    /// Speeds and sizes of one drop; without a film the drainage is left out (it is microseconds for thick films).
    ///
    /// # Errors
    /// [`ParamError::OutOfRange`] for what is no film.
    pub fn cycle(&self, material: &Material, film: Option<&Film>) -> Result<Cycle, ParamError> {
        let volume_m3 = wire_volume_m3(self.diameter_m, self.drop_length_m);
        let energy_j = energy_j(material, volume_m3);
        let drain_s =
            film.map_or(Ok(0.0), |film| film.drain_s(material.melt_density_kg_m3, material.viscosity_pa_s))?;
        let period_s = energy_j / self.absorbed_w + drain_s;
        let radius_m = radius_m(volume_m3);
        let missing_m3 = missing_m3(radius_m, volume_m3);
        let uncorrected_m = cap_lower_limit_m(radius_m, 2.0 * missing_m3)?;
        let pitch_m = self.spacing * uncorrected_m;
        Ok(Cycle {
            mass_kg: material.density_kg_m3 * volume_m3,
            energy_j,
            period_s,
            volume_m3,
            radius_m,
            missing_m3,
            uncorrected_m,
            pitch_m,
            wire_m_s: self.drop_length_m / period_s,
            head_m_s: pitch_m / period_s,
            section_m2: volume_m3 / pitch_m,
        })
    }

    /// Power that a speed of the wire takes, without drainage `[W]`: `rho A v (c dT + lambda)`.
    #[must_use]
    pub fn power_w(&self, material: &Material, wire_m_s: f64) -> f64 {
        energy_j(material, wire_volume_m3(self.diameter_m, 1.0)) * wire_m_s
    }
}

#[cfg(test)]
mod tests {
    use super::super::material::tests::ALUMINIUM;
    use super::*;

    const NOMINAL: RawFeed =
        RawFeed { diameter_m: 3e-3, drop_length_m: 3e-3, absorbed_w: 64.885, spacing: 2.0 / 3.0 };

    fn cycle() -> Cycle {
        let metal = Material::try_from(ALUMINIUM).unwrap();
        Feed::try_from(NOMINAL).unwrap().cycle(&metal, None).unwrap()
    }

    /// Model book 3.2: 64.9 W give the printed 3.50 and 1.68 mm/s.
    #[test]
    fn the_nominal_row_is_the_printed_one() {
        assert!((cycle().wire_m_s - 3.50e-3).abs() < 5e-6);
        assert!((cycle().head_m_s - 1.68e-3).abs() < 5e-6);
    }

    /// k_c = 2/3 is the mass balance: wire in is bead out, and the bead is as wide as pi R^2 over R.
    #[test]
    fn what_goes_in_as_wire_lies_there_as_bead() {
        let cycle = cycle();
        let wire_m2 = wire_volume_m3(3e-3, 1.0);
        assert!((cycle.wire_m_s * wire_m2 / cycle.head_m_s / cycle.section_m2 - 1.0).abs() < 1e-12);
        assert!((cycle.section_m2 / (std::f64::consts::PI * cycle.radius_m.powi(2)) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_planned_speed_takes_the_whole_power() {
        let metal = Material::try_from(ALUMINIUM).unwrap();
        let feed = Feed::try_from(NOMINAL).unwrap();
        assert!((feed.power_w(&metal, cycle().wire_m_s) - 64.885).abs() < 1e-9);
    }

    #[test]
    fn a_negative_diameter_is_named_with_its_limit() {
        let error = Feed::try_from(RawFeed { diameter_m: -3e-3, ..NOMINAL }).unwrap_err();
        assert_eq!(error.to_string(), "diameter_m = -0.003 m: must be in [0.0001, 0.02]");
    }
}
