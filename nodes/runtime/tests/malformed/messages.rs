//! Every type that a node reads: a sound message, its reader, and what may pass.

use fdm_loop_msgs::{
    BeadWidth, CompressedImage, DefectReport, FilamentMotion, Header, ImuBatch, LayerHeight, MotionSegment,
    StateEstimate, Temperature,
};
use models::command::{Command, Mode, Permit, Request, Trims};
use models::motion::{MoveKind, Role, Segment, Trapezoid};
use models::status::{HostProfile, JobPhase, PrinterStatus};
use models::units::{Celsius, Seconds};
use runtime::wire;

use crate::storm::{all, is_a_stamp, storm};

fn header() -> Header {
    Header { frame_id: "hotend".to_owned(), ..Header::at(12.5) }
}

fn trims_are_sound(trims: &Trims) -> bool {
    all(&[trims.flow, trims.speed], 0.0, 10.0)
        && all(&[trims.setpoint_offset_k], -300.0, 300.0)
        && all(&[trims.advance_s.unwrap_or(0.0)], 0.0, 10.0)
        && all(&[trims.slip.unwrap_or(0.0)], -0.2, 0.99)
}

#[test]
fn sensors() {
    let sound = Temperature { header: header(), temperature: 210.0, variance: 0.02 };
    storm(&sound, wire::temperature_from_wire, |(stamp, temp)| {
        is_a_stamp(*stamp) && all(&[temp.0], -273.15, 2000.0)
    });
    let sound = FilamentMotion { header: header(), position_m: 1.5, speed_m_s: 2e-3 };
    storm(&sound, wire::filament_from_wire, |read| {
        is_a_stamp(read.stamp) && all(&[read.position_m], -1e4, 1e6)
    });
    let sound = BeadWidth { header: header(), width_m: 4.5e-4, sigma_m: 1e-5, source: "camera".to_owned() };
    storm(&sound, wire::bead_width_from_wire, |read| {
        is_a_stamp(read.exposed) && all(&[read.width_m, read.sigma_m], 0.0, 0.1)
    });
    let sound = LayerHeight { header: header(), layer: 3, along_m: 0.1, height_m: 2e-3, sigma_m: 1e-5 };
    storm(&sound, wire::layer_height_from_wire, |read| {
        is_a_stamp(read.stamp)
            && all(&[read.along_m], 0.0, 1e3)
            && all(&[read.height_m, read.sigma_m], -10.0, 10.0)
    });
    let rest = vec![0.0; 12];
    let sound = ImuBatch {
        header: header(),
        period_s: 1e-3,
        range_m_s2: 156.9,
        x_m_s2: rest.clone(),
        y_m_s2: rest,
        z_m_s2: vec![9.81; 12],
        ..ImuBatch::default()
    };
    storm(&sound, wire::imu_from_wire, |read| {
        let samples = read.samples.iter().all(|sample| all(sample, -4000.0, 4000.0));
        is_a_stamp(read.first) && samples && read.samples.len() <= 8192 && all(&[read.period.0], 1e-6, 1.0)
    });
}

