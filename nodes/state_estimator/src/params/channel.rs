//! The channels: when each is believed, and its noise.

use super::{RawAdaptation, RawBounds};
use models::params::{ParamError, in_range, ordered};
use serde::Deserialize;

/// When a channel is believed.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawTrust {
    /// Beyond this age of its newest sample the channel is out `[s]`.
    pub age_limit_s: f64,
    /// Innovations whose normalised square is above are rejected `[-]`.
    pub gate: f64,
    /// Innovations looked at for a step of the state behind the channel.
    pub step_samples: u32,
    /// Share of the older half's mean below which the newer half's tells of a transient that fades, not of a step `[-]`.
    pub step_fade: f64,
    /// Gate after a rejection until one is accepted again, where the encoder vouches for the flow `[-]`.
    pub gate_again: f64,
    /// Bound of their sum over the root of their number, above which a step is taken as given `[-]`.
    pub step_threshold: f64,
}

/// Block thermistor, or a sensor in the nozzle.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawThermistor {
    /// Noise `[K]`.
    pub sigma_k: f64,
    /// Lowest credible reading `[degC]`.
    pub low_c: f64,
    /// Highest credible reading `[degC]`.
    pub high_c: f64,
    /// Deviation added on a step to the thermal states, or to the nozzle's alone `[K]`.
    pub step_std_k: f64,
    /// When it is believed.
    pub trust: RawTrust,
}

/// Filament encoder.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawEncoder {
    /// Quantum of the position `[m]`.
    pub quantum_m: f64,
    /// Error relative to the speed `[-]`.
    pub relative: f64,
    /// Unknown shift of the encoder's stamps against the motor's `[s]`.
    pub skew_s: f64,
    /// Shortest interval of a speed `[s]`.
    pub interval_min_s: f64,
    /// Longest interval of a speed `[s]`.
    pub interval_max_s: f64,
    /// Slower than this share of the reference feed is not looked at `[-]`.
    pub speed_min_rel: f64,
    /// Time after a stroke back for which the encoder tells the flow itself `[s]`, in `[0, 2]`.
    pub strokes_s: f64,
    /// Deviation added to the slip on a step `[-]`.
    pub step_std: f64,
    /// Fewest intervals whose way together tells of a step.
    pub stretch_least: u32,
    /// Most of them, at most 20.
    pub stretch_most: u32,
    /// By how much their way has to be off for it, over its deviation `[-]`.
    pub stretch_threshold: f64,
    /// When it is believed.
    pub trust: RawTrust,
}

/// Road width from vision.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawWidth {
    /// Smallest noise taken `[m]`.
    pub sigma_min_m: f64,
    /// Largest credible width `[m]`.
    pub width_max_m: f64,
    /// Share of the flow's recent imbalance by which a width may be off `[-]`.
    pub imbalance: f64,
    /// Memory of the imbalance in lags `[-]`.
    pub memory_lags: f64,
    /// Least time constant with which a rejected width fades while the encoder vouches for the feed, in lags `[-]`.
    pub transient_lags: f64,
    /// Standard deviation of a width while it fades, over what is left of the rejected one `[-]`.
    pub transient_doubt: f64,
    /// Slowest path on which a width is looked at `[m/s]`.
    pub path_speed_min_m_s: f64,
    /// Spread of path speed around the exposure at which a width is not looked at `[-]`.
    pub path_speed_spread: f64,
    /// The path must be steady from this long before the exposure on `[s]`.
    pub steady_s: f64,
    /// Path over which the road's width is averaged `[m]`: one nozzle diameter.
    pub smear_m: f64,
    /// Deviation added to the gain on a step `[-]`.
    pub step_std: f64,
    /// How the noise behind a width is adapted.
    pub adaptation: RawAdaptation,
    /// When it is believed.
    pub trust: RawTrust,
}

/// Checks when a channel is believed; an error names the channel.
macro_rules! check_trust {
    ($channel:literal, $raw:expr) => {{
        let raw: &RawTrust = $raw;
        in_range(concat!($channel, ".trust.age_limit_s"), raw.age_limit_s, "s", (0.02, 60.0))?;
        in_range(concat!($channel, ".trust.gate"), raw.gate, "-", (1.0, 1e6))?;
        in_range(concat!($channel, ".trust.gate_again"), raw.gate_again, "-", (1.0, raw.gate))?;
        in_range(concat!($channel, ".trust.step_fade"), raw.step_fade, "-", (0.0, 1.0))?;
        let samples = f64::from(raw.step_samples);
        in_range(concat!($channel, ".trust.step_samples"), samples, "samples", (1.0, 20.0))?;
        in_range(concat!($channel, ".trust.step_threshold"), raw.step_threshold, "-", (1.0, 100.0))?;
        Ok(())
    }};
}

