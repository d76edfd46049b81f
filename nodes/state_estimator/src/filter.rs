//! One cycle of the filter: predict to the newest status, then apply what was measured (model book 1.5).

use crate::adaptation::NoiseScale;
use crate::channel::{CHANNELS, Channel, Record};
use crate::engine::Engine;
use crate::estimator::Inbox;
use crate::health::Watch;
use crate::history::Ring;
use crate::intervals::Intervals;
use crate::melt_lag::MeltLag;
use crate::params::Params;
use crate::printer_model::{Drive, PrinterModel, State, state};
use crate::ukf::{Gaussian, Health, Spread};
use models::command::EstimateHealth;
use models::extruder::{Extruder, StaticLaw};
use models::melt::Melt;
use models::status::PrinterStatus;
use models::transient::Transient;
use models::units::Kelvin;
use nalgebra::SMatrix;

type Covariance = SMatrix<f64, { state::COUNT }, { state::COUNT }>;

/// Own estimates kept to look back to an exposure: 3.2 s at 100 Hz.
const FLOWS: usize = 320;
/// Outlet speeds between which one power law stands for the melt's, over the reference feed `[-]`: a corner's and a straight's.
const OUTLETS: (f64, f64) = (0.3, 1.2);

/// Longest way that a filament is drawn back, out of a Bowden tube and off its spool `[m]`.
const STROKE_MAX_M: f64 = 3.0;

/// The filter with what it remembers of its own past.
#[derive(Debug)]
pub(crate) struct Filter {
    params: Params,
    model: PrinterModel,
    melt: Melt,
    extruder: Extruder,
    running: Option<Running>,
    reference_feed_m_s: f64,
    width_noise: NoiseScale,
    melt_lag: MeltLag,
    watch: Watch,
    resets: u64,
    steps: u64,
}

#[derive(Debug)]
struct Running {
    ukf: Engine<{ state::COUNT }>,
    /// The encoder speaks: without it slip and gain are one on a road without strokes.
    encoder_alive: bool,
    /// Widths come: they tell flow and gain as one product, and the slip by what strokes of pressure advance lose.
    width_alive: bool,
    /// Time in which no encoder told of the slip `[s]`.
    blind_s: f64,
    /// A sensor in the nozzle speaks.
    nozzle_alive: bool,
    at_s: f64,
    drive: Drive,
    /// What one of slip takes of the flow once it has followed `[m/s]`: with strokes back and forth several times the flow.
    slipped_m_s: f64,
    flows: Ring<(f64, f64)>,
    /// How the flow depends on the factor of its law `[m/s]`, with stamps.
    slopes: Ring<(f64, f64)>,
    /// How far the flow was lately from what was pushed `[m/s]`, with stamps.
    imbalances: Ring<(f64, f64)>,
    wander: Wander,
    /// A width that was rejected although the encoder vouches for the flow `[m]`.
    transient: Transient,
    /// What the encoder told lately.
    intervals: Intervals,
}

impl Filter {
    pub(crate) fn new(params: Params, model: PrinterModel, (melt, extruder): (Melt, Extruder)) -> Self {
        Self {
            params,
            model,
            melt,
            extruder,
            running: None,
            reference_feed_m_s: params.reference.feed_m_s,
            width_noise: NoiseScale::new(params.width.adaptation),
            melt_lag: MeltLag::new(params.melt_lag),
            watch: Watch::new(params.health),
            resets: 0,
            steps: 0,
        }
    }

    pub(crate) fn reference_feed_m_s(&self) -> f64 {
        self.reference_feed_m_s
    }

    pub(crate) fn resets(&self) -> u64 {
        self.resets
    }

    pub(crate) fn steps(&self) -> u64 {
        self.steps
    }

    /// Compressed length over what the material file says `[-]`, as learnt.
    pub(crate) fn melt_lag(&self) -> f64 {
        self.melt_lag.factor()
    }

    /// Variance of each channel's noise over the configured one `[-]`.
    pub(crate) fn noise_scale(&self) -> [f64; CHANNELS] {
        Channel::ALL.map(|channel| if channel == Channel::Width { self.width_noise.scale() } else { 1.0 })
    }

    pub(crate) fn health(&self, now_s: f64) -> EstimateHealth {
        self.watch.health(now_s)
    }

    /// Tells the watch whether the model fits: only where a road is laid can that be told.
    fn judge(&mut self, now_s: f64, status: &PrinterStatus, records: &[Record; CHANNELS]) {
        let odd = |channel: Channel| records[channel as usize].is_odd(now_s);
        let gain = self.running.as_ref().map(|run| run.ukf.belief().mean[state::GAIN]);
        let far = gain.is_some_and(|gain| (gain - 1.0).abs() > self.params.health.gain_error);
        // the encoder's windows tell of corners, its rows of a broken filter
        let judged = [Channel::Thermistor, Channel::Nozzle, Channel::Width].map(odd);
        let unfit = far || self.width_noise.is_at_its_most() || judged.contains(&true);
        self.watch.on_fit(now_s, status.depositing.then_some(!unfit));
    }

