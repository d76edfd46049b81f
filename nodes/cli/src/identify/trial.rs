//! `fdm identify --trial`: simulated printers whose numbers are drawn, what is learned of them beside the truth.

use super::IdentifyArgs;
use super::learn::{self, Learned, Quantity, learn};
use super::params::{IdentifyParams, Trial};
use super::record::Recorded;
use crate::config::{Choice, ConfigDir, Setup};
use crate::job::GcodeFile;
use crate::output;
use crate::sim::bagging::Bagging;
use crate::sim::printing::Printing;
use anyhow::Context;
use fdm_loop_msgs::PrintInfo;
use models::extruder::StaticLaw;
use models::extruder::{Extruder, RawExtruder};
use models::hotend::{Hotend, RawHotend};
use models::material::{Deviation, RawDeviation};
use models::melt::Melt;
use models::status::JobPhase;
use models::units::Kelvin;
use mpc_controller::params::{AdvanceSource, Level};
use printer_sim::Scenario;
use printer_sim::sensors::Noise;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Random stream of the printers; those of the simulated printer are below ten.
const STREAM: u64 = 50;
/// What counts as near `[-]`.
pub(super) const NEAR: f64 = 0.05;

/// One printer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Run {
    pub(super) seed: u64,
    pub(super) quantities: Vec<Quantity>,
}

/// One quantity over all printers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Verdict {
    pub(super) name: &'static str,
    pub(super) runs: usize,
    /// Truth within the stated 95 % interval.
    pub(super) inside: usize,
    /// Within 5 % of the truth.
    pub(super) near: usize,
    /// One or the other.
    pub(super) either: usize,
    /// Root of the mean square of the relative error.
    pub(super) error_rms_rel: f64,
    /// Mean half width of the interval against the truth.
    pub(super) half_width_rel: f64,
}

/// All of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Figures {
    pub(super) gcode: String,
    pub(super) material: String,
    pub(super) verdicts: Vec<Verdict>,
    pub(super) runs: Vec<Run>,
    /// Printers of which nothing could be learned, and why.
    pub(super) stopped: Vec<Stopped>,
}

/// A printer of which nothing could be learned.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Stopped {
    pub(super) seed: u64,
    pub(super) why: String,
}

