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
    /// ] Filament length per count `[m]`. Range `(0, inf)`.
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
    /// stamp [s]: time of exposure on the node's clock
    pub header: Header,
    /// Measured width `[m]`. Range `[0, inf)`.
    pub width_m: f64,
    /// ] Standard deviation of the measurement `[m]`. Range `(0, inf)`.
    pub sigma_m: f64,
    /// Where the measurement comes from; 'stand-in' until it is made from camera frames.
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
