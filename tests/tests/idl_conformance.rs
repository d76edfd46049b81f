//! The `.msg` and `.srv` files against the Rust structs: CDR carries no names, so a swapped or mistyped field would be
//! read as its neighbour. Both sides are flattened to (path, primitive type) in order and must be equal.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // helpers of tests

#[path = "idl_conformance/definition.rs"]
mod definition;
#[path = "idl_conformance/tracer.rs"]
mod tracer;

use definition::{fields_of, flatten};
use fdm_loop_msgs::{
    AdvancePrediction, BeadWidth, CameraInfo, ChangeState, Clock, CompressedImage, ControlCommand,
    DefectReport, DescribeParameters, DiagnosticArray, FilamentMotion, FilamentReport, GetAvailableStates,
    GetAvailableTransitions, GetParameterTypes, GetParameters, GetState, Heartbeat, Imu, ImuBatch,
    InjectFault, LayerHeight, LayerQuality, ListParameters, Log, MotionSegment, MotionTrim, ParameterEvent,
    PrintEvent, PrintInfo, PrinterState, RosService, RosType, SafetyState, SetMode, SetParameters,
    SetParametersAtomically, SimTruth, SimWire, StateEstimate, TFMessage, Temperature, TemperatureReport,
    TransitionEvent, Trigger,
};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use tracer::trace;

/// A flattened structure.
type Fields = Vec<(String, String)>;

/// Both flattened sides of a message, and its name.
fn message<T: RosType>() -> (String, Fields, Fields) {
    let definition = T::DEFINITION;
    (definition.full_name(), flatten(definition.text, &definition), trace::<T>())
}

fn messages() -> Vec<(String, Fields, Fields)> {
    vec![
        message::<AdvancePrediction>(),
        message::<BeadWidth>(),
        message::<ControlCommand>(),
        message::<DefectReport>(),
        message::<FilamentMotion>(),
        message::<FilamentReport>(),
        message::<Heartbeat>(),
        message::<ImuBatch>(),
        message::<LayerHeight>(),
        message::<LayerQuality>(),
        message::<MotionSegment>(),
        message::<MotionTrim>(),
        message::<PrintEvent>(),
        message::<PrintInfo>(),
        message::<PrinterState>(),
        message::<SafetyState>(),
        message::<SimTruth>(),
        message::<SimWire>(),
        message::<StateEstimate>(),
        message::<TemperatureReport>(),
        message::<Temperature>(),
        message::<CameraInfo>(),
        message::<CompressedImage>(),
        message::<Imu>(),
        message::<DiagnosticArray>(),
        message::<Clock>(),
        message::<Log>(),
        message::<ParameterEvent>(),
        message::<TFMessage>(),
        message::<TransitionEvent>(),
    ]
}

/// Flattened request and response of a service.
fn service<S: RosService>() -> (&'static str, [(Fields, Fields); 2]) {
    let (request, response) = S::TEXT.split_once("---\n").expect("a service has two parts");
    let flat = |text: &str| {
        let fields = definition::flatten_part(text, S::DEPENDENCIES);
        // An empty structure is one byte on the wire.
        let byte = || vec![("structure_needs_at_least_one_member".to_owned(), "u8".to_owned())];
        if fields.is_empty() { byte() } else { fields }
    };
    (S::NAME, [(flat(request), trace::<S::Request>()), (flat(response), trace::<S::Response>())])
}

#[test]
fn every_struct_has_the_fields_of_its_definition_in_order() {
    for (name, defined, traced) in messages() {
        assert_eq!(traced, defined, "{name}");
    }
}

#[test]
fn every_service_has_the_fields_of_its_definition_in_order() {
    let services = [
        service::<InjectFault>(),
        service::<SetMode>(),
        service::<Trigger>(),
        service::<ListParameters>(),
        service::<GetParameters>(),
        service::<GetParameterTypes>(),
        service::<DescribeParameters>(),
        service::<SetParameters>(),
        service::<SetParametersAtomically>(),
        service::<ChangeState>(),
        service::<GetState>(),
        service::<GetAvailableStates>(),
        service::<GetAvailableTransitions>(),
    ];
    for (name, parts) in services {
        for (defined, traced) in parts {
            assert_eq!(traced, defined, "{name}");
        }
    }
}

/// The comparison can fail: a swapped pair and a narrower type are seen.
#[test]
fn a_swapped_or_narrowed_field_is_seen() {
    let text = FilamentReport::DEFINITION.text;
    let swapped =
        text.replace("counts  ", "swap  ").replace("quantum_m", "counts").replace("swap", "quantum_m");
    let narrowed = text.replace("int64 counts", "int32 counts");
    for changed in [swapped, narrowed] {
        assert_ne!(changed, text);
        assert_ne!(flatten(&changed, &FilamentReport::DEFINITION), trace::<FilamentReport>());
    }
}

fn package() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../msgs")
}

/// Files of a folder of the interface package, as `folder/name`.
fn files(folder: &str) -> BTreeSet<String> {
    let entries = std::fs::read_dir(package().join(folder)).unwrap();
    entries.map(|entry| format!("{folder}/{}", entry.unwrap().file_name().to_string_lossy())).collect()
}

/// Definitions of our own: all are compared above, all are built by colcon.
#[test]
fn no_definition_is_forgotten() {
    let compared: BTreeSet<String> = messages()
        .iter()
        .filter_map(|(name, ..)| name.strip_prefix("fdm_loop_msgs/"))
        .map(|name| format!("{name}.msg"))
        .collect();
    assert_eq!(files("msg"), compared);
    let cmake = std::fs::read_to_string(package().join("CMakeLists.txt")).unwrap();
    for file in files("msg").iter().chain(&files("srv")) {
        assert!(cmake.contains(&format!("\"{file}\"")), "{file} is missing in CMakeLists.txt");
    }
}

/// Every file says what it is for, every field its unit.
#[test]
fn every_file_has_a_purpose_and_every_field_a_unit() {
    for file in files("msg").iter().chain(&files("srv")) {
        let text = std::fs::read_to_string(package().join(file)).unwrap();
        assert!(text.starts_with("# "), "{file}: the first line is its purpose");
        for field in fields_of(&text) {
            let header = field.type_name == "std_msgs/Header";
            let unit = field.comment.starts_with('[') && field.comment.contains("] ");
            assert!(header || unit, "{file}: {} lacks its [unit]", field.name);
        }
    }
}
