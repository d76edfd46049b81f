//! A step of the filter beside FilterPy's: the printer's own model, and one of ten states and six measurements.

use super::peers::{self, ask, numbers};
use super::{Benchmark, PeerArgs};
use crate::config::{Choice, ConfigDir, Setup};
use anyhow::bail;
use models::units::{Kelvin, Seconds};
use mpc_controller::params::Level;
use nalgebra::{SMatrix, SVector, Vector1};
use serde_json::{Value, json};
use state_estimator::engine::{Engine, Form};
use state_estimator::printer_model::{Drive, Road};
use state_estimator::ukf::{Gaussian, Measurement, Spread};
use state_estimator::{PrinterModel, Setting, State, state};
use std::hint::black_box;

const PEER: &str = include_str!("../../../../tests/bench_peers/ukf.py");
const PEER_NAME: &str = "FilterPy 1.4.5";
/// Steps of each case.
const STEPS: u32 = 500;
/// Times that our side does them.
const ROUNDS: u32 = 101;
/// Largest difference of mean and covariance from the peer's, in standard deviations.
const SAME: f64 = 1e-6;
const N: usize = 10;
const M: usize = 6;
const OF_TEN: &str = "10 states, 6 measurements";
/// The two forms that are compared first, then the extended one, which has no peer.
const FORMS: [(&str, Form); 3] =
    [("root form", Form::SquareRoot), ("plain", Form::Unscented), ("extended", Form::Extended)];
const ROAD: Road = Road { path_speed_m_s: 0.05, height_m: 2e-4 };

pub(super) fn run(args: &PeerArgs) -> anyhow::Result<Vec<Benchmark>> {
    let config = ConfigDir::find(args.config.as_deref())?;
    let setup = config.load(&Choice::of("PLA".into(), Level::Mpc))?;
    let (printer, ring) = (Printer::new(&setup), Ring::new(&setup));
    let peer = ask(&args.python, PEER, &json!({ "printer": printer.json(&setup), "ring": ring.json() }))?;
    let step_us = |case: &str| Some(1e6 * peer.as_ref()?[case]["step_s"].as_f64()?);
    let mut all =
        timed("6 states, 3 channels", &FORMS, step_us("printer"), |form| _ = black_box(printer.run(form)));
    let of_ten = timed(OF_TEN, &FORMS[..2], step_us("ring"), |form| _ = black_box(ring.run(form)));
    all.extend(of_ten);
    if let Some(peer) = &peer {
        for (name, form) in &FORMS[..2] {
            all.push(same(&format!("6 states, {name}"), &printer.run(*form), &peer["printer"])?);
            all.push(same(&format!("10 states, {name}"), &ring.run(*form), &peer["ring"])?);
        }
    }
    Ok(all)
}

/// Steps of one problem in all its forms, beside the peer's time for one `[us]`.
fn timed(what: &str, forms: &[(&str, Form)], peer_us: Option<f64>, work: impl Fn(Form)) -> Vec<Benchmark> {
    let mut all = Vec::new();
    let spent_s = peers::in_turn_s(ROUNDS, forms.len(), |index| work(forms[index].1));
    let step_us: Vec<f64> = spent_s.iter().map(|spent_s| 1e6 * spent_s / f64::from(STEPS)).collect();
    for ((name, form), ours_us) in forms.iter().zip(&step_us) {
        let benchmark = Benchmark::new(format!("step of {what}: {name}"), "us", *ours_us);
        let bound = what == OF_TEN && *form == Form::Unscented;
        let benchmark = if bound { benchmark.target(2.0) } else { benchmark };
        // FilterPy's is the plain form; an extended filter is another one.
        all.push(match peer_us.filter(|_| *form != Form::Extended) {
            Some(peer_us) => benchmark.beside(PEER_NAME, peer_us),
            None => benchmark,
        });
    }
    let [root_us, plain_us] = [step_us[0], step_us[1]];
    let name = format!("step of {what}: plain, times as fast as the peer");
    all.extend(peer_us.map(|peer_us| Benchmark::new(name, "x", peer_us / plain_us).at_least(150.0)));
    let name = format!("step of {what}: root form over plain");
    all.push(Benchmark::new(name, "x", root_us / plain_us).target(1.6));
    all
}

