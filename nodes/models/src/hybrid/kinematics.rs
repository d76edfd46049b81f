//! Inverse kinematics in closed form, forward kinematics by Newton, the Jacobian and the guard before singular poses.

use nalgebra::{Matrix4, Vector3, Vector4};

use super::CARRIAGES;
use super::geometry::{Geometry, Refused};
use super::pose::{Pose, SurfacePoint, Target};

/// Newton ends when a step is shorter `[m]`: a thousandth of the accuracy that is promised (1e-10 m).
const STEP_END_M: f64 = 1e-13;
/// Newton gives up after so many steps: from a nominal pose it needs 3 to 8.
const STEPS_MAX: u32 = 50;

impl Geometry {
    /// Carriages of a pose `[m]`: `q_i = s_z + sqrt(L^2 - (X - s_x)^2 - (Y - s_y)^2)`, carriages above their joints.
    ///
    /// # Errors
    /// [`Refused::Unreachable`] where a rod is too short, [`Refused::Travel`] beyond the ends of the rails.
    pub fn carriages(&self, pose: &Pose) -> Result<[f64; CARRIAGES], Refused> {
        let mut carriages_m = [0.0; CARRIAGES];
        for (index, carriage_m) in carriages_m.iter_mut().enumerate() {
            let joint_m = pose.machine_from_platform(&self.joint(index));
            let reach_m = (self.rail(index) - joint_m.xy()).norm();
            if reach_m.is_nan() || reach_m >= self.rod_m {
                return Err(Refused::Unreachable { carriage: index + 1, reach_m, rod_m: self.rod_m });
            }
            *carriage_m = joint_m.z + (self.rod_m.powi(2) - reach_m.powi(2)).sqrt();
            if !(self.carriage_low_m..=self.carriage_high_m).contains(carriage_m) {
                return Err(Refused::Travel {
                    carriage: index + 1,
                    value_m: *carriage_m,
                    low_m: self.carriage_low_m,
                    high_m: self.carriage_high_m,
                });
            }
        }
        Ok(carriages_m)
    }

    /// Rods from joints to carriages `[m]`, for carriages that need not fit the pose.
    fn rod(&self, pose: &Pose, carriages_m: &[f64; CARRIAGES], index: usize) -> Vector3<f64> {
        let rail_m = self.rail(index);
        Vector3::new(rail_m.x, rail_m.y, carriages_m[index]) - pose.machine_from_platform(&self.joint(index))
    }

    /// How the joints move with x, y, z and tilt, projected on the rods `[m, m2/rad]`.
    fn projected(&self, pose: &Pose, carriages_m: &[f64; CARRIAGES]) -> Matrix4<f64> {
        let mut matrix = Matrix4::zeros();
        for index in 0..CARRIAGES {
            let rod_m = self.rod(pose, carriages_m, index);
            let slope = rod_m.dot(&pose.tilt_slope(&self.joint(index)));
            matrix.set_row(index, &Vector4::new(rod_m.x, rod_m.y, rod_m.z, slope).transpose());
        }
        matrix
    }

    /// Jacobian `dq/d(x, y, z, tilt)` `[-, m/rad]` of a pose with its carriages.
    ///
    /// `|R_i - s_i| = L` differentiated: `dq_i = (r_i . ds_i)/r_iz` with the rod r_i; r_iz is above 0 on our branch.
    #[must_use]
    pub fn jacobian(&self, pose: &Pose, carriages_m: &[f64; CARRIAGES]) -> Matrix4<f64> {
        let mut matrix = self.projected(pose, carriages_m);
        for index in 0..CARRIAGES {
            let height_m = self.rod(pose, carriages_m, index).z;
            matrix.row_mut(index).scale_mut(1.0 / height_m);
        }
        matrix
    }

    /// Condition number of a Jacobian with the tilt taken times the rod's length, so that all columns have one unit.
    #[must_use]
    pub fn condition(&self, jacobian: &Matrix4<f64>) -> f64 {
        let mut scaled = *jacobian;
        scaled.column_mut(3).scale_mut(1.0 / self.rod_m);
        let singular = scaled.singular_values();
        if singular.min() > 0.0 { singular.max() / singular.min() } else { f64::INFINITY }
    }

    /// Pose of the platform from its carriages, by Newton from a pose nearby, on that pose's branch.
    ///
    /// # Errors
    /// [`Refused::NoPose`] or [`Refused::OtherBranch`].
    pub fn pose(&self, carriages_m: &[f64; CARRIAGES], start: &Pose) -> Result<Pose, Refused> {
        let mut pose = *start;
        let mut before = None;
        let mut step_m = f64::INFINITY;
        for _ in 0..STEPS_MAX {
            let projected = self.projected(&pose, carriages_m);
            before = before.or_else(|| Some(projected.determinant()));
            let residual = Vector4::from_fn(|index, _| {
                0.5 * (self.rod(&pose, carriages_m, index).norm_squared() - self.rod_m.powi(2))
            });
            let Some(step) = projected.lu().solve(&residual) else { break };
            pose.position_m += step.xyz();
            pose.tilt_rad += step.w;
            step_m = step.xyz().norm().max(self.rod_m * step.w.abs());
            if step_m < STEP_END_M {
                return self.same_branch(pose, carriages_m, before.unwrap_or(f64::NAN));
            }
        }
        Err(Refused::NoPose { iterations: STEPS_MAX, step_m, limit_m: STEP_END_M })
    }

    fn same_branch(&self, pose: Pose, carriages_m: &[f64; CARRIAGES], before: f64) -> Result<Pose, Refused> {
        let after = self.projected(&pose, carriages_m).determinant();
        let above = (0..CARRIAGES).all(|index| self.rod(&pose, carriages_m, index).z > 0.0);
        if above && before * after > 0.0 { Ok(pose) } else { Err(Refused::OtherBranch { before, after }) }
    }

    /// Everything that errors need to know of a point, or why the machine should not work there.
    ///
    /// # Errors
    /// [`Refused`] for what the machine cannot reach, and [`Refused::Singular`] beyond its guard.
    pub fn station(&self, point: &SurfacePoint) -> Result<Station<'_>, Refused> {
        Station::new(self, self.target(point)?)
    }
}

/// A point of the surface at the tip of the extruder: the nominal state that errors are counted from.
#[derive(Debug, Clone, Copy)]
pub struct Station<'a> {
    pub(super) geometry: &'a Geometry,
    /// What the axes do.
    pub target: Target,
    /// Carriages `[m]`.
    pub carriages_m: [f64; CARRIAGES],
    /// Condition number of the Jacobian `[-]`.
    pub condition: f64,
    pub(super) gain: super::error::Gain,
}

impl<'a> Station<'a> {
    fn new(geometry: &'a Geometry, target: Target) -> Result<Self, Refused> {
        let carriages_m = geometry.carriages(&target.pose)?;
        let jacobian = geometry.jacobian(&target.pose, &carriages_m);
        let condition = geometry.condition(&jacobian);
        let gain = jacobian.try_inverse().map(|inverse| super::error::gain(&target, &inverse));
        let sum = gain.map_or(f64::INFINITY, |gain| gain.carriage_sum());
        match gain {
            Some(gain) if condition <= geometry.condition_max && sum <= geometry.gain_max => {
                Ok(Self { geometry, target, carriages_m, condition, gain })
            }
            _ => Err(Refused::Singular {
                condition,
                gain: sum,
                tilt_rad: target.pose.tilt_rad,
                condition_max: geometry.condition_max,
                gain_max: geometry.gain_max,
            }),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
