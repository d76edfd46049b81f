//! What wrong axes do to the surface: `Delta = [A21 A10 - A21' A10'] p` and its part along the normal.

use nalgebra::{Matrix4, Vector3};

use super::CARRIAGES;
use super::geometry::Refused;
use super::kinematics::Station;
use super::pose::{Pose, Target, about_z};

/// Errors of the axes, each as large as they get.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisError {
    /// Of every carriage `[m]`, 0 or more.
    pub carriage_m: f64,
    /// Of the table `[rad]`, 0 or more.
    pub table_rad: f64,
}

impl AxisError {
    /// Every motor wrong by the same angle `[rad]`: carriages by `lead angle/2pi`, the table by the angle.
    #[must_use]
    pub fn of_motors(angle_rad: f64, lead_m: f64) -> Self {
        Self { carriage_m: lead_m * angle_rad / std::f64::consts::TAU, table_rad: angle_rad }
    }
}

/// First-order error along the normal per error of an axis: `G = -n . dp/dq`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Of the carriages `[m/m]`.
    pub carriages: [f64; CARRIAGES],
    /// Of the table `[m/rad]`; 0 where the normal passes through the table's axis, as on the hemisphere.
    pub table_m_rad: f64,
}

impl Gain {
    /// Sum of the carriages' absolute gains `[-]`.
    #[must_use]
    pub fn carriage_sum(&self) -> f64 {
        self.carriages.iter().map(|gain| gain.abs()).sum()
    }

    /// Largest first-order error `[m]`.
    #[must_use]
    pub fn largest_m(&self, error: &AxisError) -> f64 {
        self.carriage_sum() * error.carriage_m + self.table_m_rad.abs() * error.table_rad
    }
}

/// Gain at a target with the inverse Jacobian `d(x, y, z, tilt)/dq`.
pub(super) fn gain(target: &Target, inverse: &Matrix4<f64>) -> Gain {
    let normal = target.pose.rotation() * target.platform_normal;
    let per_tilt = normal.dot(&target.pose.tilt_slope(&target.platform_point_m));
    let per_pose = nalgebra::Vector4::new(normal.x, normal.y, normal.z, per_tilt);
    let carriages = -(inverse.transpose() * per_pose);
    let turned = Vector3::z().cross(&target.platform_point_m);
    Gain { carriages: carriages.into(), table_m_rad: -target.platform_normal.dot(&turned) }
}

/// What one set of axis errors does to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// Actual pose of the platform.
    pub pose: Pose,
    /// Error vector in the machine's frame, nominal less actual `[m]`.
    pub vector_m: Vector3<f64>,
    /// Its part along the nominal normal `[m]`.
    pub normal_m: f64,
}

/// The worst combination of signs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremal {
    /// Largest absolute error along the normal `[m]`.
    pub largest_m: f64,
    /// Signs of the four carriages and the table that make it.
    pub signs: [f64; CARRIAGES + 1],
    /// Combinations without a pose on the nominal branch; they are no part of the maximum.
    pub failed: u32,
}

/// Combinations of signs of the carriages and the table: what a worst error is taken over.
pub const COMBINATIONS: u32 = 1 << (CARRIAGES + 1);

/// Every combination of signs of the carriages.
fn carriage_signs() -> impl Iterator<Item = [f64; CARRIAGES]> {
    (0..1_u32 << CARRIAGES)
        .map(|combination| std::array::from_fn(|bit| if combination >> bit & 1 == 1 { 1.0 } else { -1.0 }))
}

/// Errors along the normal of many random axis errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Draws that had a pose.
    pub count: u32,
    /// Draws without a pose on the nominal branch.
    pub failed: u32,
    /// Mean `[m]`.
    pub mean_m: f64,
    /// Root of the mean square about the mean `[m]`.
    pub deviation_m: f64,
    /// Largest absolute value `[m]`.
    pub largest_m: f64,
}