/// How far mean and covariance after all steps are from the peer's, in standard deviations: else it is another problem.
fn same<const S: usize>(case: &str, ours: &Gaussian<S>, peer: &Value) -> anyhow::Result<Benchmark> {
    let (mean, rows) = (numbers(&peer["mean"]), peer["covariance"].as_array().cloned().unwrap_or_default());
    let sigma = |index: usize| ours.covariance[(index, index)].sqrt();
    let mut apart = 0.0_f64;
    for (i, row) in rows.iter().enumerate() {
        apart = apart.max((ours.mean[i] - mean[i]).abs() / sigma(i));
        for (j, value) in numbers(row).into_iter().enumerate() {
            apart = apart.max((ours.covariance[(i, j)] - value).abs() / (sigma(i) * sigma(j)));
        }
    }
    if rows.len() != S || apart.is_nan() || apart > SAME {
        bail!("{case}: the peer's result is {apart:.1e} standard deviations from ours: not the same problem");
    }
    Ok(Benchmark::new(format!("{case}: farthest from the peer's mean and covariance"), "std", apart)
        .target(SAME))
}

fn spread(setup: &Setup) -> Spread {
    let spread = setup.estimator.spread;
    Spread { alpha: spread.alpha, beta: spread.beta, kappa: spread.kappa }
}

/// A wave about a value.
fn wave(value: f64, swing: f64, rate: f64, step: u32) -> f64 {
    value + swing * (rate * f64::from(step)).sin()
}

/// The model of the estimator, its noise, and what it hears.
struct Printer {
    model: PrinterModel,
    spread: Spread,
    dt_s: f64,
    prior: Gaussian<{ state::COUNT }>,
    noise: SMatrix<f64, { state::COUNT }, { state::COUNT }>,
    variances: [f64; 3],
    drives: Vec<Drive>,
    values: Vec<[f64; 3]>,
}

impl Printer {
    fn new(setup: &Setup) -> Self {
        let params = &setup.estimator;
        let area_m2 = setup.printer.extruder.filament_area_m2();
        let setting = Setting {
            ambient: Kelvin(params.ambient_k),
            filament_area_m2: area_m2,
            substep: Seconds(params.process.substep_s),
        };
        let (process, prior) = (params.process, params.prior);
        let feed = params.reference.feed_m_s;
        let gained: State = SVector::from([
            process.block_k,
            process.nozzle_k,
            process.sensor_k,
            process.flow_rel * feed,
            process.slip,
            process.gain,
        ]);
        let believed: State = SVector::from([
            prior.block_std_k,
            prior.nozzle_std_k,
            prior.sensor_std_k,
            prior.flow_std_rel * feed,
            prior.slip_std,
            prior.gain_std,
        ]);
        let power_w = setup.printer.hotend.heater_power_w;
        let drive = |step| Drive {
            heater_power_w: wave(0.45, 0.2, 0.1, step) * power_w,
            motor_speed_m_s: wave(2e-3, 4e-4, 0.05, step),
            back_m_s: 0.0,
            filament_speed_m_s: None,
            fan: 0.5,
        };
        let value = |step| {
            [wave(482.0, 2.0, 0.02, step), wave(1.97e-3, 4e-4, 0.05, step), wave(4.5e-4, 1e-5, 0.3, step)]
        };
        Self {
            model: PrinterModel::new(&setup.printer.hotend, &setup.material, setting),
            spread: spread(setup),
            dt_s: params.period_s,
            prior: Gaussian {
                mean: SVector::from([483.0, 475.0, 482.0, 1.9e-3, prior.slip, 1.0]),
                covariance: SMatrix::from_diagonal(&believed.component_mul(&believed)),
            },
            noise: SMatrix::from_diagonal(&gained.component_mul(&gained)),
            variances: [
                params.thermistor.sigma_k.powi(2),
                8.2e-5_f64.powi(2),
                params.width.sigma_min_m.powi(2),
            ],
            drives: (0..STEPS).map(drive).collect(),
            values: (0..STEPS).map(value).collect(),
        }
    }