    /// Brings the filter to the newest status; `None` before the first temperature that is recent.
    pub(crate) fn cycle(
        &mut self,
        now_s: f64,
        status: &PrinterStatus,
        inbox: &mut Inbox,
        records: &mut [Record; CHANNELS],
    ) -> Option<()> {
        if self.running.as_ref().is_some_and(|run| now_s - run.at_s > self.params.telemetry.restart_s) {
            self.reset();
        }
        let mut run = match self.running.take() {
            Some(run) => run,
            None => {
                let limit_s = self.params.thermistor.trust.age_limit_s;
                let (_, temperature) = inbox.temperature.filter(|(stamp_s, _)| now_s - stamp_s <= limit_s)?;
                self.start(status, temperature)
            }
        };
        [run.encoder_alive, run.width_alive, run.nozzle_alive] =
            [Channel::Encoder, Channel::Width, Channel::Nozzle].map(|of| records[of as usize].alive(now_s));
        let sound = self.predict(&mut run, status, inbox) == Health::Sound
            && self.correct(&mut run, inbox, records)
            && self.plausible(&run.ukf.belief().mean);
        if sound {
            run.flows.replace_newest((run.at_s, run.ukf.belief().mean[state::FLOW]));
            self.running = Some(run);
        } else {
            self.reset();
            self.watch.on_divergence(now_s);
            records.iter_mut().for_each(Record::restart);
        }
        self.judge(now_s, status, records);
        Some(())
    }

    /// Law of the outlet at the nozzle that is believed, with what was learnt of its lag; `None` where the melt is frozen.
    fn law(&self, x: &State) -> Option<StaticLaw> {
        let temperatures = (Kelvin(x[state::NOZZLE]), Kelvin(self.params.ambient_k));
        let outlets_m_s = (OUTLETS.0 * self.reference_feed_m_s, OUTLETS.1 * self.reference_feed_m_s);
        let foretold = StaticLaw::of_melting((&self.melt, &self.extruder), temperatures, outlets_m_s)?;
        Some(foretold.scaled(self.melt_lag.factor()))
    }

    fn reset(&mut self) {
        self.running = None;
        self.resets += 1;
    }

    fn start(&self, status: &PrinterStatus, temperature: Kelvin) -> Running {
        let prior = &self.params.prior;
        let flow_std_m_s = prior.flow_std_rel * self.reference_feed_m_s;
        let deviations = [
            prior.block_std_k,
            prior.nozzle_std_k,
            prior.sensor_std_k,
            flow_std_m_s,
            prior.slip_std,
            prior.gain_std,
        ];
        let flow_m_s = if status.depositing { status.planned_feed_m_s.max(0.0) } else { 0.0 };
        let mean = State::from([temperature.0, temperature.0, temperature.0, flow_m_s, prior.slip, 1.0]);
        let spread = &self.params.spread;
        let mut imbalances = Ring::new(FLOWS);
        imbalances.push((status.stamp.0, flow_std_m_s));
        Running {
            ukf: Engine::new(
                self.params.filter,
                Gaussian { mean, covariance: variances(deviations) },
                Spread { alpha: spread.alpha, beta: spread.beta, kappa: spread.kappa },
            ),
            encoder_alive: false,
            blind_s: 0.0,
            width_alive: false,
            nozzle_alive: false,
            at_s: status.stamp.0,
            drive: self.drive(status, (0.0, 0.0), None),
            slipped_m_s: flow_m_s,
            flows: Ring::new(FLOWS),
            slopes: Ring::new(FLOWS),
            imbalances,
            wander: Wander::default(),
            transient: Transient::default(),
            intervals: Intervals::new(),
        }
    }

    fn drive(&self, status: &PrinterStatus, motor: (f64, f64), filament_speed_m_s: Option<f64>) -> Drive {
        let duty = if status.mains_on { status.hotend_duty } else { 0.0 };
        let heater_power_w = duty * self.model.heater_power_w();
        // A fan that turns slower than its duty says cools as it turns.
        let turning = |speed_1_s: f64| (speed_1_s / self.params.telemetry.fan_full_1_s).clamp(0.0, 1.0);
        let fan = status.part_fan_speed_1_s.map_or(status.fan, turning);
        let (motor_speed_m_s, back_m_s) = motor;
        Drive { heater_power_w, motor_speed_m_s, back_m_s, filament_speed_m_s, fan }
    }

    fn plausible(&self, x: &State) -> bool {
        let bounds = &self.params.bounds;
        let warm = |index: usize| (bounds.temperature_low_k..=bounds.temperature_high_k).contains(&x[index]);
        warm(state::BLOCK)
            && warm(state::NOZZLE)
            && warm(state::SENSOR)
            // Below zero it stands for a stroke back: whoever unloads the filament draws it back by its whole way.
            && (-STROKE_MAX_M / self.model.lag_s()..=bounds.flow_max_m_s).contains(&x[state::FLOW])
            && (bounds.slip_low..=bounds.slip_high).contains(&x[state::SLIP])
            && (bounds.gain_low..=bounds.gain_high).contains(&x[state::GAIN])
    }
}

mod correct;
mod noise;
mod outlook;
mod predict;
use noise::variances;
use outlook::Wander;
