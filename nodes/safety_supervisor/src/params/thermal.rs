//! Numbers of the thermal checks.

use models::params::{ParamError, in_range, ordered};
use serde::Deserialize;

/// Passes a count inside `[1, high]`.
pub(super) fn count(name: &'static str, value: u32, high: u32) -> Result<u32, ParamError> {
    in_range(name, f64::from(value), "-", (1.0, f64::from(high))).map(|_| value)
}

/// S1: possible range of a temperature.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawRangeParams")]
pub struct RangeParams {
    /// Lowest reading of a sound, connected thermistor `[degC]`.
    pub min_c: f64,
    /// Highest temperature the hardware may reach `[degC]`.
    pub max_c: f64,
    /// Samples in a row outside until it trips `[-]`.
    pub samples: u32,
}

/// As [`RangeParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawRangeParams {
    /// Lowest reading of a sound, connected thermistor `[degC]`.
    pub min_c: f64,
    /// Highest temperature the hardware may reach `[degC]`.
    pub max_c: f64,
    /// Samples in a row outside until it trips `[-]`.
    pub samples: u32,
}

impl TryFrom<RawRangeParams> for RangeParams {
    type Error = ParamError;

    fn try_from(raw: RawRangeParams) -> Result<Self, ParamError> {
        ordered(("min_c", raw.min_c), ("max_c", raw.max_c))?;
        Ok(Self {
            min_c: in_range("min_c", raw.min_c, "degC", (-50.0, 100.0))?,
            max_c: in_range("max_c", raw.max_c, "degC", (50.0, 500.0))?,
            samples: count("samples", raw.samples, 20)?,
        })
    }
}

/// S2: a reading that stands still.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawFrozenParams")]
pub struct FrozenParams {
    /// Span after which the balance of a still reading is not judged any more `[s]`.
    pub suspect_s: f64,
    /// Span that trips with the heater at its stop or the balance moving `[s]`.
    pub short_s: f64,
    /// Span that trips with the duty varying `[s]`.
    pub middle_s: f64,
    /// Span that trips with the heater in use `[s]`.
    pub long_s: f64,
    /// Change of duty that must move a reading `[-]`.
    pub duty_change: f64,
    /// Duty at its stop `[-]`.
    pub duty_stop: f64,
    /// Duty of a heater in use `[-]`.
    pub duty_in_use: f64,
    /// Change by the energy balance that must move a reading `[K]`.
    pub moved_k: f64,
    /// Temperature up to which a block without power may be as warm as its room `[degC]`.
    pub room_max_c: f64,
}

/// As [`FrozenParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawFrozenParams {
    /// Span after which the balance of a still reading is not judged any more `[s]`.
    pub suspect_s: f64,
    /// Span that trips with the heater at its stop or the balance moving `[s]`.
    pub short_s: f64,
    /// Span that trips with the duty varying `[s]`.
    pub middle_s: f64,
    /// Span that trips with the heater in use `[s]`.
    pub long_s: f64,
    /// Change of duty that must move a reading `[-]`.
    pub duty_change: f64,
    /// Duty at its stop `[-]`.
    pub duty_stop: f64,
    /// Duty of a heater in use `[-]`.
    pub duty_in_use: f64,
    /// Change by the energy balance that must move a reading `[K]`.
    pub moved_k: f64,
    /// Temperature up to which a block without power may be as warm as its room `[degC]`.
    pub room_max_c: f64,
}

impl TryFrom<RawFrozenParams> for FrozenParams {
    type Error = ParamError;

    fn try_from(raw: RawFrozenParams) -> Result<Self, ParamError> {
        Ok(Self {
            suspect_s: in_range("suspect_s", raw.suspect_s, "s", (0.2, 60.0))?,
            short_s: in_range("short_s", raw.short_s, "s", (0.2, 60.0))?,
            middle_s: in_range("middle_s", raw.middle_s, "s", (0.2, 60.0))?,
            long_s: in_range("long_s", raw.long_s, "s", (0.2, 120.0))?,
            duty_change: in_range("duty_change", raw.duty_change, "-", (0.001, 1.0))?,
            duty_stop: in_range("duty_stop", raw.duty_stop, "-", (0.5, 1.0))?,
            duty_in_use: in_range("duty_in_use", raw.duty_in_use, "-", (0.0, 1.0))?,
            moved_k: in_range("moved_k", raw.moved_k, "K", (0.1, 50.0))?,
            room_max_c: in_range("room_max_c", raw.room_max_c, "degC", (20.0, 100.0))?,
        })
    }
}
