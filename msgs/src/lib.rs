//! Messages and services of `fdm_loop` as Rust types, and the standard ones it uses.
//!
//! The files in `msg/`, `srv/` and `standard/` are the truth; `tests/idl_conformance.rs` compares order, names and
//! types of their fields with the structs here. CDR carries no names: a swapped field would be read as its neighbour.
//!
//! Stamps are on the node's clock: monotonic seconds since the host's start in operation (one for all processes of
//! the host), simulated seconds under `use_sim_time`.
#![forbid(unsafe_code)]

mod advance;
mod control;
mod definition;
mod estimate;
mod lifecycle;
mod lifecycle_services;
mod parameter_services;
mod parameters;
mod printer;
mod quality;
mod safety;
mod sensors;
mod sim;
mod standard;
mod standard_sensors;
mod time;
mod transforms;

pub use advance::AdvancePrediction;
pub use control::{ControlCommand, MotionTrim};
pub use definition::{Definition, RosService, RosType};
pub use estimate::StateEstimate;
pub use lifecycle::{State, Transition, TransitionDescription, TransitionEvent};
pub use lifecycle_services::{
    ChangeState, ChangeStateRequest, ChangeStateResponse, GetAvailableStates, GetAvailableStatesRequest,
    GetAvailableStatesResponse, GetAvailableTransitions, GetAvailableTransitionsRequest,
    GetAvailableTransitionsResponse, GetState, GetStateRequest, GetStateResponse,
};
pub use parameter_services::{
    DescribeParameters, DescribeParametersRequest, DescribeParametersResponse, GetParameterTypes,
    GetParameterTypesRequest, GetParameterTypesResponse, GetParameters, GetParametersRequest,
    GetParametersResponse, ListParameters, ListParametersRequest, ListParametersResponse, SetParameters,
    SetParametersAtomically, SetParametersAtomicallyRequest, SetParametersAtomicallyResponse,
    SetParametersRequest, SetParametersResponse,
};
pub use parameters::{
    FloatingPointRange, IntegerRange, ListParametersResult, Parameter, ParameterDescriptor, ParameterEvent,
    ParameterValue, SetParametersResult,
};
pub use printer::{MotionSegment, PrintInfo, PrinterState};
pub use quality::{DefectReport, LayerHeight, LayerQuality};
pub use safety::{Heartbeat, PrintEvent, SafetyState, SetMode, SetModeRequest, SetModeResponse};
pub use sensors::{BeadWidth, FilamentMotion, FilamentReport, ImuBatch, TemperatureReport};
pub use sim::{InjectFault, InjectFaultRequest, InjectFaultResponse, SimTruth, SimWire};
pub use standard::{
    Clock, DiagnosticArray, DiagnosticStatus, Header, KeyValue, Log, Temperature, Time, Trigger,
    TriggerRequest, TriggerResponse,
};
pub use standard_sensors::{CameraInfo, CompressedImage, Imu, Quaternion, RegionOfInterest, Vector3};
pub use transforms::{TFMessage, Transform, TransformStamped};
