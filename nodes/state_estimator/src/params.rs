//! Parameters of the estimator, checked once: `config/state_estimator.param.yaml`.

use crate::channel::Channel;
use crate::engine::Form;
use models::params::{ParamError, in_range};
use serde::Deserialize;

/// Parameters of [`crate::Estimator`], built only from a valid file.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawParams")]
pub struct Params(RawParams);

impl std::ops::Deref for Params {
    type Target = RawParams;
    fn deref(&self) -> &RawParams {
        &self.0
    }
}

/// The file as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawParams {
    /// Period of the shell's tick `[s]`, below `encoder.interval_max_s`.
    pub period_s: f64,
    /// Form of the filter.
    pub filter: Form,
    /// Air and filament before the hot end `[K]`.
    pub ambient_k: f64,
    /// Spread of the sigma points.
    pub spread: RawSpread,
    /// Process noise and model.
    pub process: RawProcess,
    /// What is believed before the first measurement.
    pub prior: RawPrior,
    /// Reference feed.
    pub reference: RawReference,
    /// Block thermistor.
    pub thermistor: RawThermistor,
    /// Sensor in the nozzle, where one is fitted.
    pub nozzle_sensor: RawThermistor,
    /// Filament encoder.
    pub encoder: RawEncoder,
    /// Road width from vision.
    pub width: RawWidth,
    /// What is learnt of the melt's lag.
    pub melt_lag: RawMeltLag,
    /// What holds instead where widths alone tell of the slip.
    pub widths_alone: RawWidthsAlone,
    /// The printer's own telemetry.
    pub telemetry: RawTelemetry,
    /// States outside of these bounds reset the filter.
    pub bounds: RawBounds,
    /// When the estimate is not to be trusted.
    pub health: RawHealth,
}

/// Spread of the sigma points.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSpread {
    /// `[-]`.
    pub alpha: f64,
    /// `[-]`.
    pub beta: f64,
    /// `[-]`.
    pub kappa: f64,
}

/// Standard deviations gained per `reference_period_s`, and the model's step.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawProcess {
    /// Span the deviations below refer to `[s]`.
    pub reference_period_s: f64,
    /// Longest Euler step of the thermal part `[s]`.
    pub substep_s: f64,
    /// Block `[K]`.
    pub block_k: f64,
    /// Nozzle of which only the model tells, or a sensor where widths stand for an encoder `[K]`.
    pub nozzle_k: f64,
    /// Nozzle of which a sensor tells otherwise `[K]`.
    pub nozzle_seen_k: f64,
    /// Thermistor `[K]`.
    pub sensor_k: f64,
    /// Flow relative to the reference feed `[-]`.
    pub flow_rel: f64,
    /// Slip that an encoder tells of `[-]`.
    pub slip: f64,
    /// Slip of which nothing tells `[-]`.
    pub slip_unseen: f64,
    /// Gain `[-]`.
    pub gain: f64,
    /// Uncertainty of the lag, relative: a flow off balance is known that much worse `[-]`.
    pub lag_rel: f64,
    /// Share of slip's and gain's noise that remains while nothing is extruded `[-]`.
    pub frozen: f64,
}

/// Mean and standard deviation of the prior.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawPrior {
    /// Deviation of the block from the first reading `[K]`.
    pub block_std_k: f64,
    /// Deviation of the nozzle from the first reading `[K]`.
    pub nozzle_std_k: f64,
    /// Deviation of the thermistor from the first reading `[K]`.
    pub sensor_std_k: f64,
    /// Deviation of the flow relative to the reference feed `[-]`.
    pub flow_std_rel: f64,
    /// Mean slip `[-]`, within the bounds.
    pub slip: f64,
    /// Its deviation, also the bound of what is forgotten while nothing is extruded `[-]`.
    pub slip_std: f64,
    /// Deviation of the gain from 1, also the bound of what is forgotten `[-]`.
    pub gain_std: f64,
}

/// Slow mean of the slicer's feed, the scale of the flow.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawReference {
    /// Before anything was extruded `[m/s]`.
    pub feed_m_s: f64,
    /// Time constant of the mean `[s]`.
    pub averaging_s: f64,
}

/// The printer's own telemetry.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTelemetry {
    /// Beyond this age of the newest status nothing is estimated `[s]`.
    pub age_limit_s: f64,
    /// A gap longer than this starts the filter anew `[s]`.
    pub restart_s: f64,
    /// Samples may be stamped this far ahead of the tick `[s]`.
    pub lead_limit_s: f64,
    /// Fastest credible motor `[m/s]`; a faster jump is a new count.
    pub motor_speed_max_m_s: f64,
    /// Turns of a sound part fan at full duty, where it has a tachometer `[1/s]`.
    pub fan_full_1_s: f64,
}

/// States outside of these bounds reset the filter. Room, `prior.slip` and a gain of 1 are within all of them.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawBounds {
    /// `[K]`.
    pub temperature_low_k: f64,
    /// `[K]`.
    pub temperature_high_k: f64,
    /// Magnitude of the flow `[m/s]`.
    pub flow_max_m_s: f64,
    /// `[-]`.
    pub slip_low: f64,
    /// `[-]`.
    pub slip_high: f64,
    /// `[-]`.
    pub gain_low: f64,
    /// `[-]`.
    pub gain_high: f64,
}

