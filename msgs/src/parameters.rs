//! Messages of ROS 2 parameters, package `rcl_interfaces`.

use crate::definition::{Definition, RosType};
use crate::standard::Time;
use serde::{Deserialize, Serialize};

/// A value of one of several types; `kind` says which field counts.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ParameterValue {
    /// One of the constants (field `type` of the definition).
    #[serde(rename = "type")]
    pub kind: u8,
    /// Where the kind is `BOOL`.
    pub bool_value: bool,
    /// Where the kind is `INTEGER`.
    pub integer_value: i64,
    /// Where the kind is `DOUBLE`.
    pub double_value: f64,
    /// Where the kind is `STRING`.
    pub string_value: String,
    /// Where the kind is `BYTE_ARRAY`.
    pub byte_array_value: Vec<u8>,
    /// Where the kind is `BOOL_ARRAY`.
    pub bool_array_value: Vec<bool>,
    /// Where the kind is `INTEGER_ARRAY`.
    pub integer_array_value: Vec<i64>,
    /// Where the kind is `DOUBLE_ARRAY`.
    pub double_array_value: Vec<f64>,
    /// Where the kind is `STRING_ARRAY`.
    pub string_array_value: Vec<String>,
}

impl ParameterValue {
    /// `PARAMETER_NOT_SET` of `ParameterType`.
    pub const NOT_SET: u8 = 0;
    /// `PARAMETER_BOOL` of `ParameterType`.
    pub const BOOL: u8 = 1;
    /// `PARAMETER_INTEGER` of `ParameterType`.
    pub const INTEGER: u8 = 2;
    /// `PARAMETER_DOUBLE` of `ParameterType`.
    pub const DOUBLE: u8 = 3;
    /// `PARAMETER_STRING` of `ParameterType`.
    pub const STRING: u8 = 4;
    /// `PARAMETER_BYTE_ARRAY` of `ParameterType`.
    pub const BYTE_ARRAY: u8 = 5;
    /// `PARAMETER_BOOL_ARRAY` of `ParameterType`.
    pub const BOOL_ARRAY: u8 = 6;
    /// `PARAMETER_INTEGER_ARRAY` of `ParameterType`.
    pub const INTEGER_ARRAY: u8 = 7;
    /// `PARAMETER_DOUBLE_ARRAY` of `ParameterType`.
    pub const DOUBLE_ARRAY: u8 = 8;
    /// `PARAMETER_STRING_ARRAY` of `ParameterType`.
    pub const STRING_ARRAY: u8 = 9;
}

impl RosType for ParameterValue {
    const DEFINITION: Definition = Definition {
        package: "rcl_interfaces",
        name: "ParameterValue",
        text: include_str!("../standard/rcl_interfaces/ParameterValue.msg"),
        dependencies: &[],
    };
}

/// A parameter and its value.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Parameter {
    /// Dotted name.
    pub name: String,
    /// Its value.
    pub value: ParameterValue,
}

impl RosType for Parameter {
    const DEFINITION: Definition = Definition {
        package: "rcl_interfaces",
        name: "Parameter",
        text: include_str!("../standard/rcl_interfaces/Parameter.msg"),
        dependencies: &[&ParameterValue::DEFINITION],
    };
}

/// Bounds of a number.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FloatingPointRange {
    /// Least value that is allowed.
    pub from_value: f64,
    /// Greatest value that is allowed.
    pub to_value: f64,
    /// Distance of allowed values; 0 for any.
    pub step: f64,
}

impl RosType for FloatingPointRange {
    const DEFINITION: Definition = Definition {
        package: "rcl_interfaces",
        name: "FloatingPointRange",
        text: include_str!("../standard/rcl_interfaces/FloatingPointRange.msg"),
        dependencies: &[],
    };
}

/// Bounds of a whole number.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct IntegerRange {
    /// Least value that is allowed.
    pub from_value: i64,
    /// Greatest value that is allowed.
    pub to_value: i64,
    /// Distance of allowed values; 0 or 1 for any.
    pub step: u64,
}

impl RosType for IntegerRange {
    const DEFINITION: Definition = Definition {
        package: "rcl_interfaces",
        name: "IntegerRange",
        text: include_str!("../standard/rcl_interfaces/IntegerRange.msg"),
        dependencies: &[],
    };
}

/// What a parameter is for and what it may be.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ParameterDescriptor {
    /// Dotted name.
    pub name: String,
    /// As [`ParameterValue::kind`] (field `type` of the definition).
    #[serde(rename = "type")]
    pub kind: u8,
    /// What it is for.
    pub description: String,
    /// Rules beside the ranges.
    pub additional_constraints: String,
    /// It cannot be set while the node runs.
    pub read_only: bool,
    /// Its type may change.
    pub dynamic_typing: bool,
    /// Bounds, at most one entry.
    pub floating_point_range: Vec<FloatingPointRange>,
    /// Bounds, at most one entry.
    pub integer_range: Vec<IntegerRange>,
}

impl RosType for ParameterDescriptor {
    const DEFINITION: Definition = Definition {
        package: "rcl_interfaces",
        name: "ParameterDescriptor",
        text: include_str!("../standard/rcl_interfaces/ParameterDescriptor.msg"),
        dependencies: &[&FloatingPointRange::DEFINITION, &IntegerRange::DEFINITION],
    };
}

/// Names that were found.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ListParametersResult {
    /// Parameters.
    pub names: Vec<String>,
    /// Blocks.
    pub prefixes: Vec<String>,
}

impl RosType for ListParametersResult {
    const DEFINITION: Definition = Definition {
        package: "rcl_interfaces",
        name: "ListParametersResult",
        text: include_str!("../standard/rcl_interfaces/ListParametersResult.msg"),
        dependencies: &[],
    };
}

/// Whether a parameter was set.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SetParametersResult {
    /// It was.
    pub successful: bool,
    /// Why not.
    pub reason: String,
}

impl RosType for SetParametersResult {
    const DEFINITION: Definition = Definition {
        package: "rcl_interfaces",
        name: "SetParametersResult",
        text: include_str!("../standard/rcl_interfaces/SetParametersResult.msg"),
        dependencies: &[],
    };
}

/// Parameters of a node that came, changed or went.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ParameterEvent {
    /// When `[s]`.
    pub stamp: Time,
    /// Name of the node with its namespace.
    pub node: String,
    /// Came.
    pub new_parameters: Vec<Parameter>,
    /// Changed.
    pub changed_parameters: Vec<Parameter>,
    /// Went.
    pub deleted_parameters: Vec<Parameter>,
}

impl RosType for ParameterEvent {
    const DEFINITION: Definition = Definition {
        package: "rcl_interfaces",
        name: "ParameterEvent",
        text: include_str!("../standard/rcl_interfaces/ParameterEvent.msg"),
        dependencies: &[&Time::DEFINITION, &Parameter::DEFINITION],
    };
}
