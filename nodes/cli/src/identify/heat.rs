//! The hot end out of duty, fan, flow and what its thermistor read: model book 1.2, fitted as a whole simulation.
//!
//! Heater power and thermistor alone show four numbers of the five that two heat capacities, their coupling and two losses
//! are; the fan and the melt act on the nozzle, and tell the fifth. The scale of all is the heater's power, which is taken
//! as given: it is printed on the heater, and measured with an ohmmeter.

use super::gains::Gains;
use super::least_squares::{Fit, Problem};
use super::params::{IdentifyParams, Prior};
use super::readings::{noise, without_spikes};
use super::record::{At, Recorded};
use super::series::{self, Says};
use models::hotend::{Hotend, Inputs, RawHotend, Thermal};
use models::material::Material;
use models::status::HostProfile;
use nalgebra::DVector;

/// Places in the vector of parameters: logarithms of ratios to the nominal printer, the last one in kelvin. Behind them
/// stands by how much the filament's section is off from what the widths tell, at each knot.
const BLOCK_CAPACITY: usize = 0;
const NOZZLE_CAPACITY: usize = 1;
const COUPLING: usize = 2;
const BLOCK_LOSS: usize = 3;
const NOZZLE_LOSS: usize = 4;
const BLOCK_LOSS_FAN: usize = 5;
const NOZZLE_LOSS_FAN: usize = 6;
const SENSOR_LAG: usize = 7;
const MELT_HEAT: usize = 8;
pub(super) const AMBIENT: usize = 9;
/// Number of them.
pub(super) const COUNT: usize = 10;

/// A loss of nothing has no logarithm `[W/K]`.
const LOSS_LEAST_W_K: f64 = 1e-4;

/// From one reading to the next.
#[derive(Debug, Clone, Copy)]
struct Step {
    dt_s: f64,
    duty: f64,
    fan: f64,
    flow_m3_s: f64,
    /// Knot of the section before, and the share of the way to the next.
    knot: (usize, f64),
    read_k: f64,
}

/// The problem.
pub(super) struct Heat<'a> {
    params: &'a IdentifyParams,
    nominal: Hotend,
    /// Heat of the melt by volume, as its file says `[J/(K m3)]`.
    melt_j_k_m3: f64,
    steps: Vec<Step>,
    gains: Option<&'a Gains>,
    first: At,
    sigma_k: f64,
}

/// Its answer.
#[derive(Debug, Clone)]
pub(super) struct HeatFit {
    pub(super) fit: Fit,
    pub(super) ambient_k: f64,
    /// Noise of a reading `[K]`.
    pub(super) sigma_k: f64,
    pub(super) readings: usize,
    /// Temperature of the nozzle at each reading `[K]`.
    pub(super) nozzle_k: Vec<At>,
}

