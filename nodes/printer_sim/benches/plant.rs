//! Simulated milliseconds of a real file, without and with the inertial unit. `fdm bench sim` sets the plant beside
//! plain Python.

#![expect(clippy::expect_used, reason = "a benchmark has nobody to hand an error to")]

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use models::gcode::Header;
use models::units::Seconds;
use printer_sim::job::Wishes;
use printer_sim::params::{PlantParams, SimulatorParams};
use printer_sim::{JobSource, Params, Scenario, Simulator};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::error::Error;
use std::path::Path;

const FILE: &str = "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode";
/// Steps of a millisecond: 10 s of print.
const STEPS: u32 = 10_000;

#[derive(Deserialize)]
struct RosFile<T> {
    #[serde(rename = "ros__parameters")]
    parameters: T,
}

#[derive(Deserialize)]
struct Blocks {
    plant: Option<PlantParams>,
    material: Option<models::material::Material>,
    quality: Option<models::quality::Quality>,
    printer_motion: Option<models::motion::MotionParams>,
    simulator: Option<SimulatorParams>,
    camera: Option<printer_sim::camera::CameraParams>,
    dead_man: Option<models::command::DeadManParams>,
    limits: Option<models::command::Limits>,
}

fn prints(criterion: &mut Criterion) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let bytes: std::sync::Arc<[u8]> = std::fs::read(root.join(FILE)).expect(FILE).into();
    let blocks = blocks(&root, "printers/ender3_motion.yaml").expect("the motion's file");
    let motion = blocks.printer_motion.expect("printer_motion");
    let ends = motion.read.header_bytes.min(bytes.len());
    let header = Header::scan(&bytes[..ends], &bytes[bytes.len() - ends..]);
    let mut params = params(&root).expect("the configuration");
    let imu_period_s = params.simulator.imu.period_s;
    let mut group = criterion.benchmark_group("10 s of a print in steps of 1 ms");
    for (name, period_s) in [("without inertial unit", 0.0), ("with inertial unit", imu_period_s)] {
        params.simulator.imu.period_s = period_s;
        let started = || {
            let job = JobSource::from_gcode(&bytes, &header, &motion, Wishes::default());
            let preheat = job.preheat;
            let mut simulator =
                Simulator::new(params.clone(), job, &Scenario::default(), 1).expect("a simulator");
            simulator.warm_up(&preheat);
            simulator
        };
        group.bench_function(name, |bencher| {
            bencher.iter_batched_ref(started, print, BatchSize::LargeInput);
        });
    }
    group.finish();
}

fn print(simulator: &mut Simulator) {
    for _ in 0..STEPS {
        simulator.step(Seconds(1e-3));
        while simulator.poll().is_some() {}
    }
}

fn blocks(root: &Path, file: &str) -> Result<Blocks, Box<dyn Error>> {
    blocks_of(&root.join("config").join(file))
}

fn blocks_of<T: DeserializeOwned>(path: &Path) -> Result<T, Box<dyn Error>> {
    let mut file: HashMap<String, RosFile<T>> = serde_saphyr::from_str(&std::fs::read_to_string(path)?)?;
    Ok(file.remove("/**").ok_or("/**")?.parameters)
}

fn params(root: &Path) -> Result<Params, Box<dyn Error>> {
    let simulated = blocks(root, "printer_sim.param.yaml")?;
    Ok(Params {
        plant: blocks(root, "plants/ender3.yaml")?.plant.ok_or("plant")?,
        material: blocks(root, "materials/pla.yaml")?.material.ok_or("material")?,
        simulator: simulated.simulator.ok_or("simulator")?,
        camera: simulated.camera.ok_or("camera")?,
        dead_man: simulated.dead_man.ok_or("dead_man")?,
        limits: simulated.limits.ok_or("limits")?,
        quality: blocks(root, "quality.yaml")?.quality.ok_or("quality")?,
        nozzle_drop_k: 16.0,
    })
}

criterion_group!(plant, prints);
criterion_main!(plant);