    fn run(&self, form: Form) -> Gaussian<{ state::COUNT }> {
        let mut engine = Engine::new(form, self.prior, self.spread);
        for (drive, values) in self.drives.iter().zip(&self.values) {
            engine.predict(&self.noise, |x| self.model.step(x, drive, self.dt_s));
            for (channel, value) in values.iter().enumerate() {
                let measurement = Measurement {
                    value: Vector1::new(*value),
                    noise: SMatrix::from([[self.variances[channel]]]),
                    gate: f64::INFINITY,
                };
                engine.update(&measurement, |x| {
                    Vector1::new(match channel {
                        0 => x[state::SENSOR],
                        1 => self.model.filament_speed(x, drive.motor_speed_m_s),
                        _ => self.model.width(x[state::FLOW], x[state::GAIN], ROAD),
                    })
                });
            }
        }
        *engine.belief()
    }

    fn json(&self, setup: &Setup) -> Value {
        let hotend = &setup.printer.hotend;
        let area_m2 = setup.printer.extruder.filament_area_m2();
        let drives: Vec<[f64; 3]> = self
            .drives
            .iter()
            .map(|drive| [drive.heater_power_w, drive.motor_speed_m_s, drive.fan])
            .collect();
        json!({
            "alpha": self.spread.alpha, "beta": self.spread.beta, "kappa": self.spread.kappa, "dt": self.dt_s,
            "mean": self.prior.mean.as_slice(), "variance": self.prior.covariance.diagonal().as_slice(),
            "noise": self.noise.diagonal().as_slice(), "measurement_noise": self.variances,
            "drives": drives, "values": self.values,
            "constants": {
                "block_capacity_j_k": hotend.block_capacity_j_k, "nozzle_capacity_j_k": hotend.nozzle_capacity_j_k,
                "coupling_w_k": hotend.coupling_w_k, "block_loss_w_k": hotend.block_loss_w_k,
                "nozzle_loss_w_k": hotend.nozzle_loss_w_k, "block_loss_fan_w_k": hotend.block_loss_fan_w_k,
                "nozzle_loss_fan_w_k": hotend.nozzle_loss_fan_w_k, "sensor_lag_s": hotend.sensor_lag_s,
                "melt_j_k_m": setup.material.heat_flow_w_k(area_m2), "ambient_k": setup.estimator.ambient_k,
                "substep_s": setup.estimator.process.substep_s, "lag_s": setup.material.lag_s,
                "area_m2": area_m2, "path_m_s": ROAD.path_speed_m_s, "height_m": ROAD.height_m,
            },
        })
    }
}

/// Ten states that pull on their neighbours, six of them seen: a filter of the size of the target. Its model is a
/// polynomial, so that filters are timed and not sines.
struct Ring {
    spread: Spread,
    values: Vec<[f64; M]>,
}

/// Variances at the start, gained in a step, of a measurement.
const RING: [f64; 3] = [0.04, 1e-4, 0.01];

impl Ring {
    fn new(setup: &Setup) -> Self {
        let phase = |channel| f64::from(u32::try_from(channel).unwrap_or(0));
        let value = |step| std::array::from_fn(|channel| wave(0.0, 0.5, 0.01 * (1.0 + phase(channel)), step));
        Self { spread: spread(setup), values: (0..STEPS).map(value).collect() }
    }

    fn run(&self, form: Form) -> Gaussian<N> {
        let square = |value: f64| SMatrix::<f64, N, N>::identity() * value;
        let prior = Gaussian { mean: SVector::zeros(), covariance: square(RING[0]) };
        let noise = square(RING[1]);
        let mut engine = Engine::new(form, prior, self.spread);
        for values in &self.values {
            engine.predict(&noise, |x| {
                SVector::from_fn(|i, _| {
                    let next = x[(i + 1) % N];
                    x[i] + 0.05 * (0.3 * next - 0.05 * next.powi(3) - 0.5 * x[i])
                })
            });
            let measurement = Measurement {
                value: SVector::from(*values),
                noise: SMatrix::<f64, M, M>::identity() * RING[2],
                gate: f64::INFINITY,
            };
            engine.update(&measurement, |x| SVector::from_fn(|i, _| x[i] + 0.1 * x[i + N - M].powi(2)));
        }
        *engine.belief()
    }

    fn json(&self) -> Value {
        json!({
            "alpha": self.spread.alpha, "beta": self.spread.beta, "kappa": self.spread.kappa,
            "mean": vec![0.0; N], "variance": vec![RING[0]; N], "noise": vec![RING[1]; N], "measurement_noise": vec![RING[2]; M],
            "values": self.values,
        })
    }
}
