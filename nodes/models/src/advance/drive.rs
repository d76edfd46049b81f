//! Lag of a drive: static law of the compressed filament for polymer, temperature and shape of the line.
//!
//! `x = C v_ref/n (u/v_ref)^n + K_lin u`, so `dx/du = C (u/v_ref)^(n-1) + K_lin` (model book 2.4).

use serde::{Deserialize, Serialize};

use crate::extruder::StaticLaw;
use crate::melt::GAS_CONSTANT_J_MOL_K;
use crate::params::{ParamError, in_range, ordered};
use crate::units::{Celsius, Kelvin};

/// Where the drive gear sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DriveKind {
    /// On the frame, a tube leads to the hot end.
    Bowden,
    /// On the hot end.
    Direct,
}

impl DriveKind {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Bowden, Self::Direct];

    /// Name in files and commands.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Bowden => "bowden",
            Self::Direct => "direct",
        }
    }
}

/// What a line is printed with, as far as the lag depends on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Condition {
    /// Temperature of the hot end.
    pub temperature: Celsius,
    /// Height of the layer h `[m]`, above 0.
    pub height_m: f64,
    /// Width of the line w `[m]`, above 0; the paper's `D_s`, a line as wide as the nozzle.
    pub width_m: f64,
}

/// A drive. Built only from a valid [`RawDrive`], whose fields it shows.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawDrive")]
pub struct Drive(RawDrive);

read_only!(Drive(RawDrive));

/// One drive's block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawDrive {
    /// Scale `c_a` of the power-law part `[s]`, in `[1e-4, 5]`.
    pub scale_s: f64,
    /// Linear part `K_lin` `[s]`, in `[1e-4, 5]`.
    pub linear_s: f64,
    /// Layer height `h_g` below which the gap to the layer holds the melt back `[m]`, in `[1e-6, 1e-3]`.
    pub gap_m: f64,
    /// Exponent m of that `[-]`, in `[0, 6]`.
    pub gap_power: f64,
    /// Outlet speed `v_ref` that the scale is meant at `[m/s]`, in `[1e-5, 0.1]`.
    pub reference_m_s: f64,
    /// Width of the line that the scale is meant at `[m]`, in `[1e-5, 0.01]`.
    pub reference_width_m: f64,
    /// Area of the filament's cross section `A_f` `[m2]`, in `[1e-7, 2e-5]`.
    pub filament_area_m2: f64,
    /// Least and largest `K_A` that such a drive can need `[s]`: the range of the network's output.
    pub advance_range_s: [f64; 2],
}

impl TryFrom<RawDrive> for Drive {
    type Error = ParamError;

    fn try_from(raw: RawDrive) -> Result<Self, ParamError> {
        in_range("scale_s", raw.scale_s, "s", (1e-4, 5.0))?;
        in_range("linear_s", raw.linear_s, "s", (1e-4, 5.0))?;
        in_range("gap_m", raw.gap_m, "m", (1e-6, 1e-3))?;
        in_range("gap_power", raw.gap_power, "-", (0.0, 6.0))?;
        in_range("reference_m_s", raw.reference_m_s, "m/s", (1e-5, 0.1))?;
        in_range("reference_width_m", raw.reference_width_m, "m", (1e-5, 1e-2))?;
        in_range("filament_area_m2", raw.filament_area_m2, "m2", (1e-7, 2e-5))?;
        let [low_s, high_s] = raw.advance_range_s;
        in_range("advance_range_s", low_s, "s", (0.0, 10.0))?;
        in_range("advance_range_s", high_s, "s", (0.0, 10.0))?;
        ordered(("advance_range_s[0]", low_s), ("advance_range_s[1]", high_s))?;
        Ok(Self(raw))
    }
}

/// A polymer as far as the lag depends on it. Built only from a valid [`RawPolymer`], whose fields it shows.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawPolymer")]
pub struct Polymer(RawPolymer);

read_only!(Polymer(RawPolymer));

/// One polymer's block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawPolymer {
    /// Flow index n `[-]`, in `[0.1, 1]`.
    pub flow_index: f64,
    /// Activation energy `E_a` `[J/mol]`, in `[0, 3e5]`.
    pub activation_j_mol: f64,
    /// Temperature that the factor is meant at `T_ref`.
    pub reference: Celsius,
    /// Factor a against PLA `[-]`, in `[0.01, 100]`.
    pub factor: f64,
    /// Least and largest temperature that it is printed at `[degC]`.
    pub range_c: [f64; 2],
}

impl TryFrom<RawPolymer> for Polymer {
    type Error = ParamError;

    fn try_from(raw: RawPolymer) -> Result<Self, ParamError> {
        in_range("flow_index", raw.flow_index, "-", (0.1, 1.0))?;
        in_range("activation_j_mol", raw.activation_j_mol, "J/mol", (0.0, 3e5))?;
        in_range("reference", raw.reference.0, "degC", (100.0, 400.0))?;
        in_range("factor", raw.factor, "-", (0.01, 100.0))?;
        let [low_c, high_c] = raw.range_c;
        in_range("range_c", low_c, "degC", (100.0, 400.0))?;
        in_range("range_c", high_c, "degC", (100.0, 400.0))?;
        ordered(("range_c[0]", low_c), ("range_c[1]", high_c))?;
        Ok(Self(raw))
    }
}

impl Polymer {
    /// `exp[E_a/R (1/T - 1/T_ref)]` `[-]`.
    #[must_use]
    pub fn temperature_factor(&self, temperature: Celsius) -> f64 {
        let (now_k, reference_k) = (Kelvin::from(temperature).0, Kelvin::from(self.reference).0);
        (self.activation_j_mol / GAS_CONSTANT_J_MOL_K * (1.0 / now_k - 1.0 / reference_k)).exp()
    }
}

impl Drive {
    /// Static law of this drive. `C = c_a a f(T) (1 + (h_g/h)^m w_ref/w)`.
    #[must_use]
    pub fn law(&self, polymer: &Polymer, at: &Condition) -> StaticLaw {
        let gap = (self.gap_m / at.height_m).powf(self.gap_power) * self.reference_width_m / at.width_m;
        let scale_s =
            self.scale_s * polymer.factor * polymer.temperature_factor(at.temperature) * (1.0 + gap);
        let index = polymer.flow_index;
        let compression_scale = scale_s / index * self.reference_m_s.powf(1.0 - index);
        StaticLaw::of_compression(index, compression_scale, self.linear_s)
    }

    /// Outlet speed in filament lengths u `[m/s]` of a line laid at head speed v: `u = v h w / A_f`, the rectangle.
    #[must_use]
    pub fn outlet_m_s(&self, at: &Condition, head_m_s: f64) -> f64 {
        head_m_s * at.height_m * at.width_m / self.filament_area_m2
    }

    /// Lag between two head speeds `[s]`: the secant `(x(u2) - x(u1)) / (u2 - u1)` of the static law.
    ///
    /// Over a change of speed this is the compensation that leaves the right length of filament compressed; it meets
    /// the best `K_A` of the test line within 2 %.
    #[must_use]
    pub fn secant_s(&self, polymer: &Polymer, at: &Condition, (low_m_s, high_m_s): (f64, f64)) -> f64 {
        let law = self.law(polymer, at);
        let (low, high) = (self.outlet_m_s(at, low_m_s), self.outlet_m_s(at, high_m_s));
        (law.compression_m(high) - law.compression_m(low)) / (high - low)
    }
}
