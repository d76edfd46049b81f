//! Every number of the node, as in `config/filament_encoder.param.yaml`.

use models::params::{ParamError, SerialParams, in_range};
use serde::Deserialize;

/// What may change while the node is active: how fast a step is believed, not what a count is worth: the position is the
/// sum of all counts.
pub const LIVE: [&str; 2] = ["encoder.speed_max_m_s", "encoder.rebase_after"];

/// All parameters.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Where the reports come from.
    pub driver: Driver,
    /// The serial line, for the driver `serial`.
    pub serial: SerialParams,
    /// The encoder.
    pub encoder: EncoderParams,
}

/// The encoder.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawEncoderParams")]
pub struct EncoderParams {
    /// Filament per count `[m]`.
    pub quantum_m: f64,
    /// Speed beyond which a step is no motion `[m/s]`.
    pub speed_max_m_s: f64,
    /// Refused steps in a row after which the device is taken to have started anew; a whole number `[-]`.
    pub rebase_after: f64,
    /// How far ahead of the clock a stamp may be `[s]`.
    pub stamp_future_max_s: f64,
    /// How old a report may be `[s]`.
    pub stamp_age_max_s: f64,
}

/// As [`EncoderParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawEncoderParams {
    /// Filament per count `[m]`.
    pub quantum_m: f64,
    /// Speed beyond which a step is no motion `[m/s]`.
    pub speed_max_m_s: f64,
    /// Refused steps in a row after which the device is taken to have started anew; a whole number `[-]`.
    pub rebase_after: f64,
    /// How far ahead of the clock a stamp may be `[s]`.
    pub stamp_future_max_s: f64,
    /// How old a report may be `[s]`.
    pub stamp_age_max_s: f64,
}

impl TryFrom<RawEncoderParams> for EncoderParams {
    type Error = ParamError;

    fn try_from(raw: RawEncoderParams) -> Result<Self, ParamError> {
        Ok(Self {
            quantum_m: in_range("quantum_m", raw.quantum_m, "m", (1e-07, 0.001))?,
            speed_max_m_s: in_range("speed_max_m_s", raw.speed_max_m_s, "m/s", (0.01, 1.0))?,
            rebase_after: in_range("rebase_after", raw.rebase_after, "-", (1.0, 100.0))?,
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
