//! The standard messages in use, with the fields of their packages; `standard/` holds the definitions.

use crate::definition::{Definition, RosService, RosType};
use serde::{Deserialize, Serialize};

/// Point in time as seconds and nanoseconds since the clock's epoch.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Time {
    /// Whole seconds `[s]`.
    pub sec: i32,
    /// Rest `[ns]`. Range `[0, 999999999]`.
    pub nanosec: u32,
}

impl RosType for Time {
    const DEFINITION: Definition = Definition {
        package: "builtin_interfaces",
        name: "Time",
        text: include_str!("../standard/builtin_interfaces/Time.msg"),
        dependencies: &[],
    };
}

/// Stamp and frame of data.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Header {
    /// Time the data counts for `[s]`.
    pub stamp: Time,
    /// Frame the data is given in.
    pub frame_id: String,
}

impl RosType for Header {
    const DEFINITION: Definition = Definition {
        package: "std_msgs",
        name: "Header",
        text: include_str!("../standard/std_msgs/Header.msg"),
        dependencies: &[&Time::DEFINITION],
    };
}

/// One temperature reading.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Temperature {
    /// Time and place of the reading
    pub header: Header,
    /// Reading `[degC]`.
    pub temperature: f64,
    /// Variance; 0 means unknown `[K2]`. Range `[0, inf)`.
    pub variance: f64,
}

impl RosType for Temperature {
    const DEFINITION: Definition = Definition {
        package: "sensor_msgs",
        name: "Temperature",
        text: include_str!("../standard/sensor_msgs/Temperature.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// One named value of a status.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct KeyValue {
    /// Name.
    pub key: String,
    /// Value as text.
    pub value: String,
}

impl RosType for KeyValue {
    const DEFINITION: Definition = Definition {
        package: "diagnostic_msgs",
        name: "KeyValue",
        text: include_str!("../standard/diagnostic_msgs/KeyValue.msg"),
        dependencies: &[],
    };
}

/// Status of one component.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    /// One of the levels above. Range `[0, 3]`.
    pub level: u8,
    /// Component that reports.
    pub name: String,
    /// What is the matter.
    pub message: String,
    /// Hardware it belongs to.
    pub hardware_id: String,
    /// Named values
    pub values: Vec<KeyValue>,
}

impl DiagnosticStatus {
    /// `OK` of the definition.
    pub const OK: u8 = 0;
    /// `WARN` of the definition.
    pub const WARN: u8 = 1;
    /// `ERROR` of the definition.
    pub const ERROR: u8 = 2;
    /// `STALE` of the definition.
    pub const STALE: u8 = 3;
}

impl RosType for DiagnosticStatus {
    const DEFINITION: Definition = Definition {
        package: "diagnostic_msgs",
        name: "DiagnosticStatus",
        text: include_str!("../standard/diagnostic_msgs/DiagnosticStatus.msg"),
        dependencies: &[&KeyValue::DEFINITION],
    };
}

/// Statuses of the components of a robot.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DiagnosticArray {
    /// Time of the report
    pub header: Header,
    /// One per component
    pub status: Vec<DiagnosticStatus>,
}

impl RosType for DiagnosticArray {
    const DEFINITION: Definition = Definition {
        package: "diagnostic_msgs",
        name: "DiagnosticArray",
        text: include_str!("../standard/diagnostic_msgs/DiagnosticArray.msg"),
        dependencies: &[&Header::DEFINITION, &DiagnosticStatus::DEFINITION],
    };
}

/// Simulated time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Clock {
    /// Time now `[s]`.
    pub clock: Time,
}

impl RosType for Clock {
    const DEFINITION: Definition = Definition {
        package: "rosgraph_msgs",
        name: "Clock",
        text: include_str!("../standard/rosgraph_msgs/Clock.msg"),
        dependencies: &[&Time::DEFINITION],
    };
}

/// One line of a log.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Log {
    /// Time of the line `[s]`.
    pub stamp: Time,
    /// One of the levels above.
    pub level: u8,
    /// Logger.
    pub name: String,
    /// Text.
    pub msg: String,
    /// Source file.
    pub file: String,
    /// Source function.
    pub function: String,
    /// Source line.
    pub line: u32,
}

impl Log {
    /// `DEBUG` of the definition.
    pub const DEBUG: u8 = 10;
    /// `INFO` of the definition.
    pub const INFO: u8 = 20;
    /// `WARN` of the definition.
    pub const WARN: u8 = 30;
    /// `ERROR` of the definition.
    pub const ERROR: u8 = 40;
    /// `FATAL` of the definition.
    pub const FATAL: u8 = 50;
}

impl RosType for Log {
    const DEFINITION: Definition = Definition {
        package: "rcl_interfaces",
        name: "Log",
        text: include_str!("../standard/rcl_interfaces/Log.msg"),
        dependencies: &[&Time::DEFINITION],
    };
}

/// Triggers an action that needs no argument: the request.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TriggerRequest {
    /// An empty structure is one byte on the wire.
    pub structure_needs_at_least_one_member: u8,
}

/// Answer of [`Trigger`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TriggerResponse {
    /// Whether it was done.
    pub success: bool,
    /// What was done, or why not.
    pub message: String,
}

/// Triggers an action that needs no argument.
#[derive(Debug, Clone, Copy)]
pub struct Trigger;

impl RosService for Trigger {
    type Request = TriggerRequest;
    type Response = TriggerResponse;
    const PACKAGE: &'static str = "std_srvs";
    const NAME: &'static str = "Trigger";
    const TEXT: &'static str = include_str!("../standard/std_srvs/Trigger.srv");
}
