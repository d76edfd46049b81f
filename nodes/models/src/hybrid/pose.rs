//! Poses of platform and table for a point of the surface.

use nalgebra::{Matrix3, Vector3};

use super::geometry::{Geometry, Refused};
use super::mesh::{Triangle, doubled_area};

/// Pose of the platform: `A21 = Trans(x, y, z) Rot_X(tilt)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Position of the platform's origin `[m]`.
    pub position_m: Vector3<f64>,
    /// Tilt about X, beta `[rad]`; 0 level, -pi/2 upright.
    pub tilt_rad: f64,
}

impl Pose {
    pub(super) fn rotation(&self) -> Matrix3<f64> {
        let (sin, cos) = self.tilt_rad.sin_cos();
        Matrix3::new(1.0, 0.0, 0.0, 0.0, cos, -sin, 0.0, sin, cos)
    }

    /// A point of the platform in the machine's frame `[m]`.
    #[must_use]
    pub fn machine_from_platform(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        self.position_m + self.rotation() * point_m
    }

    /// How a point of the platform moves per tilt `[m/rad]`.
    pub(super) fn tilt_slope(&self, point_m: &Vector3<f64>) -> Vector3<f64> {
        let (sin, cos) = self.tilt_rad.sin_cos();
        Vector3::new(0.0, -point_m.y * sin - point_m.z * cos, point_m.y * cos - point_m.z * sin)
    }

    /// x, y, z `[m]` and tilt `[rad]`.
    #[must_use]
    pub fn coordinates(&self) -> [f64; 4] {
        [self.position_m.x, self.position_m.y, self.position_m.z, self.tilt_rad]
    }
}

/// `Rot_Z(angle)`.
pub(super) fn about_z(angle_rad: f64) -> Matrix3<f64> {
    let (sin, cos) = angle_rad.sin_cos();
    Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0)
}

/// A point of the part's surface, in the part's frame: origin on the table's axis at the part's base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Position `[m]`.
    pub position_m: Vector3<f64>,
    /// Normal out of the material; any length above 0.
    pub normal: Vector3<f64>,
}

impl SurfacePoint {
    /// The centre of a triangle with the triangle's normal.
    #[must_use]
    pub fn on_triangle(triangle: &Triangle) -> Self {
        Self { position_m: (triangle[0] + triangle[1] + triangle[2]) / 3.0, normal: doubled_area(triangle) }
    }

    /// The paper's part: a hemisphere of `radius_m`, at height `height_m` in `[0, radius_m]`.
    ///
    /// # Errors
    /// [`Refused::NotAPoint`] for a height that the hemisphere has not.
    pub fn on_hemisphere(radius_m: f64, height_m: f64) -> Result<Self, Refused> {
        if !(radius_m.is_finite() && radius_m > 0.0) {
            return Err(Refused::NotAPoint { name: "radius_m", value: radius_m, rule: "finite and > 0" });
        }
        if !(0.0..=radius_m).contains(&height_m) {
            return Err(Refused::NotAPoint {
                name: "height_m",
                value: height_m,
                rule: "in [0, radius of the hemisphere]",
            });
        }
        let outward_m = (radius_m * radius_m - height_m * height_m).sqrt();
        let position_m = Vector3::new(0.0, -outward_m, height_m);
        Ok(Self { position_m, normal: position_m / radius_m })
    }
}

/// What the axes have to do for a point: its normal along the extruder, the point at its tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Pose of the platform.
    pub pose: Pose,
    /// Angle of the table q5 `[rad]`.
    pub table_rad: f64,
    /// The point on the platform, table turned `[m]`.
    pub platform_point_m: Vector3<f64>,
    /// Its normal there, of length 1.
    pub platform_normal: Vector3<f64>,
}

impl Geometry {
    /// Turns the table until the normal points to -Y and tilts the platform until it stands along the extruder:
    /// `beta = -(90 deg - asin(n_z))`.
    ///
    /// # Errors
    /// [`Refused`] for a normal without direction, a position that is no number, or a tilt beyond the machine's.
    pub fn target(&self, point: &SurfacePoint) -> Result<Target, Refused> {
        let length = point.normal.norm();
        if !(length.is_finite() && length > 0.0) {
            let rule = "finite and > 0";
            return Err(Refused::NotAPoint { name: "length of the normal", value: length, rule });
        }
        if let Some(value) = point.position_m.iter().find(|value| !value.is_finite()) {
            return Err(Refused::NotAPoint { name: "position_m", value: *value, rule: "finite" });
        }
        let normal = point.normal / length;
        let level = normal.x.hypot(normal.y);
        // A normal along the table's axis has no azimuth: the table stays.
        let upright = level < f64::EPSILON;
        let table_rad = if upright { 0.0 } else { -std::f64::consts::FRAC_PI_2 - normal.y.atan2(normal.x) };
        let tilt_rad = -level.atan2(normal.z);
        if tilt_rad.abs() > self.tilt_max_rad {
            return Err(Refused::Tilt { tilt_rad, limit_rad: self.tilt_max_rad });
        }
        let turned = about_z(table_rad);
        let platform_point_m = turned * point.position_m + Vector3::new(0.0, 0.0, self.part_offset_m);
        let tilted = Pose { position_m: Vector3::zeros(), tilt_rad };
        let position_m = self.tip() - tilted.rotation() * platform_point_m;
        Ok(Target {
            pose: Pose { position_m, tilt_rad },
            table_rad,
            platform_point_m,
            platform_normal: turned * normal,
        })
    }
}
