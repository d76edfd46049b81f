//! The plant against the figures of model book 1.3 and 1.9, on straight lines at constant speed.

use super::*;
use crate::params::{PlantParams, SimulatorParams};
use models::bead::stadium;
use models::command::{DeadManParams, Limits};
use models::motion::{Action, Role, Segment, Trapezoid};
use models::quality::Quality;
use models::units::Celsius;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::path::Path;

#[derive(Deserialize)]
struct RosFile<T> {
    #[serde(rename = "ros__parameters")]
    parameters: T,
}

#[derive(Deserialize)]
struct PlantFile {
    plant: PlantParams,
}

#[derive(Deserialize)]
struct MaterialFile {
    material: models::material::Material,
}

#[derive(Deserialize)]
struct QualityFile {
    quality: Quality,
}

#[derive(Deserialize)]
struct SimulatorFile {
    simulator: SimulatorParams,
    dead_man: DeadManParams,
    limits: Limits,
}

fn load<T: DeserializeOwned>(path: &str) -> T {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config").join(path);
    let text = std::fs::read_to_string(&path).unwrap();
    let mut file: HashMap<String, RosFile<T>> = serde_saphyr::from_str(&text).unwrap();
    file.remove("/**").unwrap().parameters
}

#[derive(Deserialize)]
struct MotionFile {
    printer_motion: models::motion::MotionParams,
}

/// Motion of the shipped printer.
pub(crate) fn motion() -> models::motion::MotionParams {
    load::<MotionFile>("printers/ender3_motion.yaml").printer_motion
}

fn params() -> Params {
    let simulated: SimulatorFile = load("printer_sim.param.yaml");
    Params {
        plant: load::<PlantFile>("plants/ender3.yaml").plant,
        material: load::<MaterialFile>("materials/pla.yaml").material,
        simulator: simulated.simulator,
        dead_man: simulated.dead_man,
        limits: simulated.limits,
        quality: load::<QualityFile>("quality.yaml").quality,
        nozzle_drop_k: 16.0,
    }
}

const HEIGHT_M: f64 = 2e-4;
const WIDTH_M: f64 = 4.8e-4;
const SPEED_M_S: f64 = 0.05;

/// Heats, then lays lines of 50 mm at 50 mm/s without a corner for `time_s`.
fn straight_job(time_s: u32) -> JobSource {
    let area_m2 = std::f64::consts::PI * (1.75e-3_f64 / 2.0).powi(2);
    let filament_m = stadium::area_m2(WIDTH_M, HEIGHT_M) * 0.05 / area_m2;
    let line = Segment {
        line: 1,
        layer: Some(0),
        start_m: [0.0; 3],
        end_m: [0.05, 0.0, 0.0],
        length_m: 0.05,
        filament_m,
        kind: MoveKind::Deposit,
        role: Role::Perimeter,
        arc: false,
        target_width_m: Some(WIDTH_M),
        stated_width_m: None,
        layer_height_m: Some(HEIGHT_M),
        profile: Trapezoid {
            entry_m_s: SPEED_M_S,
            cruise_m_s: SPEED_M_S,
            exit_m_s: SPEED_M_S,
            acceleration_m_s2: 1.0,
            accel_s: 0.0,
            cruise_s: 1.0,
            decel_s: 0.0,
        },
    };
    let heat = Action::HotendTarget { target: Celsius(226.0), wait: true };
    let bed = Action::BedTarget { target: Celsius(60.0), wait: true };
    let start = [Step::Action(bed, 1), Step::Action(heat, 2), Step::Action(Action::Fan(1.0), 3)];
    let lines = std::iter::repeat_n(Step::Move(line), time_s as usize);
    JobSource {
        steps: Box::new(start.into_iter().chain(lines)),
        filament_m: filament_m * f64::from(time_s),
        preheat: Preheat::default(),
    }
}

fn run_to_end(simulator: &mut Simulator) {
    while simulator.phase() != JobPhase::Done {
        simulator.step(Seconds(1e-3));
        while simulator.poll().is_some() {}
    }
}

fn run_until_deposited(simulator: &mut Simulator, time_s: f64) -> crate::score::Integrals {
    while simulator.truth().integrals.deposit_s < time_s {
        simulator.step(Seconds(1e-3));
    }
    simulator.truth().integrals
}

