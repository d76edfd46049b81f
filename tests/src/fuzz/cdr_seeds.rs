//! A sound payload of every type.

use super::cdr::KINDS;
use byteorder::LittleEndian;
use fdm_loop_msgs::{
    AdvancePrediction, BeadWidth, CameraInfo, ChangeStateRequest, Clock, CompressedImage, DefectReport,
    DescribeParametersRequest, DiagnosticArray, DiagnosticStatus, FilamentMotion, FilamentReport,
    GetParameterTypesRequest, GetParametersRequest, Header, Heartbeat, Imu, ImuBatch, InjectFaultRequest,
    KeyValue, LayerHeight, LayerQuality, ListParametersRequest, Log, Parameter, ParameterEvent,
    ParameterValue, PrintEvent, PrintInfo, SafetyState, SetModeRequest, SetParametersAtomicallyRequest,
    SetParametersRequest, SimTruth, SimWire, StateEstimate, TFMessage, Temperature, TemperatureReport, Time,
    TransformStamped, TransitionEvent, TriggerRequest,
};
use models::command::{AdvanceLaw, Command, Mode, MotionTrim, Permit, Request, Scheduled, Trims};
use models::motion::{MoveKind, Role, Segment, Trapezoid};
use models::status::{HostProfile, JobPhase, PrinterStatus};
use models::units::{Celsius, Seconds};
use runtime::wire;
use serde::Serialize;

const NOW: Seconds = Seconds(12.5);
const TRIMS: Trims =
    Trims { flow: 1.05, speed: 0.9, setpoint_offset_k: -2.0, advance_s: Some(0.6), slip: Some(0.09) };

pub(super) fn seeds() -> Vec<Vec<u8>> {
    let seeds = [sensors(), frames(), control(), printer(), estimates(), shown(), services()].concat();
    let has_one = |index: usize| seeds.iter().any(|seed| usize::from(seed[0]) == index);
    let missing: Vec<_> =
        (0..KINDS.len()).filter(|index| !has_one(*index)).map(|index| KINDS[index].0).collect();
    assert!(missing.is_empty(), "no seed of {missing:?}");
    seeds
}

fn seed<T: Serialize>(message: &T) -> Vec<u8> {
    let name = std::any::type_name::<T>().rsplit("::").next().unwrap_or_default();
    let index = KINDS.iter().position(|(kind, _)| *kind == name).unwrap();
    [vec![u8::try_from(index).unwrap(), 0], cdr_encoding::to_vec::<T, LittleEndian>(message).unwrap()]
        .concat()
}

fn header() -> Header {
    Header { frame_id: "hotend".to_owned(), ..Header::at(NOW.0) }
}

fn sensors() -> Vec<Vec<u8>> {
    let rest = vec![0.0; 12];
    let (x_m_s2, y_m_s2, z_m_s2) = (rest.clone(), rest, vec![9.81; 12]);
    let (period_s, range_m_s2) = (1e-3, 156.9);
    vec![
        seed(&Temperature { header: header(), temperature: 210.0, variance: 0.02 }),
        seed(&TemperatureReport { header: header(), ..TemperatureReport::default() }),
        seed(&FilamentMotion { header: header(), position_m: 1.5, speed_m_s: 2e-3 }),
        seed(&FilamentReport { header: header(), ..FilamentReport::default() }),
        seed(&BeadWidth { header: header(), width_m: 4.5e-4, sigma_m: 1e-5, source: "camera".to_owned() }),
        seed(&LayerHeight { header: header(), layer: 3, along_m: 0.1, height_m: 2e-3, sigma_m: 1e-5 }),
        seed(&ImuBatch {
            header: header(),
            period_s,
            range_m_s2,
            x_m_s2,
            y_m_s2,
            z_m_s2,
            ..ImuBatch::default()
        }),
        seed(&Imu { header: header(), ..Imu::default() }),
    ]
}

fn frames() -> Vec<Vec<u8>> {
    let data = vec![0xff, 0xd8, 0xff, 0xc0, 0, 11, 8, 1, 0xe0, 2, 0x80, 1, 1, 0x11, 0, 0xff, 0xd9];
    let report = DefectReport {
        header: header(),
        usable: true,
        classes: vec!["ok".to_owned(), "under".to_owned()],
        probabilities: vec![0.9, 0.1],
        confidence: 0.2,
        cause: "under".to_owned(),
        offset_known: true,
        offset_m: [1e-4, 0.0],
        offset_sigma_m: 1e-5,
        ..DefectReport::default()
    };
    vec![
        seed(&CompressedImage { header: header(), format: "jpeg".to_owned(), data }),
        seed(&CameraInfo { header: header(), ..CameraInfo::default() }),
        seed(&report),
        seed(&LayerQuality { header: header(), ..LayerQuality::default() }),
    ]
}

fn control() -> Vec<Vec<u8>> {
    let (session, sequence) = (7, 3);
    let command = Command { session, sequence, validity: Seconds(1.0), trims: TRIMS };
    let (mode, request) = (Mode::Act, Request::Run);
    let permit = Permit { session, sequence, validity: Seconds(0.25), mode, request, trims: TRIMS };
    let advance = AdvanceLaw { linear_s: 0.1, shear: 1e-3, index: 0.4 };
    let trim = MotionTrim { sequence: 42, flow: 1.05, speed: 0.9, advance, carried_m: 1e-3 };
    vec![
        seed(&wire::command_to_wire(NOW, &command)),
        seed(&wire::permit_to_wire(NOW, &permit)),
        seed(&wire::schedule_to_wire(NOW, &Scheduled { session, sequence, validity: Seconds(5.0), trim })),
    ]
}

