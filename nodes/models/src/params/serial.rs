//! A serial line as parameter files write it.

use super::{ParamError, in_range, ordered};
use serde::Deserialize;

/// A serial line and the pauses between tries to open it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawSerialParams")]
pub struct SerialParams {
    /// Device file.
    pub path: String,
    /// Symbols per second `[Bd]`.
    pub baud: u32,
    /// First pause after a lost line `[s]`; it doubles with each try.
    pub retry_min_s: f64,
    /// Longest pause `[s]`.
    pub retry_max_s: f64,
}

/// As [`SerialParams`], as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSerialParams {
    /// Device file.
    pub path: String,
    /// Symbols per second `[Bd]`.
    pub baud: u32,
    /// First pause after a lost line `[s]`; it doubles with each try.
    pub retry_min_s: f64,
    /// Longest pause `[s]`.
    pub retry_max_s: f64,
}

impl TryFrom<RawSerialParams> for SerialParams {
    type Error = ParamError;

    fn try_from(raw: RawSerialParams) -> Result<Self, ParamError> {
        in_range("baud", f64::from(raw.baud), "Bd", (1200.0, 4_000_000.0))?;
        ordered(("retry_min_s", raw.retry_min_s), ("retry_max_s", raw.retry_max_s))?;
        Ok(Self {
            path: raw.path,
            baud: raw.baud,
            retry_min_s: in_range("retry_min_s", raw.retry_min_s, "s", (0.01, 60.0))?,
            retry_max_s: in_range("retry_max_s", raw.retry_max_s, "s", (0.01, 600.0))?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_stand_in_order() {
        let raw = RawSerialParams { path: "x".into(), baud: 115_200, retry_min_s: 0.5, retry_max_s: 8.0 };
        assert!(SerialParams::try_from(raw.clone()).is_ok());
        assert!(SerialParams::try_from(RawSerialParams { retry_min_s: 9.0, ..raw.clone() }).is_err());
        assert!(SerialParams::try_from(RawSerialParams { retry_max_s: f64::NAN, ..raw.clone() }).is_err());
        assert!(SerialParams::try_from(RawSerialParams { baud: 300, ..raw }).is_err());
    }
}