fn scenario(yaml: &str) -> Scenario {
    serde_saphyr::from_str(yaml).unwrap()
}

#[test]
fn open_loop_without_fault_shows_the_figures_of_the_model_book() {
    let mut simulator = Simulator::new(params(), straight_job(100), &Scenario::default(), 1).unwrap();
    // The first seconds only build the pressure up: 7 lags of 0.7 s leave 0.1 % of it.
    let start = run_until_deposited(&mut simulator, 5.0);
    run_to_end(&mut simulator);
    let figures = simulator.truth().integrals.since(&start).unwrap();
    // Slip 1 % plus creep 0.02 (F/40 N)^2: the book states 1.28 % feed error open loop.
    assert!((figures.feed_error_rel - 0.0125).abs() < 0.001, "{figures:?}");
    // Diameter noise 0.02 mm of 1.75 mm is 2.3 % of area; the width follows 1/1.09 of it, less its slow mean.
    assert!((0.005..0.045).contains(&figures.width_rms_rel), "{figures:?}");
}

#[test]
fn nine_percent_slip_open_loop_loses_nine_percent_of_the_filament() {
    let slip = scenario(
        "description: t\nfaults: [{component: extruder, kind: slip, size: 0.09, onset: {filament_share: 0.0}}]",
    );
    let mut simulator = Simulator::new(params(), straight_job(60), &slip, 1).unwrap();
    run_to_end(&mut simulator);
    let figures = simulator.truth().integrals.since(&Default::default()).unwrap();
    assert!((figures.feed_error_rel - 0.102).abs() < 0.002, "{figures:?}");
}

#[test]
fn filament_is_conserved_between_gear_and_outlet() {
    let mut simulator = Simulator::new(params(), straight_job(30), &Scenario::default(), 2).unwrap();
    run_to_end(&mut simulator);
    let truth = simulator.truth();
    // What passed the gear and did not leave is the compressed length: 1.65 mm at 1.8 mm/s (c F + K_lin u).
    let stored_m = truth.delivered_m - truth.outlet_m;
    assert!((1.2e-3..2.2e-3).contains(&stored_m), "{stored_m}");
}

#[test]
fn the_same_seed_repeats_bit_by_bit_and_another_does_not() {
    let last = |seed| {
        let mut simulator = Simulator::new(params(), straight_job(5), &Scenario::default(), seed).unwrap();
        run_to_end(&mut simulator);
        simulator.truth().integrals.width_error_sq_s.to_bits()
    };
    assert_eq!(last(7), last(7));
    assert_ne!(last(7), last(8));
}

#[test]
fn a_warm_printer_begins_to_print_at_once() {
    let mut simulator = Simulator::new(params(), straight_job(5), &Scenario::default(), 1).unwrap();
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    for _ in 0..2000 {
        simulator.step(Seconds(1e-3));
    }
    assert_eq!(simulator.phase(), JobPhase::Printing);
}

fn job_of(actions: &[Action]) -> JobSource {
    let steps: Vec<Step> = actions.iter().map(|action| Step::Action(*action, 1)).collect();
    let job = straight_job(2);
    JobSource { steps: Box::new(steps.into_iter().chain(job.steps)), ..straight_job(2) }
}

fn run_for(simulator: &mut Simulator, time_s: f64) {
    let until = simulator.now() + Seconds(time_s);
    while simulator.now() < until {
        simulator.step(Seconds(1e-3));
    }
}

/// `M600`: the printer waits until the supervisor, which took the pause over, is told to resume.
#[test]
fn a_pause_of_the_file_ends_with_a_persons_resume() {
    let mut simulator = Simulator::new(params(), job_of(&[Action::Pause]), &Scenario::default(), 1).unwrap();
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    run_for(&mut simulator, 1.0);
    assert_eq!(simulator.phase(), JobPhase::Paused);
    let permit = |sequence, request| Permit {
        session: 1,
        sequence,
        validity: Seconds(0.25),
        mode: Mode::Act,
        request,
        trims: Trims::NEUTRAL,
    };
    for (sequence, request) in [(1, Request::Pause), (2, Request::Run)] {
        simulator.on_permit(permit(sequence, request)).unwrap();
        run_for(&mut simulator, 0.1);
    }
    run_for(&mut simulator, 0.5);
    assert_eq!(simulator.phase(), JobPhase::Printing);
}