impl Station<'_> {
    /// First-order gains.
    #[must_use]
    pub fn gain(&self) -> Gain {
        self.gain
    }

    /// Exact error for errors of the carriages `[m]` and of the table `[rad]`.
    ///
    /// # Errors
    /// [`Refused`] where no pose on the nominal branch belongs to the wrong carriages.
    pub fn shift(&self, carriage_m: &[f64; CARRIAGES], table_rad: f64) -> Result<Shift, Refused> {
        let pose = self.actual_pose(carriage_m)?;
        Ok(self.shift_at(pose, table_rad))
    }

    fn actual_pose(&self, carriage_m: &[f64; CARRIAGES]) -> Result<Pose, Refused> {
        let actual_m = std::array::from_fn(|index| self.carriages_m[index] + carriage_m[index]);
        self.geometry.pose(&actual_m, &self.target.pose)
    }

    fn shift_at(&self, pose: Pose, table_rad: f64) -> Shift {
        let nominal_m = self.target.platform_point_m;
        let turned_m = about_z(table_rad) * nominal_m;
        let vector_m =
            self.target.pose.machine_from_platform(&nominal_m) - pose.machine_from_platform(&turned_m);
        let normal = self.target.pose.rotation() * self.target.platform_normal;
        Shift { pose, vector_m, normal_m: vector_m.dot(&normal) }
    }

    /// Largest error over the 2^5 combinations of signs; the pose knows nothing of the table's, so 2^4 are solved.
    #[must_use]
    pub fn extremal(&self, error: &AxisError) -> Extremal {
        let mut worst = Extremal { largest_m: 0.0, signs: [0.0; CARRIAGES + 1], failed: 0 };
        for signs in carriage_signs() {
            let Ok(pose) = self.actual_pose(&signs.map(|sign| sign * error.carriage_m)) else {
                worst.failed += 2;
                continue;
            };
            for table in [-1.0, 1.0] {
                let normal_m = self.shift_at(pose, table * error.table_rad).normal_m.abs();
                if normal_m > worst.largest_m {
                    worst.largest_m = normal_m;
                    worst.signs = [signs[0], signs[1], signs[2], signs[3], table];
                }
            }
        }
        worst
    }

    /// Largest error across the extruder's axis over all combinations of signs `[m]`, where a camera at the extruder
    /// looks for an offset between layers; none where a combination has no pose on the nominal branch.
    #[must_use]
    pub fn lateral_m(&self, error: &AxisError) -> Option<f64> {
        let mut largest_m = 0.0_f64;
        for signs in carriage_signs() {
            let pose = self.actual_pose(&signs.map(|sign| sign * error.carriage_m)).ok()?;
            for table in [-1.0, 1.0] {
                let shift = self.shift_at(pose, table * error.table_rad);
                largest_m = largest_m.max(shift.vector_m.x.hypot(shift.vector_m.y));
            }
        }
        Some(largest_m)
    }

    /// Errors of `count` random draws; `uniform` gives independent numbers in `[-1, 1]`, a part of each axis' error.
    pub fn monte_carlo(&self, error: &AxisError, count: u32, uniform: &mut impl FnMut() -> f64) -> Spread {
        let (mut sum, mut squares, mut largest_m, mut failed) = (0.0, 0.0, 0.0_f64, 0);
        for _ in 0..count {
            let carriage_m = std::array::from_fn(|_| error.carriage_m * uniform());
            match self.shift(&carriage_m, error.table_rad * uniform()) {
                Ok(shift) => {
                    sum += shift.normal_m;
                    squares += shift.normal_m * shift.normal_m;
                    largest_m = largest_m.max(shift.normal_m.abs());
                }
                Err(_) => failed += 1,
            }
        }
        let drawn = f64::from((count - failed).max(1));
        let mean_m = sum / drawn;
        // Rounding alone can bring the difference below 0.
        let deviation_m = (squares / drawn - mean_m * mean_m).max(0.0).sqrt();
        Spread { count: count - failed, failed, mean_m, deviation_m, largest_m }
    }
}

#[cfg(test)]
mod tests;
