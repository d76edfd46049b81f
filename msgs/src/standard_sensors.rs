//! The standard messages of cameras and inertial units; `standard/` holds the definitions.

use crate::definition::{Definition, RosType};
use crate::standard::Header;
use serde::{Deserialize, Serialize};

/// A vector in free space.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Vector3 {
    /// [unit of its use].
    pub x: f64,
    /// [unit of its use].
    pub y: f64,
    /// [unit of its use].
    pub z: f64,
}

impl RosType for Vector3 {
    const DEFINITION: Definition = Definition {
        package: "geometry_msgs",
        name: "Vector3",
        text: include_str!("../standard/geometry_msgs/Vector3.msg"),
        dependencies: &[],
    };
}

/// An orientation.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Quaternion {
    /// [-].
    pub x: f64,
    /// [-].
    pub y: f64,
    /// [-].
    pub z: f64,
    /// [-].
    pub w: f64,
}

impl RosType for Quaternion {
    const DEFINITION: Definition = Definition {
        package: "geometry_msgs",
        name: "Quaternion",
        text: include_str!("../standard/geometry_msgs/Quaternion.msg"),
        dependencies: &[],
    };
}

/// One reading of an inertial measurement unit (REP 145). A covariance that begins with -1 marks what is not measured.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Imu {
    /// Time and frame of the reading.
    pub header: Header,
    /// Orientation.
    pub orientation: Quaternion,
    /// Row-major about x, y, z `[rad2]`.
    pub orientation_covariance: [f64; 9],
    /// Angular velocity `[rad/s]`.
    pub angular_velocity: Vector3,
    /// Row-major about x, y, z `[rad2/s2]`.
    pub angular_velocity_covariance: [f64; 9],
    /// Acceleration, gravity included `[m/s2]`.
    pub linear_acceleration: Vector3,
    /// Row-major x, y, z `[m2/s4]`.
    pub linear_acceleration_covariance: [f64; 9],
}

impl RosType for Imu {
    const DEFINITION: Definition = Definition {
        package: "sensor_msgs",
        name: "Imu",
        text: include_str!("../standard/sensor_msgs/Imu.msg"),
        dependencies: &[&Header::DEFINITION, &Quaternion::DEFINITION, &Vector3::DEFINITION],
    };
}

/// A compressed picture.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CompressedImage {
    /// Time of exposure and optical frame.
    pub header: Header,
    /// As 'mono8; jpeg compressed mono8'.
    pub format: String,
    /// The compressed picture.
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}

impl RosType for CompressedImage {
    const DEFINITION: Definition = Definition {
        package: "sensor_msgs",
        name: "CompressedImage",
        text: include_str!("../standard/sensor_msgs/CompressedImage.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// A part of a picture.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RegionOfInterest {
    /// Leftmost column `[px]`.
    pub x_offset: u32,
    /// Topmost row `[px]`.
    pub y_offset: u32,
    /// Rows; 0 with width 0: the whole picture `[px]`.
    pub height: u32,
    /// Columns `[px]`.
    pub width: u32,
    /// The part is to be rectified.
    pub do_rectify: bool,
}

impl RosType for RegionOfInterest {
    const DEFINITION: Definition = Definition {
        package: "sensor_msgs",
        name: "RegionOfInterest",
        text: include_str!("../standard/sensor_msgs/RegionOfInterest.msg"),
        dependencies: &[],
    };
}

/// Calibration of a camera.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct CameraInfo {
    /// Time of exposure and optical frame.
    pub header: Header,
    /// Rows `[px]`.
    pub height: u32,
    /// Columns `[px]`.
    pub width: u32,
    /// As 'plumb_bob'.
    pub distortion_model: String,
    /// Distortion coefficients.
    pub d: Vec<f64>,
    /// Row-major intrinsic matrix `[px]`.
    pub k: [f64; 9],
    /// Row-major rectification.
    pub r: [f64; 9],
    /// Row-major projection `[px]`.
    pub p: [f64; 12],
    /// Pixels joined along a row.
    pub binning_x: u32,
    /// Pixels joined along a column.
    pub binning_y: u32,
    /// Part of the sensor in use `[px]`.
    pub roi: RegionOfInterest,
}

impl RosType for CameraInfo {
    const DEFINITION: Definition = Definition {
        package: "sensor_msgs",
        name: "CameraInfo",
        text: include_str!("../standard/sensor_msgs/CameraInfo.msg"),
        dependencies: &[&Header::DEFINITION, &RegionOfInterest::DEFINITION],
    };
}
