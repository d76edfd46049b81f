//! Steps of the simulated plant beside plain Python's, and the whole loop of `fdm sim`.

use super::peers::{ask, median_s};
use super::{Benchmark, PeerArgs};
use crate::config::{Choice, ConfigDir, Setup};
use crate::job::GcodeFile;
use crate::sim::printing::Printing;
use anyhow::bail;
use models::bead::stadium;
use models::extruder::{Filament, RawFilament};
use models::material::Material;
use models::units::{Kelvin, Seconds};
use mpc_controller::params::Level;
use printer_sim::faults::InForce;
use printer_sim::params::PlantParams;
use printer_sim::plant::{Inputs, Plant, Push, Road};
use printer_sim::sensors::Noise;
use printer_sim::{Scenario, Truth};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

const PEER: &str = include_str!("../../../../tests/bench_peers/plant.py");
const PEER_NAME: &str = "plain Python, without bed and diameter";
/// Steps of a millisecond: 60 s of print.
const STEPS: u32 = 60_000;
const ROUNDS: u32 = 9;
const ROAD: Road = Road { target_width_m: 4.8e-4, height_m: 2e-4 };
const INPUTS: Inputs = Inputs { hotend_duty: 0.45, bed_duty: 0.0, mains_on: true, fan: 0.5 };
const MOTOR_M_S: f64 = 1.8e-3;
const PATH_M_S: f64 = 0.05;
const START_K: f64 = 485.0;
/// Largest relative difference from the peer: both are exact but for the outlet's root at 1e-9.
const SAME: f64 = 1e-6;
/// A print of `fdm sim` that is long enough to be timed.
const GCODE: &str = "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode";

pub(super) fn run(args: &PeerArgs) -> anyhow::Result<Vec<Benchmark>> {
    let config = ConfigDir::find(args.config.as_deref())?;
    let setup = config.load(&Choice::of("PLA".into(), Level::Mpc))?;
    let mut plant = setup.simulated.plant;
    plant.filament = Filament::try_from(RawFilament { diameter_sigma_m: 0.0, ..*plant.filament })?;
    let material = plant.material_deviation.apply(&setup.simulated.material)?;
    let (spent_s, truth) = median_s(ROUNDS, || print(&plant, &material));
    let ours = f64::from(STEPS) / spent_s;
    let steps = Benchmark::new("plant: steps of 1 ms a second", "1/s", ours);
    let peer = ask(&args.python, PEER, &problem(&plant, &material))?;
    let mut all = match peer {
        None => vec![steps],
        Some(peer) => {
            let apart = apart(&truth, &peer);
            if apart.is_nan() || apart > SAME {
                bail!("the peer's plant is {apart:.1e} from ours: not the same problem");
            }
            vec![
                Benchmark::new("plant: farthest from the peer after 60 s, relative", "-", apart).target(SAME),
                steps.beside(PEER_NAME, peer["steps_1_s"].as_f64().unwrap_or(f64::NAN)),
            ]
        }
    };
    all.push(
        Benchmark::new("whole loop, times real time", "x", loop_rate(&config, 4, false)?).at_least(200.0),
    );
    all.push(
        Benchmark::new("whole loop with camera, times real time", "x", loop_rate(&config, 1, true)?)
            .at_least(30.0),
    );
    Ok(all)
}

fn print(params: &PlantParams, material: &Material) -> Truth {
    let mut plant = Plant::new(params, material.clone(), Noise::new(1, 1));
    plant.warm_up(Some(Kelvin(START_K)), None);
    for step in 0..STEPS {
        let motor_m_s = MOTOR_M_S * (1.0 + 0.5 * (1e-3 * f64::from(step)).sin());
        let push = Push { motor_m_s, path_speed_m_s: PATH_M_S, road: Some(ROAD) };
        plant.push(push, &InForce::NONE, Seconds(1e-3));
        if step % 10 == 9 {
            plant.heat(&INPUTS, &InForce::NONE, Seconds(0.01));
        }
    }
    plant.truth(Some(ROAD), 0.0)
}