#[test]
fn an_emergency_stop_in_the_file_gives_the_job_up() {
    let mut simulator = Simulator::new(params(), job_of(&[Action::Stop]), &Scenario::default(), 1).unwrap();
    run_for(&mut simulator, 0.5);
    assert_eq!(simulator.phase(), JobPhase::Failed);
}

#[test]
fn a_demand_to_switch_off_gives_the_job_up_for_good() {
    let mut simulator = Simulator::new(params(), straight_job(30), &Scenario::default(), 1).unwrap();
    let permit = |sequence, request| Permit {
        session: 1,
        sequence,
        validity: Seconds(0.25),
        mode: Mode::SafeOff,
        request,
        trims: Trims::NEUTRAL,
    };
    simulator.on_permit(permit(1, Request::HeatersOff)).unwrap();
    simulator.step(Seconds(1e-3));
    assert_eq!(simulator.phase(), JobPhase::Failed);
    simulator.on_permit(permit(2, Request::Run)).unwrap();
    for _ in 0..1000 {
        simulator.step(Seconds(1e-3));
    }
    assert_eq!(simulator.phase(), JobPhase::Failed);
    assert_eq!(simulator.status().hotend_target, Celsius(0.0));
    assert!(simulator.status().hotend_duty <= 0.0);
}

/// A paused move does not keep the corrections that were in force when it stopped: not its own, and not the set-point's.
#[test]
fn corrections_lapse_in_a_pause_too() {
    let mut simulator = Simulator::new(params(), straight_job(30), &Scenario::default(), 1).unwrap();
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    let trims = Trims { flow: 1.1, setpoint_offset_k: 4.0, ..Trims::NEUTRAL };
    for (sequence, request, wanted) in [(1, Request::Run, trims), (2, Request::Pause, Trims::NEUTRAL)] {
        let permit =
            Permit { session: 1, sequence, validity: Seconds(0.25), mode: Mode::Act, request, trims: wanted };
        for step in 0..2000 {
            if step % 100 == 0 {
                let sequence = sequence * 10_000 + step;
                simulator.on_permit(Permit { sequence, ..permit }).unwrap();
            }
            simulator.step(Seconds(1e-3));
        }
        let status = simulator.status();
        assert_eq!(status.trims, wanted);
        let offset_k = status.hotend_target.0 - status.hotend_sliced_target.0;
        assert!((offset_k - wanted.setpoint_offset_k).abs() < 1e-9, "{offset_k}");
    }
    assert_eq!(simulator.phase(), JobPhase::Paused);
}

#[test]
fn an_opened_mains_relay_ends_a_stuck_heater() {
    let stuck = scenario(
        "description: t\nfaults: [{component: hotend_heater, kind: stuck_on, onset: {time_s: 0.0}}]",
    );
    let mut simulator = Simulator::new(params(), straight_job(30), &stuck, 1).unwrap();
    for _ in 0..20_000 {
        simulator.step(Seconds(1e-3));
    }
    assert!(simulator.truth().heater_w > 39.0);
    let request = Request::EmergencyStop;
    let mode = Mode::Estop;
    let validity = Seconds(0.25);
    simulator
        .on_permit(Permit { session: 1, sequence: 1, validity, mode, request, trims: Trims::NEUTRAL })
        .unwrap();
    for _ in 0..20 {
        simulator.step(Seconds(1e-3));
    }
    assert!(simulator.truth().heater_w <= 0.0);
}

/// The whole Prusa cube: conserved, ended, in about the slicer's own time.
#[test]
fn a_real_file_is_printed_to_its_end() {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/gcode/prusa_cube_pla_marlin_relE.gcode");
    let bytes: std::sync::Arc<[u8]> = std::fs::read(path).unwrap().into();
    let tail = &bytes[bytes.len() - 65_536..];
    let header = models::gcode::Header::scan(&bytes[..65_536], tail);
    let wishes = crate::job::Wishes { layers: Some(10), set_points: None };
    let job = JobSource::from_gcode(&bytes, &header, &motion(), wishes);
    let mut simulator = Simulator::new(params(), job, &Scenario::default(), 1).unwrap();
    run_to_end(&mut simulator);
    let truth = simulator.truth();
    let figures = truth.integrals.since(&Default::default()).unwrap();
    assert!(figures.feed_error_rel < 0.03, "{figures:?}");
    assert_eq!(truth.layer, 10);
}
