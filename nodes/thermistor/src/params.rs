//! Every number of the node, as in `config/thermistor.param.yaml`.

use models::params::{ParamError, SerialParams, in_range, ordered};
use serde::Deserialize;

/// All parameters.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Where the reports come from.
    pub driver: Driver,
    /// The serial line, for the driver `serial`.
    pub serial: SerialParams,
    /// Hot end.
    pub hotend: ChannelParams,
    /// Bed.
    pub bed: ChannelParams,
    /// A sensor in the nozzle is fitted; what is reported of one that is not is left alone.
    pub nozzle_fitted: bool,
    /// Sensor in the nozzle.
    pub nozzle: ChannelParams,
}

/// One thermistor.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawChannelParams")]
pub struct ChannelParams {
    /// Lowest reading that a table can give, a broken circuit included `[degC]`.
    pub min_c: f64,
    /// Highest reading that a table can give, a short circuit included `[degC]`.
    pub max_c: f64,
    /// Rate beyond which a sample is marked as fast `[K/s]`.
    pub rate_max_k_s: f64,
    /// Noise, standard deviation `[K]`.
    pub sigma_k: f64,
    /// Step of the converter; 0 where it is fine `[K]`.
    pub quantum_k: f64,
    /// How far ahead of the clock a stamp may be `[s]`.
    pub stamp_future_max_s: f64,
    /// How old a report may be `[s]`.
    pub stamp_age_max_s: f64,
}

/// As [`ChannelParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawChannelParams {
    /// Lowest reading that a table can give, a broken circuit included `[degC]`.
    pub min_c: f64,
    /// Highest reading that a table can give, a short circuit included `[degC]`.
    pub max_c: f64,
    /// Rate beyond which a sample is marked as fast `[K/s]`.
    pub rate_max_k_s: f64,
    /// Noise, standard deviation `[K]`.
    pub sigma_k: f64,
    /// Step of the converter; 0 where it is fine `[K]`.
    pub quantum_k: f64,
    /// How far ahead of the clock a stamp may be `[s]`.
    pub stamp_future_max_s: f64,
    /// How old a report may be `[s]`.
    pub stamp_age_max_s: f64,
}

impl TryFrom<RawChannelParams> for ChannelParams {
    type Error = ParamError;

    fn try_from(raw: RawChannelParams) -> Result<Self, ParamError> {
        ordered(("min_c", raw.min_c), ("max_c", raw.max_c))?;
        Ok(Self {
            min_c: in_range("min_c", raw.min_c, "degC", (-100.0, 100.0))?,
            max_c: in_range("max_c", raw.max_c, "degC", (50.0, 1000.0))?,
            rate_max_k_s: in_range("rate_max_k_s", raw.rate_max_k_s, "K/s", (0.1, 1000.0))?,
            sigma_k: in_range("sigma_k", raw.sigma_k, "K", (0.0, 10.0))?,
            quantum_k: in_range("quantum_k", raw.quantum_k, "K", (0.0, 10.0))?,
            stamp_future_max_s: in_range("stamp_future_max_s", raw.stamp_future_max_s, "s", (0.0, 10.0))?,
            stamp_age_max_s: in_range("stamp_age_max_s", raw.stamp_age_max_s, "s", (0.01, 60.0))?,
        })
    }
}

/// Where the reports come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Driver {
    /// Reports of the printer, over a topic: from a bridge or the simulator.
    Printer,
    /// A serial line of its own.
    Serial,
}
