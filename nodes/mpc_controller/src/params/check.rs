//! Checks of the blocks.

use super::{RawBase, RawCost, RawHealth, RawLimits, RawSlip, RawTrims};
use crate::trims::loop_gain_limit;
use models::params::{ParamError, in_range};

pub(super) fn cost(raw: &RawCost) -> Result<(), ParamError> {
    in_range("cost.width_scale", raw.width_scale, "-", (1e-300, 10.0))?;
    in_range("cost.temperature_scale_k", raw.temperature_scale_k, "K", (0.01, 1000.0))?;
    in_range("cost.temperature_weight", raw.temperature_weight, "-", (0.0, 1e3))?;
    in_range("cost.speed_scale", raw.speed_scale, "-", (1e-4, 10.0))?;
    in_range("cost.feed_scale", raw.feed_scale, "-", (1e-4, 10.0))?;
    in_range("cost.setpoint_weight_1_k2", raw.setpoint_weight_1_k2, "1/K2", (0.0, 1e3))?;
    in_range("cost.change_weight", raw.change_weight, "-", (0.0, 1e3))?;
    in_range("cost.feed_change", raw.feed_change, "-", (1e-4, 10.0))?;
    in_range("cost.speed_change", raw.speed_change, "-", (1e-4, 10.0))?;
    in_range("cost.setpoint_change_k", raw.setpoint_change_k, "K", (0.01, 1000.0))?;
    Ok(())
}

pub(super) fn limits(raw: &RawLimits) -> Result<(), ParamError> {
    in_range("limits.feed", raw.feed, "-", (0.0, 0.5))?;
    in_range("limits.speed_low", raw.speed_low, "-", (-0.9, 0.0))?;
    in_range("limits.speed_high", raw.speed_high, "-", (0.0, 1.0))?;
    in_range("limits.setpoint_k", raw.setpoint_k, "K", (0.0, 30.0))?;
    in_range("limits.feed_rate", raw.feed_rate, "-", (1e-4, 1.0))?;
    in_range("limits.speed_rate", raw.speed_rate, "-", (1e-4, 1.0))?;
    in_range("limits.setpoint_rate_k", raw.setpoint_rate_k, "K", (0.001, 100.0))?;
    in_range("limits.force_margin", raw.force_margin, "-", (0.01, 1.0))?;
    Ok(())
}

pub(super) fn base(raw: &RawBase) -> Result<(), ParamError> {
    in_range("base.averaging_s", raw.averaging_s, "s", (1.0, 600.0))?;
    in_range("base.first_s", raw.first_s, "s", (0.1, 60.0))?;
    in_range("base.rate_1_s", raw.rate_1_s, "1/s", (1e-5, 0.1))?;
    in_range("base.limit", raw.limit, "-", (0.0, 0.2))?;
    Ok(())
}

/// Integral action under delay: the gain per frame must stay below the limit of model book 1.7.
pub(super) fn trims(raw: &RawTrims) -> Result<(), ParamError> {
    in_range("trims.feed_gain", raw.feed_gain, "-", (0.0, 1.0))?;
    in_range("trims.speed_gain", raw.speed_gain, "-", (0.0, 1.0))?;
    in_range("trims.frame_period_s", raw.frame_period_s, "s", (0.01, 60.0))?;
    in_range("trims.delay_s", raw.delay_s, "s", (0.0, 60.0))?;
    in_range("trims.transient", raw.transient, "-", (0.0, 1.0))?;
    in_range("trims.transient_slowed", raw.transient_slowed, "-", (0.0, 1.0))?;
    in_range("trims.transient_settled", raw.transient_settled, "-", (0.0, 1.0))?;
    in_range("trims.transient_speed", raw.transient_speed, "-", (0.0, 1.0))?;
    in_range("trims.transient_lags", raw.transient_lags, "lags", (0.0, 20.0))?;
    in_range("trims.steady_s", raw.steady_s, "s", (0.0, 10.0))?;
    in_range("trims.steady_clogged_s", raw.steady_clogged_s, "s", (0.0, 10.0))?;
    in_range("trims.speed_spread", raw.speed_spread, "-", (0.0, 1.0))?;
    let limit = loop_gain_limit((raw.delay_s / raw.frame_period_s).ceil());
    if raw.feed_gain + raw.speed_gain < limit {
        return Ok(());
    }
    let (name, value, other, other_value) = if raw.speed_gain < limit {
        ("trims.feed_gain", raw.feed_gain, "trims.speed_gain", raw.speed_gain)
    } else {
        ("trims.speed_gain", raw.speed_gain, "trims.feed_gain", raw.feed_gain)
    };
    let rule = format!(
        "below {limit:.3} together with {other} = {other_value}: 2 sin(pi / (2 (2 d + 1))), d = delay_s / frame_period_s frames"
    );
    Err(ParamError::OutOfRange { name, value, unit: "-", rule })
}

pub(super) fn slip(raw: &RawSlip) -> Result<(), ParamError> {
    in_range("slip.low", raw.low, "-", (-0.5, 0.0))?;
    in_range("slip.high", raw.high, "-", (0.0, 0.9))?;
    in_range("slip.serial_gain_1_s", raw.serial_gain_1_s, "1/s", (0.0, 5.0))?;
    in_range("slip.serial_limit", raw.serial_limit, "-", (0.0, 0.5))?;
    in_range("slip.serial_smooths_s", raw.serial_smooths_s, "s", (1e-3, 1e3))?;
    in_range("slip.serial_learns_s", raw.serial_learns_s, "s", (1.0, 1e6))?;
    in_range("slip.pairing_s", raw.pairing_s, "s", (0.001, 10.0))?;
    in_range("slip.wanted_jump_m", raw.wanted_jump_m, "m", (1e-4, 10.0))?;
    Ok(())
}

pub(super) fn health(raw: &RawHealth) -> Result<(), ParamError> {
    in_range("health.late_max", f64::from(raw.late_max), "plans", (1.0, 20.0))?;
    in_range("health.saturated_s", raw.saturated_s, "s", (1.0, 600.0))?;
    in_range("health.duty_stop", raw.duty_stop, "-", (0.5, 1.0))?;
    in_range("health.margin", raw.margin, "-", (0.0, 0.1))?;
    Ok(())
}
