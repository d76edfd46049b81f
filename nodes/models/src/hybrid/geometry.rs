//! Where rails, joints and rods are, and what the machine refuses.

use nalgebra::{Vector2, Vector3};
use serde::Deserialize;

use super::CARRIAGES;
use crate::params::{ParamError, in_range, ordered, positive};

/// A machine. Built only from a valid [`RawGeometry`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawGeometry")]
pub struct Geometry(RawGeometry);

read_only!(Geometry(RawGeometry));

/// The `machine` block of `config/machines/*.yaml` as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawGeometry {
    /// Where the geometry comes from, for people: printed, measured or identified.
    pub provenance: String,
    /// Length of every rod L `[m]`, above 0.
    pub rod_m: f64,
    /// Rails in the machine's x and y `[m]`, each in `[-10, 10]`.
    pub rails_m: [[f64; 2]; CARRIAGES],
    /// Joints on the platform, in its frame `[m]`, each in `[-10, 10]`.
    pub joints_m: [[f64; 3]; CARRIAGES],
    /// Base of the part above the platform's origin `[m]`, in `[-10, 10]`.
    pub part_offset_m: f64,
    /// Tip of the extruder in the machine's frame `[m]`, each in `[-10, 10]`.
    pub tip_m: [f64; 3],
    /// Travel of a carriage per turn of its motor `[m]`, above 0.
    pub lead_m: f64,
    /// Lowest carriage `[m]`.
    pub carriage_low_m: f64,
    /// Highest carriage `[m]`.
    pub carriage_high_m: f64,
    /// Largest tilt of the platform away from level `[rad]`, in `(0, pi]`.
    pub tilt_max_rad: f64,
    /// Largest condition number of the Jacobian, tilt taken times the rod's length `[-]`, in `[1, 1e12]`.
    pub condition_max: f64,
    /// Largest sum of the carriages' gains `[-]`, in `[1, 1e12]`.
    pub gain_max: f64,
}

impl TryFrom<RawGeometry> for Geometry {
    type Error = ParamError;

    fn try_from(raw: RawGeometry) -> Result<Self, ParamError> {
        const REACH_M: (f64, f64) = (-10.0, 10.0);
        positive("rod_m", raw.rod_m, "m")?;
        for value in raw.rails_m.iter().flatten() {
            in_range("rails_m", *value, "m", REACH_M)?;
        }
        for value in raw.joints_m.iter().flatten() {
            in_range("joints_m", *value, "m", REACH_M)?;
        }
        in_range("part_offset_m", raw.part_offset_m, "m", REACH_M)?;
        for value in raw.tip_m {
            in_range("tip_m", value, "m", REACH_M)?;
        }
        positive("lead_m", raw.lead_m, "m")?;
        in_range("carriage_low_m", raw.carriage_low_m, "m", REACH_M)?;
        in_range("carriage_high_m", raw.carriage_high_m, "m", REACH_M)?;
        ordered(("carriage_low_m", raw.carriage_low_m), ("carriage_high_m", raw.carriage_high_m))?;
        positive("tilt_max_rad", raw.tilt_max_rad, "rad")?;
        in_range("tilt_max_rad", raw.tilt_max_rad, "rad", (0.0, std::f64::consts::PI))?;
        in_range("condition_max", raw.condition_max, "-", (1.0, 1e12))?;
        in_range("gain_max", raw.gain_max, "-", (1.0, 1e12))?;
        Ok(Self(raw))
    }
}

impl Geometry {
    pub(super) fn rail(&self, index: usize) -> Vector2<f64> {
        Vector2::from(self.rails_m[index])
    }

    pub(super) fn joint(&self, index: usize) -> Vector3<f64> {
        Vector3::from(self.joints_m[index])
    }

    pub(super) fn tip(&self) -> Vector3<f64> {
        Vector3::from(self.tip_m)
    }
}

/// Why a pose or a point was refused; the outcome that a map shows in place of an error.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refused {
    /// A value that is no number, or a normal without direction.
    #[error("{name} = {value}: must be {rule}")]
    NotAPoint {
        /// What was given.
        name: &'static str,
        /// The refused value.
        value: f64,
        /// What it must be.
        rule: &'static str,
    },
    /// The platform would have to tilt too far.
    #[error("tilt_rad = {tilt_rad:.4} rad: must be in [-{limit_rad}, {limit_rad}]")]
    Tilt {
        /// Tilt that the normal asks for `[rad]`.
        tilt_rad: f64,
        /// Limit of the machine `[rad]`.
        limit_rad: f64,
    },
    /// A joint would be farther from its rail than its rod is long.
    #[error("reach_m[{carriage}] = {reach_m:.4} m: must be below the rod's {rod_m} m")]
    Unreachable {
        /// Number of the carriage, from 1.
        carriage: usize,
        /// Distance of the joint from the rail `[m]`.
        reach_m: f64,
        /// Length of the rod `[m]`.
        rod_m: f64,
    },
    /// A carriage would leave its rail.
    #[error("carriage_m[{carriage}] = {value_m:.4} m: must be in [{low_m}, {high_m}]")]
    Travel {
        /// Number of the carriage, from 1.
        carriage: usize,
        /// Where it would have to stand `[m]`.
        value_m: f64,
        /// Lower end `[m]`.
        low_m: f64,
        /// Upper end `[m]`.
        high_m: f64,
    },
    /// A pose at or near a fold of the kinematics.
    #[error(
        "condition = {condition:.4e}, sum of gains = {gain:.4e} at tilt {tilt_rad:.4} rad: must be at most \
         {condition_max} and {gain_max} (near a singular pose)"
    )]
    Singular {
        /// Condition number of the Jacobian `[-]`, infinite at the singular pose itself.
        condition: f64,
        /// Sum of the absolute carriage gains `[-]`.
        gain: f64,
        /// Tilt of the pose `[rad]`.
        tilt_rad: f64,
        /// Limit of the condition number `[-]`.
        condition_max: f64,
        /// Limit of the gain `[-]`.
        gain_max: f64,
    },
    /// Newton's iteration found no pose.
    #[error(
        "no pose after {iterations} iterations, the last step was {step_m:.3e} m: must be below {limit_m:.0e} m"
    )]
    NoPose {
        /// Iterations made.
        iterations: u32,
        /// Length of the last step `[m]`.
        step_m: f64,
        /// Length at which it would have ended `[m]`.
        limit_m: f64,
    },
    /// The pose found belongs to another assembly of the machine.
    #[error("det J went from {before:.3e} to {after:.3e}: must keep its sign, or the assembly has changed")]
    OtherBranch {
        /// Determinant at the start.
        before: f64,
        /// Determinant at the pose found.
        after: f64,
    },
}