fn printer() -> Vec<Vec<u8>> {
    let status = PrinterStatus {
        stamp: NOW,
        phase: JobPhase::Printing,
        host: HostProfile::Native,
        progress: 0.5,
        layer: Some(3),
        line: 1200,
        position_m: [0.1, 0.1, 2e-3],
        path_speed_m_s: 0.05,
        planned_speed_m_s: 0.05,
        planned_feed_m_s: 2e-3,
        motor_position_m: 1.5,
        wanted_position_m: 1.5,
        path_time_s: 300.0,
        depositing: true,
        target_width_m: Some(4.5e-4),
        layer_height_m: Some(2e-4),
        hotend_target: Celsius(210.0),
        hotend_sliced_target: Celsius(210.0),
        bed_target: Celsius(60.0),
        hotend_duty: 0.3,
        bed_duty: 0.2,
        fan: 1.0,
        trims: TRIMS,
        advance_s: 0.6,
        homed: true,
        mains_on: true,
        filament_present: Some(true),
        part_fan_speed_1_s: Some(80.0),
        stop_input: Some(false),
    };
    let segment = Segment {
        line: 12,
        layer: Some(3),
        start_m: [0.01, 0.02, 8e-4],
        end_m: [0.03, 0.02, 8e-4],
        length_m: 0.02,
        filament_m: 6e-4,
        kind: MoveKind::Deposit,
        role: Role::Perimeter,
        arc: false,
        target_width_m: Some(4.5e-4),
        stated_width_m: None,
        layer_height_m: Some(2e-4),
        profile: Trapezoid::new(0.02, (5e-3, 0.0), 0.05, 1.0),
    };
    vec![seed(&wire::status_to_wire(&status)), seed(&wire::motion_to_wire(NOW, 5.5, 42, &segment))]
}

fn estimates() -> Vec<Vec<u8>> {
    let mut covariance = vec![0.0; 36];
    (0..6).for_each(|index| covariance[index * 7] = 1e-6);
    let estimate = StateEstimate {
        header: header(),
        names: wire::STATES.map(str::to_owned).to_vec(),
        x: vec![483.0, 475.0, 483.0, 2e-3, 0.01, 1.0],
        covariance,
        observed: vec![true; 6],
        held: vec![false; 6],
        reference_feed_m_s: 2e-3,
        channels: wire::CHANNELS.map(str::to_owned).to_vec(),
        alive: vec![true, false, true, false],
        measured: vec![true; 4],
        nis: vec![1.0; 4],
        nis_mean: vec![1.0; 4],
        gated: vec![0; 4],
        chi_square: vec![20.0; 4],
        ..StateEstimate::default()
    };
    let prediction = AdvancePrediction {
        header: header(),
        advance_known: true,
        advance_s: 0.5,
        advance_linear_s: 0.1,
        advance_shear_m: 1e-3,
        advance_index: 0.4,
        ..AdvancePrediction::default()
    };
    vec![seed(&estimate), seed(&prediction)]
}

fn shown() -> Vec<Vec<u8>> {
    let node = "/printer/thermistor".to_owned();
    let values = vec![KeyValue { key: "rate_hz".to_owned(), value: "10".to_owned() }];
    let status = vec![DiagnosticStatus { name: node.clone(), values, ..DiagnosticStatus::default() }];
    vec![
        seed(&Clock { clock: Time::from_seconds(NOW.0) }),
        seed(&Heartbeat { header: header(), node: node.clone(), ..Heartbeat::default() }),
        seed(&SafetyState { header: header(), what_to_do: node.clone(), ..SafetyState::default() }),
        seed(&PrintEvent { header: header(), who: node.clone(), ..PrintEvent::default() }),
        seed(&PrintInfo { header: header(), config: "a: 1\n".repeat(9), ..PrintInfo::default() }),
        seed(&DiagnosticArray { header: header(), status }),
        seed(&SimTruth { header: header(), ..SimTruth::default() }),
        seed(&SimWire { header: header(), ..SimWire::default() }),
        seed(&Log { name: node.clone(), ..Log::default() }),
        seed(&TFMessage { transforms: vec![TransformStamped::default(); 2] }),
        seed(&ParameterEvent { node, ..ParameterEvent::default() }),
        seed(&TransitionEvent::default()),
    ]
}

fn services() -> Vec<Vec<u8>> {
    let value = ParameterValue {
        kind: ParameterValue::STRING_ARRAY,
        string_array_value: vec!["a".to_owned(); 3],
        byte_array_value: vec![1, 2, 3],
        double_array_value: vec![0.5; 4],
        ..ParameterValue::default()
    };
    let parameters = vec![Parameter { name: "stale.hotend.pause_s".to_owned(), value }; 2];
    let names = vec!["modes.ramp_s".to_owned(), "use_sim_time".to_owned()];
    let (component, kind) = ("extruder".to_owned(), "slip".to_owned());
    let fault = InjectFaultRequest { component, kind, size: 0.1, ..InjectFaultRequest::default() };
    vec![
        seed(&SetParametersRequest { parameters: parameters.clone() }),
        seed(&SetParametersAtomicallyRequest { parameters }),
        seed(&GetParametersRequest { names: names.clone() }),
        seed(&GetParameterTypesRequest { names: names.clone() }),
        seed(&DescribeParametersRequest { names: names.clone() }),
        seed(&ListParametersRequest { prefixes: names, depth: 2 }),
        seed(&ChangeStateRequest::default()),
        seed(&SetModeRequest { mode: 3 }),
        seed(&TriggerRequest::default()),
        seed(&fault),
    ]
}