fn apart(truth: &Truth, peer: &Value) -> f64 {
    let told = |name: &str| peer[name].as_f64().unwrap_or(f64::NAN);
    let section_m2 = stadium::area_m2(truth.width_m, ROAD.height_m);
    let pairs = [
        (truth.block_k, told("block_k")),
        (truth.nozzle_k, told("nozzle_k")),
        (truth.sensor_k, told("sensor_k")),
        (truth.delivered_m, told("fed_m")),
        (truth.outlet_m, told("left_m")),
        (section_m2, told("section_m2")),
    ];
    // `max` would pass over what is no number.
    pairs
        .iter()
        .map(|(ours, peer)| (ours / peer - 1.0).abs())
        .fold(0.0, |most, off| if off <= most { most } else { off })
}

fn problem(plant: &PlantParams, material: &Material) -> Value {
    let (hotend, extruder, slip) = (&plant.hotend, &plant.extruder, &plant.slip);
    let gain = (plant.filament.diameter_m / extruder.filament_diameter_m).powi(2);
    json!({
        "steps": STEPS, "motor_m_s": MOTOR_M_S, "path_m_s": PATH_M_S, "start_k": START_K, "gain": gain,
        "duty": INPUTS.hotend_duty, "fan": INPUTS.fan, "ambient_k": plant.ambient_temp_k,
        "section_m2": stadium::area_m2(ROAD.target_width_m, ROAD.height_m),
        "hotend": {
            "block_capacity_j_k": hotend.block_capacity_j_k, "nozzle_capacity_j_k": hotend.nozzle_capacity_j_k,
            "coupling_w_k": hotend.coupling_w_k, "block_loss_w_k": hotend.block_loss_w_k,
            "nozzle_loss_w_k": hotend.nozzle_loss_w_k, "block_loss_fan_w_k": hotend.block_loss_fan_w_k,
            "nozzle_loss_fan_w_k": hotend.nozzle_loss_fan_w_k, "heater_power_w": hotend.heater_power_w,
            "sensor_lag_s": hotend.sensor_lag_s,
        },
        "extruder": {
            "compliance_m_n": extruder.compliance_m_n, "linear_lag_s": extruder.linear_lag_s,
            "force_max_n": extruder.force_max_n, "melting_flow_m3_s": extruder.melting_flow_m3_s,
            "nozzle_radius_m": extruder.nozzle_radius_m, "nozzle_length_m": extruder.nozzle_length_m,
            "filament_diameter_m": extruder.filament_diameter_m,
        },
        "material": {
            "density_kg_m3": material.density_kg_m3, "heat_capacity_j_kg_k": material.heat_capacity_j_kg_k,
            "flow_index": material.flow_index, "consistency_pa_sn": material.consistency_pa_sn,
            "reference_temp_k": material.reference_temp_k, "activation_energy_j_mol": material.activation_energy_j_mol,
        },
        "slip": {
            "base": slip.base, "creep": slip.creep, "creep_force_n": slip.creep_force_n, "overload": slip.overload,
            "overload_force_n": slip.overload_force_n, "cap": slip.cap,
        },
    })
}

/// Simulated over wall time of a print's first layers, the cold printer's heat-up included.
fn loop_rate(config: &ConfigDir, layers: u32, camera: bool) -> anyhow::Result<f64> {
    let choice = Choice { camera, ..Choice::of("PLA".into(), Level::Mpc) };
    let setup: Setup = config.load(&choice)?;
    let file = GcodeFile::read(Path::new(GCODE), &config.motion()?, Some(layers))?;
    let begin = Instant::now();
    let mut printing = Printing::new(&setup, file.job(&setup), &Scenario::default(), 1)?;
    while printing.step() {
        if printing.is_stuck() {
            bail!("the simulated print was paused for good");
        }
    }
    Ok(printing.simulator().truth().stamp_s / begin.elapsed().as_secs_f64())
}
