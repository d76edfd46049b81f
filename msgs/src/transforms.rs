//! Places of frames, packages `geometry_msgs` and `tf2_msgs`.

use crate::definition::{Definition, RosType};
use crate::standard::{Header, Time};
use crate::standard_sensors::{Quaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Place of a frame in another.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Transform {
    /// Its origin `[m]`.
    pub translation: Vector3,
    /// Its axes.
    pub rotation: Quaternion,
}

impl RosType for Transform {
    const DEFINITION: Definition = Definition {
        package: "geometry_msgs",
        name: "Transform",
        text: include_str!("../standard/geometry_msgs/Transform.msg"),
        dependencies: &[&Vector3::DEFINITION, &Quaternion::DEFINITION],
    };
}

/// Place of a frame in another at a time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TransformStamped {
    /// Time, and the frame above.
    pub header: Header,
    /// The frame.
    pub child_frame_id: String,
    /// Its place in the frame above.
    pub transform: Transform,
}

impl RosType for TransformStamped {
    const DEFINITION: Definition = Definition {
        package: "geometry_msgs",
        name: "TransformStamped",
        text: include_str!("../standard/geometry_msgs/TransformStamped.msg"),
        dependencies: &[&Header::DEFINITION, &Transform::DEFINITION],
    };
}

/// Places of frames in others.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TFMessage {
    /// One a frame.
    pub transforms: Vec<TransformStamped>,
}

impl RosType for TFMessage {
    const DEFINITION: Definition = Definition {
        package: "tf2_msgs",
        name: "TFMessage",
        text: include_str!("../standard/tf2_msgs/TFMessage.msg"),
        dependencies: &[
            &TransformStamped::DEFINITION,
            &Header::DEFINITION,
            &Time::DEFINITION,
            &Transform::DEFINITION,
            &Vector3::DEFINITION,
            &Quaternion::DEFINITION,
        ],
    };
}