pub(super) fn check_thermistor(raw: &RawThermistor) -> Result<(), ParamError> {
    in_range("thermistor.sigma_k", raw.sigma_k, "K", (1e-4, 100.0))?;
    in_range("thermistor.low_c", raw.low_c, "degC", (-273.15, 1000.0))?;
    in_range("thermistor.high_c", raw.high_c, "degC", (-273.15, 1000.0))?;
    ordered(("thermistor.low_c", raw.low_c), ("thermistor.high_c", raw.high_c))?;
    in_range("thermistor.step_std_k", raw.step_std_k, "K", (0.0, 100.0))?;
    check_trust!("thermistor", &raw.trust)
}

pub(super) fn check_nozzle_sensor(raw: &RawThermistor) -> Result<(), ParamError> {
    in_range("nozzle_sensor.sigma_k", raw.sigma_k, "K", (1e-4, 100.0))?;
    in_range("nozzle_sensor.low_c", raw.low_c, "degC", (-273.15, 1000.0))?;
    in_range("nozzle_sensor.high_c", raw.high_c, "degC", (-273.15, 1000.0))?;
    ordered(("nozzle_sensor.low_c", raw.low_c), ("nozzle_sensor.high_c", raw.high_c))?;
    in_range("nozzle_sensor.step_std_k", raw.step_std_k, "K", (0.0, 100.0))?;
    check_trust!("nozzle_sensor", &raw.trust)
}

pub(super) fn check_encoder(raw: &RawEncoder) -> Result<(), ParamError> {
    in_range("encoder.quantum_m", raw.quantum_m, "m", (1e-8, 0.01))?;
    in_range("encoder.relative", raw.relative, "-", (0.0, 0.5))?;
    in_range("encoder.skew_s", raw.skew_s, "s", (0.0, 0.1))?;
    in_range("encoder.interval_min_s", raw.interval_min_s, "s", (0.001, 0.1))?;
    in_range("encoder.interval_max_s", raw.interval_max_s, "s", (0.2, 10.0))?;
    in_range("encoder.speed_min_rel", raw.speed_min_rel, "-", (0.0, 1.0))?;
    in_range("encoder.strokes_s", raw.strokes_s, "s", (0.0, 2.0))?;
    in_range("encoder.step_std", raw.step_std, "-", (0.0, 1.0))?;
    let (least, most) = (f64::from(raw.stretch_least), f64::from(raw.stretch_most));
    in_range("encoder.stretch_least", least, "intervals", (1.0, 20.0))?;
    in_range("encoder.stretch_most", most, "intervals", (1.0, 20.0))?;
    ordered(("encoder.stretch_least", least), ("encoder.stretch_most + 1", most + 1.0))?;
    in_range("encoder.stretch_threshold", raw.stretch_threshold, "-", (1.0, 100.0))?;
    check_trust!("encoder", &raw.trust)
}

pub(super) fn check_width(raw: &RawWidth) -> Result<(), ParamError> {
    in_range("width.sigma_min_m", raw.sigma_min_m, "m", (1e-8, 0.01))?;
    in_range("width.width_max_m", raw.width_max_m, "m", (1e-4, 0.1))?;
    in_range("width.imbalance", raw.imbalance, "-", (0.0, 5.0))?;
    in_range("width.memory_lags", raw.memory_lags, "-", (0.01, 20.0))?;
    in_range("width.transient_lags", raw.transient_lags, "lags", (0.01, 20.0))?;
    in_range("width.transient_doubt", raw.transient_doubt, "-", (0.0, 10.0))?;
    in_range("width.path_speed_min_m_s", raw.path_speed_min_m_s, "m/s", (1e-5, 1.0))?;
    in_range("width.path_speed_spread", raw.path_speed_spread, "-", (0.0, 1.0))?;
    in_range("width.steady_s", raw.steady_s, "s", (0.0, 2.0))?;
    in_range("width.smear_m", raw.smear_m, "m", (0.0, 0.01))?;
    in_range("width.step_std", raw.step_std, "-", (0.0, 1.0))?;
    raw.adaptation.check()?;
    check_trust!("width", &raw.trust)
}

/// What a filter starts from, room, `prior.slip` and a gain of 1, lies within whatever is set.
pub(super) fn check_bounds(raw: &RawBounds) -> Result<(), ParamError> {
    in_range("bounds.temperature_low_k", raw.temperature_low_k, "K", (1.0, 240.0))?;
    in_range("bounds.temperature_high_k", raw.temperature_high_k, "K", (450.0, 2000.0))?;
    in_range("bounds.flow_max_m_s", raw.flow_max_m_s, "m/s", (1e-4, 10.0))?;
    in_range("bounds.slip_low", raw.slip_low, "-", (-10.0, -0.1))?;
    in_range("bounds.slip_high", raw.slip_high, "-", (1.0, 10.0))?;
    in_range("bounds.gain_low", raw.gain_low, "-", (0.001, 0.9))?;
    in_range("bounds.gain_high", raw.gain_high, "-", (1.1, 100.0))?;
    Ok(())
}