impl<'a> Heat<'a> {
    /// `volume_m3` is what left the nozzle so far, against time; `gains` is how well that is known.
    pub(super) fn new(
        recorded: &Recorded,
        (volume_m3, gains): (&[At], Option<&'a Gains>),
        (nominal, material): (Hotend, &Material),
        params: &'a IdentifyParams,
    ) -> Option<Self> {
        let of = |value: fn(&models::status::PrinterStatus) -> f64, says| {
            series::integral(recorded.states.iter().map(|state| (state.stamp.0, value(state))), says)
        };
        let powered =
            |state: &models::status::PrinterStatus| if state.mains_on { state.hotend_duty } else { 0.0 };
        // A host that is seen a few times a second tells the mean duty since it told the last one, another what it has switched.
        let is_slow = |state: &models::status::PrinterStatus| {
            matches!(state.host, HostProfile::Moonraker | HostProfile::Octoprint)
        };
        let slow = recorded.states.first().is_some_and(is_slow);
        let (duty_says, fan_says) =
            if slow { (Says::Mean, Says::Moment) } else { (Says::Onward, Says::Onward) };
        let (duty, fan) = (of(powered, duty_says), of(|state| state.fan, fan_says));
        let (from_s, to_s) = (duty.first()?.0, duty.last()?.0);
        let known: Vec<At> =
            recorded.hotend_k.iter().filter(|(at_s, _)| (from_s..=to_s).contains(at_s)).copied().collect();
        let sigma_k = noise(&known)?;
        let known = without_spikes(&known, sigma_k);
        let step = |pair: &[At]| {
            let ((from_s, _), (to_s, read_k)) = (pair[0], pair[1]);
            Step {
                dt_s: to_s - from_s,
                duty: series::mean(&duty, from_s, to_s),
                fan: series::mean(&fan, from_s, to_s),
                flow_m3_s: series::mean(volume_m3, from_s, to_s).max(0.0),
                knot: gains.map_or((0, 0.0), |gains| gains.at(0.5 * (from_s + to_s))),
                read_k,
            }
        };
        Some(Self {
            params,
            nominal,
            melt_j_k_m3: material.heat_flow_w_k(1.0),
            steps: known.windows(2).map(step).collect(),
            gains,
            first: cold(&known, params.excitation.cold_s)?,
            sigma_k,
        })
    }

    /// Fits from `start` on, or from the nominal printer.
    pub(super) fn fit(&self, start: Option<&Fit>) -> Option<HeatFit> {
        let residuals = |parameters: &DVector<f64>| self.residuals(parameters);
        let fitting = &self.params.fit;
        let problem = Problem {
            residuals: &residuals,
            data: self.steps.len(),
            steps: fitting.steps,
            tolerance: fitting.tolerance,
        };
        let mut from = DVector::zeros(COUNT + self.knots());
        if let Some(fit) = start {
            from.rows_mut(0, COUNT).copy_from(&fit.parameters.rows(0, COUNT));
        }
        let fit = problem.solve(from)?;
        let ambient_k = self.first.1 + fit.parameters[AMBIENT];
        let times = self.steps.iter().scan(self.first.0, |at_s, step| {
            *at_s += step.dt_s;
            Some(*at_s)
        });
        let simulated = self.simulate(&fit.parameters)?;
        let nozzle_k = times.zip(&simulated).map(|(at_s, thermal)| (at_s, thermal.nozzle_k)).collect();
        Some(HeatFit {
            ambient_k,
            sigma_k: self.sigma_k * fit.variance.sqrt(),
            readings: self.steps.len(),
            nozzle_k,
            fit,
        })
    }

    /// Knots of the section.
    fn knots(&self) -> usize {
        self.gains.map_or(0, |gains| gains.whitener.nrows())
    }

    fn hotend(&self, parameters: &DVector<f64>) -> RawHotend {
        let nominal = *self.nominal;
        let of = |value: f64, place: usize| value * parameters[place].exp();
        RawHotend {
            block_capacity_j_k: of(nominal.block_capacity_j_k, BLOCK_CAPACITY),
            nozzle_capacity_j_k: of(nominal.nozzle_capacity_j_k, NOZZLE_CAPACITY),
            coupling_w_k: of(nominal.coupling_w_k, COUPLING),
            block_loss_w_k: of(nominal.block_loss_w_k, BLOCK_LOSS),
            nozzle_loss_w_k: of(nominal.nozzle_loss_w_k, NOZZLE_LOSS),
            block_loss_fan_w_k: of(lossy(nominal.block_loss_fan_w_k), BLOCK_LOSS_FAN),
            nozzle_loss_fan_w_k: of(lossy(nominal.nozzle_loss_fan_w_k), NOZZLE_LOSS_FAN),
            heater_power_w: nominal.heater_power_w,
            sensor_lag_s: of(nominal.sensor_lag_s, SENSOR_LAG),
        }
    }

    fn simulate(&self, parameters: &DVector<f64>) -> Option<Vec<Thermal>> {
        let hotend = Hotend::try_from(self.hotend(parameters)).ok()?;
        let ambient_k = self.first.1 + parameters[AMBIENT];
        let melt_j_k_m3 = self.melt_j_k_m3 * parameters[MELT_HEAT].exp();
        let mut thermal = Thermal::uniform(ambient_k);
        let step = |step: &Step| {
            let inputs = Inputs {
                heater_w: hotend.heater_power_w * step.duty,
                fan: step.fan,
                ambient_k,
                filament_k: ambient_k,
                melt_w_k: melt_j_k_m3 * step.flow_m3_s * (1.0 + self.off(step, parameters)),
            };
            thermal = hotend.step(thermal, &inputs, models::units::Seconds(step.dt_s));
            thermal
        };
        Some(self.steps.iter().map(step).collect())
    }

    /// By how much the filament's section is off in a step `[-]`.
    fn off(&self, step: &Step, parameters: &DVector<f64>) -> f64 {
        let (knot, share) = step.knot;
        match parameters.as_slice().get(COUNT + knot..COUNT + knot + 2) {
            Some(&[before, after]) => before + (after - before) * share,
            _ => 0.0,
        }
    }

    fn residuals(&self, parameters: &DVector<f64>) -> Option<DVector<f64>> {
        let simulated = self.simulate(parameters)?;
        let off = |(step, thermal): (&Step, &Thermal)| (step.read_k - thermal.sensor_k) / self.sigma_k;
        let data = self.steps.iter().zip(&simulated).map(off);
        let beliefs =
            parameters.iter().zip(prior(&self.params.prior)).map(|(value, deviation)| value / deviation);
        let knots = parameters.rows(COUNT, self.knots());
        let sections = self.gains.map(|gains| &gains.whitener * knots);
        let all: Vec<f64> =
            data.chain(beliefs).chain(sections.iter().flat_map(|off| off.iter().copied())).collect();
        Some(DVector::from_vec(all))
    }
}

/// Standard deviations of the belief, in the order of the parameters.
pub(super) fn prior(prior: &Prior) -> [f64; COUNT] {
    [
        prior.capacity_rel,
        prior.capacity_rel,
        prior.coupling_rel,
        prior.loss_rel,
        prior.loss_rel,
        prior.loss_rel,
        prior.loss_rel,
        prior.sensor_lag_rel,
        prior.melt_heat_rel,
        prior.ambient_k,
    ]
}

/// A loss that has a logarithm `[W/K]`.
pub(super) fn lossy(loss_w_k: f64) -> f64 {
    loss_w_k.max(LOSS_LEAST_W_K)
}

/// Time of the first reading, and the mean of the cold ones.
fn cold(readings: &[At], cold_s: f64) -> Option<At> {
    let from_s = readings.first()?.0;
    let cold: Vec<f64> =
        readings.iter().take_while(|(at_s, _)| at_s - from_s <= cold_s).map(|(_, temp_k)| *temp_k).collect();
    #[allow(clippy::cast_precision_loss, reason = "a count of readings")]
    let count = cold.len() as f64;
    Some((from_s, cold.iter().sum::<f64>() / count))
}
