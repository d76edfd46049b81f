//! Time of one simulated millisecond on a real file, without and with the inertial unit.
//!
//! `cargo run --release -p printer_sim --no-default-features --example plant_time -- [G-code file]`

use models::gcode::Header;
use models::status::JobPhase;
use models::units::Seconds;
use printer_sim::job::Wishes;
use printer_sim::params::{PlantParams, SimulatorParams};
use printer_sim::{JobSource, Params, Scenario, Simulator};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::error::Error;
use std::io::Write;
use std::path::Path;
use std::time::Instant;

const FILE: &str = "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode";
const RUNS: u32 = 5;

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

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let file = std::env::args().nth(1).unwrap_or_else(|| FILE.into());
    let bytes: std::sync::Arc<[u8]> = std::fs::read(root.join(file))?.into();
    let motion = blocks(&root, "printers/ender3_motion.yaml")?.printer_motion.ok_or("printer_motion")?;
    let ends = motion.read.header_bytes.min(bytes.len());
    let header = Header::scan(&bytes[..ends], &bytes[bytes.len() - ends..]);
    let mut params = params(&root)?;
    let imu_period_s = params.simulator.imu.period_s;
    for (name, period_s) in [("without", 0.0), ("with", imu_period_s)] {
        params.simulator.imu.period_s = period_s;
        let mut best = f64::INFINITY;
        for _ in 0..RUNS {
            let job = JobSource::from_gcode(&bytes, &header, &motion, Wishes::default());
            best = best.min(wall_per_simulated(&params, job)?);
        }
        let (step_ns, factor) = (best * 1e6, 1.0 / best);
        writeln!(
            std::io::stdout(),
            "{name} inertial unit: step {step_ns:.0} ns, {factor:.0} times real time, best of {RUNS}"
        )?;
    }
    Ok(())
}

/// Wall time per simulated time `[-]` of one print from warm to its end.
fn wall_per_simulated(params: &Params, job: JobSource) -> Result<f64, Box<dyn Error>> {
    let preheat = job.preheat;
    let mut simulator = Simulator::new(params.clone(), job, &Scenario::default(), 1)?;
    simulator.warm_up(&preheat);
    let start = Instant::now();
    while simulator.phase() != JobPhase::Done {
        simulator.step(Seconds(1e-3));
        while simulator.poll().is_some() {}
    }
    Ok(start.elapsed().as_secs_f64() / simulator.now().0)
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