impl Params {
    /// When a channel is believed.
    pub(crate) fn trust(&self, channel: Channel) -> RawTrust {
        match channel {
            Channel::Thermistor => self.thermistor.trust,
            Channel::Encoder => self.encoder.trust,
            Channel::Width => self.width.trust,
            Channel::Nozzle => self.nozzle_sensor.trust,
        }
    }
}

impl TryFrom<RawParams> for Params {
    type Error = ParamError;

    fn try_from(raw: RawParams) -> Result<Self, ParamError> {
        in_range("period_s", raw.period_s, "s", (0.01, 0.1))?;
        in_range("ambient_k", raw.ambient_k, "K", (250.0, 400.0))?;
        in_range("spread.alpha", raw.spread.alpha, "-", (1e-3, 1.0))?;
        // below the square of alpha the covariance of the sigma points would lose by the mean's shift
        in_range("spread.beta", raw.spread.beta, "-", (1.0, 10.0))?;
        in_range("spread.kappa", raw.spread.kappa, "-", (0.0, 10.0))?;
        check_process(&raw.process)?;
        check_prior(&raw.prior)?;
        in_range("reference.feed_m_s", raw.reference.feed_m_s, "m/s", (1e-5, 0.05))?;
        in_range("reference.averaging_s", raw.reference.averaging_s, "s", (0.1, 1000.0))?;
        check_thermistor(&raw.thermistor)?;
        check_nozzle_sensor(&raw.nozzle_sensor)?;
        check_encoder(&raw.encoder)?;
        check_width(&raw.width)?;
        raw.melt_lag.check()?;
        raw.widths_alone.check()?;
        in_range("telemetry.age_limit_s", raw.telemetry.age_limit_s, "s", (0.02, 5.0))?;
        in_range("telemetry.restart_s", raw.telemetry.restart_s, "s", (0.1, 60.0))?;
        in_range("telemetry.lead_limit_s", raw.telemetry.lead_limit_s, "s", (0.0, 5.0))?;
        in_range("telemetry.motor_speed_max_m_s", raw.telemetry.motor_speed_max_m_s, "m/s", (0.01, 2.0))?;
        in_range("telemetry.fan_full_1_s", raw.telemetry.fan_full_1_s, "1/s", (1.0, 2000.0))?;
        check_bounds(&raw.bounds)?;
        raw.health.check()?;
        Ok(Self(raw))
    }
}

fn check_process(raw: &RawProcess) -> Result<(), ParamError> {
    in_range("process.reference_period_s", raw.reference_period_s, "s", (0.001, 10.0))?;
    in_range("process.substep_s", raw.substep_s, "s", (1e-3, 0.5))?;
    in_range("process.block_k", raw.block_k, "K", (1e-6, 100.0))?;
    in_range("process.nozzle_k", raw.nozzle_k, "K", (1e-6, 100.0))?;
    in_range("process.nozzle_seen_k", raw.nozzle_seen_k, "K", (1e-6, 100.0))?;
    in_range("process.sensor_k", raw.sensor_k, "K", (1e-6, 100.0))?;
    in_range("process.flow_rel", raw.flow_rel, "-", (1e-6, 1.0))?;
    in_range("process.slip", raw.slip, "-", (1e-6, 1.0))?;
    in_range("process.slip_unseen", raw.slip_unseen, "-", (1e-6, 1.0))?;
    in_range("process.gain", raw.gain, "-", (1e-6, 1.0))?;
    in_range("process.lag_rel", raw.lag_rel, "-", (0.0, 2.0))?;
    in_range("process.frozen", raw.frozen, "-", (0.0, 1.0))?;
    Ok(())
}

fn check_prior(raw: &RawPrior) -> Result<(), ParamError> {
    in_range("prior.block_std_k", raw.block_std_k, "K", (0.001, 1000.0))?;
    in_range("prior.nozzle_std_k", raw.nozzle_std_k, "K", (0.001, 1000.0))?;
    in_range("prior.sensor_std_k", raw.sensor_std_k, "K", (0.001, 1000.0))?;
    in_range("prior.flow_std_rel", raw.flow_std_rel, "-", (1e-4, 2.0))?;
    in_range("prior.slip", raw.slip, "-", (-0.05, 0.9))?;
    in_range("prior.slip_std", raw.slip_std, "-", (1e-4, 1.0))?;
    in_range("prior.gain_std", raw.gain_std, "-", (1e-4, 1.0))?;
    Ok(())
}

mod adaptive;
mod alone;
mod channel;

pub use adaptive::{RawAdaptation, RawHealth, RawMeltLag};
pub use alone::RawWidthsAlone;
pub use channel::{RawEncoder, RawThermistor, RawTrust, RawWidth};
use channel::{check_bounds, check_encoder, check_nozzle_sensor, check_thermistor, check_width};
