//! A printer of the shipped parameters that lays straight lines at constant speed, and what the tests ask of it.

use super::*;
use crate::camera::CameraParams;
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

mod camera;
mod feeds;
mod figures;
mod handover;
mod imu;
mod mishaps;
mod requests;
mod schedule;
mod temperatures;

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
    camera: CameraParams,
    dead_man: DeadManParams,
    limits: Limits,
}

pub(crate) fn load<T: DeserializeOwned>(path: &str) -> T {
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
        camera: simulated.camera,
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

/// Warm, so that the first line begins at once.
fn warm(job: JobSource, faults: &Scenario) -> Simulator {
    warm_of(params(), job, faults)
}

fn warm_of(params: Params, job: JobSource, faults: &Scenario) -> Simulator {
    let mut simulator = Simulator::new(params, job, faults, 1).unwrap();
    simulator.warm_up(&Preheat { hotend: Some(Celsius(226.0)), bed: Some(Celsius(60.0)) });
    simulator
}

/// One fault that sets in at this time of the simulation.
fn fault_at(time_s: f64, fault: &str) -> Scenario {
    scenario(&format!("description: t\nfaults: [{{{fault}, onset: {{time_s: {time_s}}}}}]"))
}

/// The first layers of a cube as a slicer gives it.
fn cube(layers: u32) -> JobSource {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/gcode/prusa_cube_pla_marlin_relE.gcode");
    let bytes: std::sync::Arc<[u8]> = std::fs::read(path).unwrap().into();
    let tail = &bytes[bytes.len() - 65_536..];
    let header = models::gcode::Header::scan(&bytes[..65_536], tail);
    let wishes = crate::job::Wishes { layers: Some(layers), set_points: None };
    JobSource::from_gcode(&bytes, &header, &motion(), wishes)
}
