//! Checks of the channels' blocks.

use super::{RawBounds, RawEncoder, RawThermistor, RawTrust, RawWidth};
use models::params::{ParamError, in_range, ordered};

fn check_trust(raw: &RawTrust) -> Result<(), ParamError> {
    in_range("trust.age_limit_s", raw.age_limit_s, "s", (0.02, 60.0))?;
    in_range("trust.gate", raw.gate, "-", (1.0, 1e6))?;
    in_range("trust.gate_again", raw.gate_again, "-", (1.0, raw.gate))?;
    in_range("trust.step_fade", raw.step_fade, "-", (0.0, 1.0))?;
    in_range("trust.step_samples", f64::from(raw.step_samples), "samples", (1.0, 20.0))?;
    in_range("trust.step_threshold", raw.step_threshold, "-", (1.0, 100.0))?;
    Ok(())
}

pub(super) fn check_thermistor(raw: &RawThermistor) -> Result<(), ParamError> {
    in_range("thermistor.sigma_k", raw.sigma_k, "K", (1e-4, 100.0))?;
    in_range("thermistor.low_c", raw.low_c, "degC", (-273.15, 1000.0))?;
    in_range("thermistor.high_c", raw.high_c, "degC", (-273.15, 1000.0))?;
    ordered(("thermistor.low_c", raw.low_c), ("thermistor.high_c", raw.high_c))?;
    in_range("thermistor.step_std_k", raw.step_std_k, "K", (0.0, 100.0))?;
    check_trust(&raw.trust)
}

pub(super) fn check_encoder(raw: &RawEncoder) -> Result<(), ParamError> {
    in_range("encoder.quantum_m", raw.quantum_m, "m", (1e-8, 0.01))?;
    in_range("encoder.relative", raw.relative, "-", (0.0, 0.5))?;
    in_range("encoder.skew_s", raw.skew_s, "s", (0.0, 0.1))?;
    in_range("encoder.interval_min_s", raw.interval_min_s, "s", (0.001, 10.0))?;
    in_range("encoder.interval_max_s", raw.interval_max_s, "s", (0.001, 10.0))?;
    ordered(("encoder.interval_min_s", raw.interval_min_s), ("encoder.interval_max_s", raw.interval_max_s))?;
    in_range("encoder.speed_min_rel", raw.speed_min_rel, "-", (0.0, 1.0))?;
    in_range("encoder.strokes_s", raw.strokes_s, "s", (0.0, 2.0))?;
    in_range("encoder.step_std", raw.step_std, "-", (0.0, 1.0))?;
    check_trust(&raw.trust)
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
    check_trust(&raw.trust)
}

pub(super) fn check_bounds(raw: &RawBounds) -> Result<(), ParamError> {
    in_range("bounds.temperature_low_k", raw.temperature_low_k, "K", (1.0, 2000.0))?;
    in_range("bounds.temperature_high_k", raw.temperature_high_k, "K", (1.0, 2000.0))?;
    in_range("bounds.slip_low", raw.slip_low, "-", (-10.0, 10.0))?;
    in_range("bounds.slip_high", raw.slip_high, "-", (-10.0, 10.0))?;
    in_range("bounds.gain_high", raw.gain_high, "-", (1e-3, 100.0))?;
    ordered(
        ("bounds.temperature_low_k", raw.temperature_low_k),
        ("bounds.temperature_high_k", raw.temperature_high_k),
    )?;
    in_range("bounds.flow_max_m_s", raw.flow_max_m_s, "m/s", (1e-4, 10.0))?;
    ordered(("bounds.slip_low", raw.slip_low), ("bounds.slip_high", raw.slip_high))?;
    in_range("bounds.gain_low", raw.gain_low, "-", (0.001, 100.0))?;
    ordered(("bounds.gain_low", raw.gain_low), ("bounds.gain_high", raw.gain_high))?;
    Ok(())
}
