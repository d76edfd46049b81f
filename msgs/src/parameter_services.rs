//! Services of ROS 2 parameters, package `rcl_interfaces`.

use crate::definition::{Definition, RosService, RosType};
use crate::parameters::{
    ListParametersResult, Parameter, ParameterDescriptor, ParameterValue, SetParametersResult,
};
use serde::{Deserialize, Serialize};

/// Request of [`ListParameters`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ListParametersRequest {
    /// Blocks to look in; none: all.
    pub prefixes: Vec<String>,
    /// Levels of blocks below a prefix; 0: all.
    pub depth: u64,
}

/// Response of [`ListParameters`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ListParametersResponse {
    /// What was found.
    pub result: ListParametersResult,
}

/// Names of the parameters of a node.
#[derive(Debug, Clone, Copy)]
pub struct ListParameters;

impl RosService for ListParameters {
    type Request = ListParametersRequest;
    type Response = ListParametersResponse;
    const PACKAGE: &'static str = "rcl_interfaces";
    const NAME: &'static str = "ListParameters";
    const TEXT: &'static str = include_str!("../standard/rcl_interfaces/ListParameters.srv");
    const DEPENDENCIES: &'static [&'static Definition] = &[&ListParametersResult::DEFINITION];
}

/// Request of [`GetParameters`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct GetParametersRequest {
    /// Parameters.
    pub names: Vec<String>,
}

/// Response of [`GetParameters`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct GetParametersResponse {
    /// Kind 0 for one that is not there.
    pub values: Vec<ParameterValue>,
}

/// Values of parameters, in the order asked.
#[derive(Debug, Clone, Copy)]
pub struct GetParameters;

impl RosService for GetParameters {
    type Request = GetParametersRequest;
    type Response = GetParametersResponse;
    const PACKAGE: &'static str = "rcl_interfaces";
    const NAME: &'static str = "GetParameters";
    const TEXT: &'static str = include_str!("../standard/rcl_interfaces/GetParameters.srv");
    const DEPENDENCIES: &'static [&'static Definition] = &[&ParameterValue::DEFINITION];
}

/// Request of [`GetParameterTypes`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct GetParameterTypesRequest {
    /// Parameters.
    pub names: Vec<String>,
}

/// Response of [`GetParameterTypes`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct GetParameterTypesResponse {
    /// Kinds; 0 for one that is not there.
    pub types: Vec<u8>,
}

/// Types of parameters, in the order asked.
#[derive(Debug, Clone, Copy)]
pub struct GetParameterTypes;

impl RosService for GetParameterTypes {
    type Request = GetParameterTypesRequest;
    type Response = GetParameterTypesResponse;
    const PACKAGE: &'static str = "rcl_interfaces";
    const NAME: &'static str = "GetParameterTypes";
    const TEXT: &'static str = include_str!("../standard/rcl_interfaces/GetParameterTypes.srv");
    const DEPENDENCIES: &'static [&'static Definition] = &[];
}

/// Request of [`DescribeParameters`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DescribeParametersRequest {
    /// Parameters.
    pub names: Vec<String>,
}

/// Response of [`DescribeParameters`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct DescribeParametersResponse {
    /// One each.
    pub descriptors: Vec<ParameterDescriptor>,
}

/// What parameters are for, in the order asked.
#[derive(Debug, Clone, Copy)]
pub struct DescribeParameters;

impl RosService for DescribeParameters {
    type Request = DescribeParametersRequest;
    type Response = DescribeParametersResponse;
    const PACKAGE: &'static str = "rcl_interfaces";
    const NAME: &'static str = "DescribeParameters";
    const TEXT: &'static str = include_str!("../standard/rcl_interfaces/DescribeParameters.srv");
    const DEPENDENCIES: &'static [&'static Definition] = &[&ParameterDescriptor::DEFINITION];
}

/// Request of [`SetParameters`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SetParametersRequest {
    /// Wanted.
    pub parameters: Vec<Parameter>,
}

/// Response of [`SetParameters`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SetParametersResponse {
    /// One each.
    pub results: Vec<SetParametersResult>,
}

/// Sets parameters one by one.
#[derive(Debug, Clone, Copy)]
pub struct SetParameters;

impl RosService for SetParameters {
    type Request = SetParametersRequest;
    type Response = SetParametersResponse;
    const PACKAGE: &'static str = "rcl_interfaces";
    const NAME: &'static str = "SetParameters";
    const TEXT: &'static str = include_str!("../standard/rcl_interfaces/SetParameters.srv");
    const DEPENDENCIES: &'static [&'static Definition] =
        &[&Parameter::DEFINITION, &SetParametersResult::DEFINITION];
}

/// Request of [`SetParametersAtomically`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SetParametersAtomicallyRequest {
    /// Wanted.
    pub parameters: Vec<Parameter>,
}

/// Response of [`SetParametersAtomically`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SetParametersAtomicallyResponse {
    /// Of all.
    pub result: SetParametersResult,
}

/// Sets all parameters or none.
#[derive(Debug, Clone, Copy)]
pub struct SetParametersAtomically;

impl RosService for SetParametersAtomically {
    type Request = SetParametersAtomicallyRequest;
    type Response = SetParametersAtomicallyResponse;
    const PACKAGE: &'static str = "rcl_interfaces";
    const NAME: &'static str = "SetParametersAtomically";
    const TEXT: &'static str = include_str!("../standard/rcl_interfaces/SetParametersAtomically.srv");
    const DEPENDENCIES: &'static [&'static Definition] =
        &[&Parameter::DEFINITION, &SetParametersResult::DEFINITION];
}
