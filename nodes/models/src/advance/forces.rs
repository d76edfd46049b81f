//! Friction against inertia in the nozzle's capillary (model book 2.1).

use std::f64::consts::PI;

/// Melt on its way through the nozzle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// Dynamic viscosity mu `[Pa s]`.
    pub viscosity_pa_s: f64,
    /// Length of the capillary L `[m]`.
    pub length_m: f64,
    /// Speed at the outlet `[m/s]`.
    pub outlet_m_s: f64,
    /// Density rho `[kg/m3]`.
    pub density_kg_m3: f64,
    /// Diameter of the filament `[m]`.
    pub inlet_diameter_m: f64,
    /// Diameter of the outlet `[m]`.
    pub outlet_diameter_m: f64,
}

/// What the passage costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forces {
    /// Friction on the outlet's area, as the paper has it `[N]`.
    pub friction_n: f64,
    /// The same pressure on the filament's area `[N]`.
    pub friction_on_filament_n: f64,
    /// Acceleration of the melt from filament to outlet `[N]`.
    pub acceleration_n: f64,
}

impl Passage {
    /// `F_f = 8 pi mu L v_out` (Hagen and Poiseuille on the outlet's area) and
    /// `F_a = pi rho d_in^2 v_out^2 (1 - (d_out/d_in)^4) / 8` (Bernoulli on the filament's).
    #[must_use]
    pub fn forces(&self) -> Forces {
        let friction_n = 8.0 * PI * self.viscosity_pa_s * self.length_m * self.outlet_m_s;
        let narrowing = (self.outlet_diameter_m / self.inlet_diameter_m).powi(2);
        let dynamic = self.density_kg_m3 * (self.inlet_diameter_m * self.outlet_m_s).powi(2);
        Forces {
            friction_n,
            friction_on_filament_n: friction_n / narrowing,
            acceleration_n: PI * dynamic * (1.0 - narrowing * narrowing) / 8.0,
        }
    }
}

impl Forces {
    /// Friction over acceleration, both as the paper has them `[-]`.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.friction_n / self.acceleration_n
    }
}
