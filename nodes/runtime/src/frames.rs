//! The parts of a printer as a tree of frames: `/tf_static` for what hangs together, `/tf` for the tool over the bed.
//!
//! ```text
//! printer - bed ~ toolhead - nozzle, camera_optical, imu        - fixed, ~ moves
//! ```

use crate::error::RuntimeError;
use crate::names::DEFAULT_NAMESPACE;
use crate::node::Node;
use crate::publisher::Publisher;
use crate::topics;
use fdm_loop_msgs::{Header, Quaternion, TFMessage, Transform, TransformStamped, Vector3};
use models::params::{ParamError, in_range};
use models::units::Seconds;
use serde::Deserialize;
use std::collections::BTreeMap;
use tree::FrameError;

mod tree;

/// What the tool moves over, and the tool.
const BED: &str = "bed";
const TOOL: &str = "toolhead";
/// Least time between two places of the tool `[s]`: 10 Hz.
const TOOL_PERIOD_S: f64 = 0.1;

/// Fixed places of a printer's parts, a tree with the tool over the bed: the block `frames`. Built only from a valid
/// [`RawFrames`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawFrames")]
pub struct FrameParams {
    prefix: String,
    parts: BTreeMap<String, Part>,
}

/// The block as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawFrames {
    /// In front of each name: one a printer where several share a domain. Where it is empty, see [`Node::frames`].
    pub prefix: String,
    /// Parts by name.
    pub parts: BTreeMap<String, Part>,
}

/// A part's place in the part that it hangs on.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawPart")]
pub struct Part {
    parent: String,
    xyz_m: [f64; 3],
    rpy_rad: [f64; 3],
}

/// A part as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawPart {
    /// Part that it hangs on.
    pub parent: String,
    /// Its origin there `[m]`. Range `[-10, 10]`.
    pub xyz_m: [f64; 3],
    /// Its axes: roll, pitch and yaw about fixed axes, REP 103 `[rad]`. Range `[-6.3, 6.3]`.
    pub rpy_rad: [f64; 3],
}

impl TryFrom<RawPart> for Part {
    type Error = ParamError;

    fn try_from(raw: RawPart) -> Result<Self, ParamError> {
        for length_m in raw.xyz_m {
            in_range("xyz_m", length_m, "m", (-10.0, 10.0))?;
        }
        for angle_rad in raw.rpy_rad {
            in_range("rpy_rad", angle_rad, "rad", (-6.3, 6.3))?;
        }
        Ok(Self { parent: raw.parent, xyz_m: raw.xyz_m, rpy_rad: raw.rpy_rad })
    }
}

impl TryFrom<RawFrames> for FrameParams {
    type Error = FrameError;

    fn try_from(raw: RawFrames) -> Result<Self, FrameError> {
        tree::check(&raw)?;
        Ok(Self { prefix: raw.prefix, parts: raw.parts })
    }
}

/// Tells where the parts are.
#[derive(Debug)]
pub struct Frames {
    params: FrameParams,
    // Latched: kept alive for late joiners.
    fixed: Publisher<TFMessage>,
    moving: Publisher<TFMessage>,
    told: Seconds,
}

impl Node {
    /// Prepares to tell where the parts of the printer are. All printers share one tree: in another namespace than
    /// `/printer` parts without a prefix have the namespace's.
    ///
    /// # Errors
    /// As [`Node::publish_on`].
    pub fn frames(&mut self, mut params: FrameParams) -> Result<Frames, RuntimeError> {
        if params.prefix.is_empty() {
            params.prefix = prefix_of(&self.name());
        }
        let (fixed, moving) = (self.publish_on(&topics::TF_STATIC)?, self.publish_on(&topics::TF)?);
        Ok(Frames { params, fixed, moving, told: Seconds(f64::NEG_INFINITY) })
    }
}

