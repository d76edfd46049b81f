//! Raw reports and readings. The definitions in `msg/` and `srv/` are the truth.

use crate::definition::{Definition, RosType};
use crate::standard::Header;
use serde::{Deserialize, Serialize};

/// Raw temperatures as the firmware reports them, unchecked (topic printer/report/temperature).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TemperatureReport {
    /// stamp [s]: time of the reading on the node's clock
    pub header: Header,
    /// Hot end thermistor, as reported; a broken one reads far outside of any print `[degC]`.
    pub hotend_degc: f64,
    /// Bed thermistor, as reported `[degC]`.
    pub bed_degc: f64,
    /// Sensor in the nozzle, as reported; NaN where none is fitted `[degC]`.
    pub nozzle_degc: f64,
}

impl RosType for TemperatureReport {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "TemperatureReport",
        text: include_str!("../msg/TemperatureReport.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// Raw counts of the filament encoder (topic printer/report/filament).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FilamentReport {
    /// stamp [s]: time of the reading on the node's clock
    pub header: Header,
    /// Counts since start; negative after a net retraction.
    pub counts: i64,
    /// Filament length per count `[m]`. Range `(0, inf)`.
    pub quantum_m: f64,
}

impl RosType for FilamentReport {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "FilamentReport",
        text: include_str!("../msg/FilamentReport.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// Filament position and speed as measured by the encoder (topic sensors/filament/motion).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FilamentMotion {
    /// stamp [s]: time of the reading on the node's clock
    pub header: Header,
    /// Filament that passed the encoder since start `[m]`.
    pub position_m: f64,
    /// Filament speed over the last readings `[m/s]`.
    pub speed_m_s: f64,
}

impl RosType for FilamentMotion {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "FilamentMotion",
        text: include_str!("../msg/FilamentMotion.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// Width of the deposited road as seen by a camera, late by exposure and processing (topic
/// vision/bead_width).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct BeadWidth {
    /// stamp [s]: time at which the measured stretch was laid, on the node's clock
    pub header: Header,
    /// Measured width `[m]`. Range `[0, inf)`.
    pub width_m: f64,
    /// Standard deviation of the measurement `[m]`. Range `(0, inf)`.
    pub sigma_m: f64,
    /// Where the measurement comes from: `camera`, or `stand-in` where the simulator gives it.
    pub source: String,
}

impl RosType for BeadWidth {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "BeadWidth",
        text: include_str!("../msg/BeadWidth.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// Accelerations since the last batch, evenly spaced (topics printer/report/imu, raw, and sensors/imu/batch, checked).
/// At rest and upright the z axis reads +9.81 m/s2 (REP 145).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ImuBatch {
    /// stamp [s]: time of the first sample on the node's clock; frame_id: the sensor's frame.
    pub header: Header,
    /// Number of the first sample since start; a step in it shows lost samples.
    pub first_sequence: u64,
    /// Time between two samples `[s]`. Range `(0, 1]`.
    pub period_s: f64,
    /// Largest magnitude an axis can show `[m/s2]`. Range `(0, inf)`.
    pub range_m_s2: f64,
    /// Samples of this batch with an axis at its range.
    pub saturated: u32,
    /// Acceleration along x, one per sample `[m/s2]`.
    pub x_m_s2: Vec<f64>,
    /// Acceleration along y, one per sample `[m/s2]`.
    pub y_m_s2: Vec<f64>,
    /// Acceleration along z, gravity included, one per sample `[m/s2]`.
    pub z_m_s2: Vec<f64>,
}

impl RosType for ImuBatch {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "ImuBatch",
        text: include_str!("../msg/ImuBatch.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}