#[test]
fn frames_and_their_judge() {
    let data = vec![0xff, 0xd8, 0xff, 0xc0, 0, 11, 8, 1, 0xe0, 2, 0x80, 1, 1, 0x11, 0, 0xff, 0xd9];
    let sound = CompressedImage { header: header(), format: "jpeg".to_owned(), data };
    storm(&sound, wire::frame_from_wire, |read| {
        is_a_stamp(read.exposed)
            && read.jpeg.starts_with(&[0xff, 0xd8])
            && read.jpeg.len() <= wire::FRAME_BYTES_MAX
    });
    let sound = DefectReport {
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
    storm(&sound, wire::defects_from_wire, |read| {
        is_a_stamp(read.exposed)
            && all(&[read.confidence], 0.0, 1.0)
            && all(&read.offset_m.unwrap_or_default(), -1.0, 1.0)
    });
}

#[test]
fn commands_and_permits() {
    let trims =
        Trims { flow: 1.05, speed: 0.9, setpoint_offset_k: -2.0, advance_s: Some(0.6), slip: Some(0.09) };
    let command = Command { session: 7, sequence: 3, validity: Seconds(1.0), trims };
    storm(&wire::command_to_wire(Seconds(12.5), &command), wire::command_from_wire, |read| {
        trims_are_sound(&read.trims) && all(&[read.validity.0], 1e-3, 60.0)
    });
    let permit = Permit {
        session: 7,
        sequence: 3,
        validity: Seconds(0.25),
        mode: Mode::Act,
        request: Request::Run,
        trims,
    };
    storm(&wire::permit_to_wire(Seconds(12.5), &permit), wire::permit_from_wire, |read| {
        trims_are_sound(&read.trims) && all(&[read.validity.0], 1e-3, 60.0)
    });
}

#[test]
fn printer() {
    let status = PrinterStatus {
        stamp: Seconds(12.5),
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
        trims: Trims { advance_s: Some(0.6), slip: Some(0.09), ..Trims::NEUTRAL },
        advance_s: 0.6,
        homed: true,
        mains_on: true,
        filament_present: Some(true),
        part_fan_speed_1_s: Some(80.0),
        stop_input: Some(false),
    };
    storm(&wire::status_to_wire(&status), wire::status_from_wire, |read| {
        is_a_stamp(read.stamp)
            && all(&[read.progress, read.hotend_duty, read.bed_duty, read.fan], 0.0, 1.0)
            && all(&read.position_m, -100.0, 100.0)
            && all(&[read.path_speed_m_s, read.planned_speed_m_s], 0.0, 10.0)
            && all(&[read.planned_feed_m_s], -10.0, 10.0)
            && all(&[read.motor_position_m, read.wanted_position_m], -1e6, 1e6)
            && all(&[read.path_time_s], 0.0, 1e9)
            && all(&[read.hotend_target.0, read.hotend_sliced_target.0, read.bed_target.0], -50.0, 600.0)
            && all(&[read.target_width_m.unwrap_or(0.0), read.layer_height_m.unwrap_or(0.0)], 0.0, 0.1)
            && all(&[read.advance_s], 0.0, 10.0)
            && trims_are_sound(&read.trims)
    });
}

#[test]
fn moves() {
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
    let sound: MotionSegment = wire::motion_to_wire(Seconds(12.5), 5.5, 42, &segment);
    storm(&sound, wire::motion_from_wire, |read| {
        let (segment, profile) = (&read.segment, &read.segment.profile);
        is_a_stamp(read.start)
            && all(&[read.path_time_s], 0.0, 1e9)
            && all(&segment.start_m, -100.0, 100.0)
            && all(&segment.end_m, -100.0, 100.0)
            && all(&[segment.length_m], 0.0, 100.0)
            && all(&[segment.filament_m], -100.0, 100.0)
            && all(&[profile.entry_m_s, profile.cruise_m_s, profile.exit_m_s], 0.0, 10.0)
            && all(&[profile.accel_s, profile.cruise_s, profile.decel_s], 0.0, 1e5)
            && profile.acceleration_m_s2.is_finite()
    });
}

#[test]
fn estimates() {
    let mut covariance = vec![0.0; 36];
    (0..6).for_each(|index| covariance[index * 7] = 1e-6);
    let sound = StateEstimate {
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
    storm(&sound, wire::estimate_from_wire, |read| {
        is_a_stamp(read.stamp)
            && all(&[read.nozzle.0], 1.0, 2000.0)
            && all(&[read.flow_m_s, read.slip], -1.0, 1.0)
            && all(&[read.gain], 1e-3, 10.0)
            && all(&[read.reference_feed_m_s], 1e-9, 1.0)
    });
}