/// Prints with every printer, learns it from its bag and compares.
pub(super) fn run(args: &IdentifyArgs, range: &str, config: &ConfigDir) -> anyhow::Result<Figures> {
    let seeds = crate::process::seeds("--trial", range)?;
    let params = IdentifyParams::load(config)?;
    let with_flow = args.only.is_none();
    let material = args.material.clone().unwrap_or_else(|| "PLA".to_owned());
    let choice = Choice { advance: AdvanceSource::None, ..Choice::of(material.clone(), Level::Off) };
    let setup = config.load(&choice)?;
    let file = GcodeFile::read(&args.gcode, &config.motion()?, None)?;
    let progress = output::bar(seeds.len() as u64, "printers");
    let folder = Scratch::new()?;
    let (mut runs, mut stopped) = (Vec::new(), Vec::new());
    for seed in seeds {
        let drawn = Drawn::new(&setup, &params.trial, seed)?;
        let bag = folder.0.join(format!("{seed}"));
        let printed = print(&drawn.setup, &file, &bag, seed)?;
        let recorded = Recorded::read(&bag, None)?;
        std::fs::remove_dir_all(&bag)?;
        match printed {
            Ok(nozzle_k) => {
                super::check(&recorded, &setup, (&params, with_flow), &format!("seed {seed}"))?;
                let mut learned = learn(&recorded, (&setup.printer, &setup.material), &params, with_flow)?;
                drawn.tell(&mut learned, nozzle_k);
                runs.push(Run { seed, quantities: learned.quantities });
            }
            Err(why) => stopped.push(Stopped { seed, why }),
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    Ok(Figures { gcode: file.name(), material, verdicts: verdicts(&runs), runs, stopped })
}

/// A folder that goes with its value.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> anyhow::Result<Self> {
        let folder = std::env::temp_dir().join(format!("fdm_identify_{}", std::process::id()));
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        Ok(Self(folder))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Returns the true mean of the nozzle's temperature while roads were laid `[K]`, or why the print did not come to its end.
fn print(setup: &Setup, file: &GcodeFile, bag: &Path, seed: u64) -> anyhow::Result<Result<f64, String>> {
    let info =
        PrintInfo { print_id: format!("trial-{seed}"), gcode_file: file.name(), ..PrintInfo::default() };
    let mut printing = Printing::new(setup, file.job(setup), &Scenario::default(), seed)?
        .with_bagging(Bagging::create(bag, &info, None)?);
    let (mut sum_k, mut steps) = (0.0, 0.0);
    while printing.step() {
        let truth = printing.simulator().truth();
        if truth.depositing {
            (sum_k, steps) = (sum_k + truth.nozzle_k, steps + 1.0);
        }
        if printing.is_stuck() {
            break;
        }
    }
    printing.take_bagging().map(Bagging::finish).transpose()?;
    if printing.simulator().phase() == JobPhase::Done {
        return Ok(Ok(sum_k / steps));
    }
    let decided = printing.noticed.last();
    let why = decided.map(|last| format!("{} at {:.0} s: {}", last.fault, last.detected_s, last.action));
    Ok(Err(why.unwrap_or_else(|| "the print did not come to its end".to_owned())))
}

/// A printer unlike the nominal one, and what it is.
struct Drawn {
    setup: Setup,
}

impl Drawn {
    /// Every number evenly from its range about the nominal printer and material.
    fn new(nominal: &Setup, trial: &Trial, seed: u64) -> anyhow::Result<Self> {
        let mut noise = Noise::new(seed, STREAM);
        let mut about = |value: f64, rel: f64| value * (1.0 + rel * noise.between((-1.0, 1.0)));
        let mut setup = nominal.clone();
        let (hotend, extruder) = (*nominal.printer.hotend, *nominal.printer.extruder);
        let plant = &mut setup.simulated.plant;
        let rel = trial.hotend_rel;
        plant.hotend = Hotend::try_from(RawHotend {
            block_capacity_j_k: about(hotend.block_capacity_j_k, rel),
            nozzle_capacity_j_k: about(hotend.nozzle_capacity_j_k, rel),
            coupling_w_k: about(hotend.coupling_w_k, rel),
            block_loss_w_k: about(hotend.block_loss_w_k, rel),
            nozzle_loss_w_k: about(hotend.nozzle_loss_w_k, rel),
            block_loss_fan_w_k: about(hotend.block_loss_fan_w_k, rel),
            nozzle_loss_fan_w_k: about(hotend.nozzle_loss_fan_w_k, rel),
            sensor_lag_s: about(hotend.sensor_lag_s, rel),
            ..hotend
        })?;
        plant.extruder = Extruder::try_from(RawExtruder {
            compliance_m_n: about(extruder.compliance_m_n, trial.compliance_rel),
            linear_lag_s: about(extruder.linear_lag_s, trial.linear_lag_rel),
            ..*plant.extruder
        })?;
        plant.material_deviation = Deviation::try_from(RawDeviation {
            flow_index_offset: about(1.0, trial.flow_index) - 1.0,
            consistency_factor: about(1.0, trial.consistency_rel),
            activation_energy_factor: about(1.0, trial.activation_rel),
            heat_capacity_factor: about(1.0, trial.melt_heat_rel),
        })?;
        let sensors = &mut setup.simulated.simulator.sensors;
        sensors.temperature_sigma_k = about(sensors.temperature_sigma_k, trial.noise_rel);
        sensors.width_sigma_m = about(sensors.width_sigma_m, trial.noise_rel);
        plant.ambient_temp_k += trial.ambient_k * (about(1.0, 1.0) - 1.0);
        Ok(Self { setup })
    }

    /// Puts the truth beside what was learned.
    fn tell(&self, learned: &mut Learned, nozzle_k: f64) {
        let told = learned.flow.as_ref().and_then(|flow| Some((self.law(nozzle_k)?, flow)));
        let filed = told.and_then(|(law, flow)| {
            let held_m = flow.speeds_m_s.map(|speed_m_s| law.compression_m(speed_m_s));
            let lags_s = flow.speeds_m_s.map(|speed_m_s| law.lag_s(speed_m_s));
            Some((lags_s, learn::as_filed(flow, &held_m)?.0))
        });
        let (plant, sensors) = (&self.setup.simulated.plant, &self.setup.simulated.simulator.sensors);
        let (hotend, deviation) = (&plant.hotend, &plant.material_deviation);
        let material = &self.setup.material;
        for quantity in &mut learned.quantities {
            quantity.truth = match quantity.name {
                "hotend.block_capacity_j_k" => Some(hotend.block_capacity_j_k),
                "hotend.nozzle_capacity_j_k" => Some(hotend.nozzle_capacity_j_k),
                "hotend.coupling_w_k" => Some(hotend.coupling_w_k),
                "hotend.block_loss_w_k" => Some(hotend.block_loss_w_k),
                "hotend.nozzle_loss_w_k" => Some(hotend.nozzle_loss_w_k),
                "hotend.block_loss_fan_w_k" => Some(hotend.block_loss_fan_w_k),
                "hotend.nozzle_loss_fan_w_k" => Some(hotend.nozzle_loss_fan_w_k),
                "hotend.sensor_lag_s" => Some(hotend.sensor_lag_s),
                "material.heat_capacity_j_kg_k" => {
                    Some(material.heat_capacity_j_kg_k * deviation.heat_capacity_factor)
                }
                "material.flow_index" => Some(material.flow_index + deviation.flow_index_offset),
                "ambient_k" => Some(plant.ambient_temp_k),
                "thermistor.sigma_k" => Some(sensors.temperature_sigma_k),
                "width.sigma_min_m" => Some(sensors.width_sigma_m),
                "encoder.quantum_m" => Some(sensors.encoder_quantum_m),
                "lag_slow_s" => filed.map(|(lags_s, _)| lags_s[0]),
                "lag_s" => filed.map(|(lags_s, _)| lags_s[1]),
                "lag_fast_s" => filed.map(|(lags_s, _)| lags_s[2]),
                "extruder.compliance_m_n" => filed.map(|(_, law)| law[0]),
                "extruder.linear_lag_s" => filed.map(|(_, law)| law[1]),
                _ => None,
            };
        }
    }

    /// The plant's own law at its own mean temperature of the nozzle.
    fn law(&self, nozzle_k: f64) -> Option<StaticLaw> {
        let plant = &self.setup.simulated.plant;
        let material = plant.material_deviation.apply(&self.setup.simulated.material).ok()?;
        let melt = Melt::new(&material, &plant.extruder);
        Some(StaticLaw::new(&melt, &plant.extruder, Kelvin(nozzle_k), 1.0))
    }
}

#[allow(clippy::cast_precision_loss, reason = "a count of runs")]
fn verdicts(runs: &[Run]) -> Vec<Verdict> {
    let Some(first) = runs.first() else { return Vec::new() };
    let of = |place: usize| {
        let all: Vec<(&Quantity, f64)> = runs
            .iter()
            .filter_map(|run| Some((&run.quantities[place], run.quantities[place].truth?)))
            .collect();
        // A count's quantum has no width: what it lost in the last bit is not outside.
        let inside = |(found, truth): &(&Quantity, f64)| {
            let slack = 1e-9 * truth.abs();
            (found.low - slack..=found.high + slack).contains(truth)
        };
        let error = |(found, truth): &(&Quantity, f64)| found.value / truth - 1.0;
        let near = |pair: &(&Quantity, f64)| error(pair).abs() <= NEAR;
        let count = |is: &dyn Fn(&(&Quantity, f64)) -> bool| all.iter().filter(|pair| is(pair)).count();
        let mean = |of: &dyn Fn(&(&Quantity, f64)) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
        Verdict {
            name: first.quantities[place].name,
            runs: all.len(),
            inside: count(&inside),
            near: count(&near),
            either: count(&|pair| inside(pair) || near(pair)),
            error_rms_rel: mean(&|pair| error(pair).powi(2)).sqrt(),
            half_width_rel: mean(&|(found, truth)| 0.5 * (found.high - found.low) / truth),
        }
    };
    (0..first.quantities.len()).map(of).collect()
}