/// Prefix of the frames of a printer, by the name of one of its nodes: `left/` of `/left/printer_sim`.
fn prefix_of(node: &str) -> String {
    match node.rsplit_once('/') {
        Some((DEFAULT_NAMESPACE | "", _)) | None => String::new(),
        Some((namespace, _)) => format!("{}/", namespace.trim_start_matches('/')),
    }
}

impl Frames {
    /// Tells the fixed places.
    pub fn tell(&self, now: Seconds) {
        let place = |(name, part): (&String, &Part)| {
            self.transform(now, (&part.parent, name), (part.xyz_m, quaternion(part.rpy_rad)))
        };
        self.fixed.send(TFMessage { transforms: self.params.parts.iter().map(place).collect() });
    }

    /// Tells where the tool is over the bed, ten times a second at most.
    pub fn tool_at(&mut self, now: Seconds, position_m: [f64; 3]) {
        if (0.0..TOOL_PERIOD_S).contains(&(now - self.told).0) {
            return;
        }
        self.told = now;
        let place = self.transform(now, (BED, TOOL), (position_m, quaternion([0.0; 3])));
        self.moving.send(TFMessage { transforms: vec![place] });
    }

    fn transform(
        &self,
        now: Seconds,
        (parent, child): (&str, &str),
        ([x, y, z], rotation): ([f64; 3], Quaternion),
    ) -> TransformStamped {
        let prefix = &self.params.prefix;
        TransformStamped {
            header: Header { frame_id: format!("{prefix}{parent}"), ..Header::at(now.0) },
            child_frame_id: format!("{prefix}{child}"),
            transform: Transform { translation: Vector3 { x, y, z }, rotation },
        }
    }
}

/// Roll, pitch and yaw about fixed axes: `q = q_z(yaw) q_y(pitch) q_x(roll)` (Diebel 2006, eq. 290).
fn quaternion([roll, pitch, yaw]: [f64; 3]) -> Quaternion {
    let half = |angle: f64| (0.5 * angle).sin_cos();
    let ((sr, cr), (sp, cp), (sy, cy)) = (half(roll), half(pitch), half(yaw));
    Quaternion {
        x: sr * cp * cy - cr * sp * sy,
        y: cr * sp * cy + sr * cp * sy,
        z: cr * cp * sy - sr * sp * cy,
        w: cr * cp * cy + sr * sp * sy,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    /// v' = v + 2 w (q x v) + 2 q x (q x v)
    fn turned(by: &Quaternion, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let q = [by.x, by.y, by.z];
        let once = cross(q, [x, y, z]);
        let twice = cross(q, once);
        [0, 1, 2].map(|i| [x, y, z][i] + 2.0 * (by.w * once[i] + twice[i]))
    }

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    /// A camera that looks down: its z is the bed's -z, its x the bed's x (REP 103, suffix `_optical`).
    #[test]
    fn a_camera_that_is_turned_over_looks_down() {
        let down = quaternion([PI, 0.0, 0.0]);
        assert!(near(turned(&down, [0.0, 0.0, 1.0]), [0.0, 0.0, -1.0]));
        assert!(near(turned(&down, [1.0, 0.0, 0.0]), [1.0, 0.0, 0.0]));
    }

    #[test]
    fn two_printers_have_frames_of_their_own() {
        let prefix =
            ["/printer/printer_sim", "/printer_sim", "/left/printer_sim", "/hall/left/printer_bridge"];
        assert_eq!(prefix.map(prefix_of), ["", "", "left/", "hall/left/"]);
    }

    /// Roll first, then pitch, then yaw, about axes that stay: x goes to y by yaw alone; with pitch before it, down.
    #[test]
    fn angles_turn_about_fixed_axes_in_order() {
        let both = quaternion([FRAC_PI_2, 0.0, FRAC_PI_2]);
        assert!(near(turned(&both, [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]), "roll took y up, yaw leaves up alone");
        assert!(near(turned(&both, [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]));
    }
}
