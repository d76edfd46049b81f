//! Every number of the node, as in `config/printer_bridge.param.yaml`.

use crate::commands::Access;
use models::params::{ParamError, SerialParams, in_range};
use serde::Deserialize;

/// All parameters.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Who drives the printer.
    pub host: Host,
    /// What the bridge may do.
    pub read_only: Access,
    /// The serial line.
    pub serial: SerialParams,
    /// How Marlin is asked and read.
    pub marlin: MarlinParams,
}

/// Who drives the printer, and so how it is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(try_from = "HostName")]
pub enum Host {
    /// Marlin on a serial line of this process alone: prints from its card, or none.
    MarlinSerial,
}

/// As [`Host`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HostName {
    /// Marlin on a serial line.
    MarlinSerial,
    /// Klipper behind Moonraker.
    Moonraker,
    /// A printer behind OctoPrint.
    Octoprint,
}

/// A host that is not reached yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum HostError {
    /// Klipper speaks to its own host alone.
    #[error(
        "host = moonraker: not built yet, and Klipper has no other way in; leave printer_bridge out, or use marlin_serial on a Marlin printer"
    )]
    Moonraker,
    /// OctoPrint holds the port.
    #[error(
        "host = octoprint: not built yet; disconnect OctoPrint from the printer (two programs cannot share its port) and use marlin_serial"
    )]
    Octoprint,
}

impl TryFrom<HostName> for Host {
    type Error = HostError;

    fn try_from(name: HostName) -> Result<Self, HostError> {
        match name {
            HostName::MarlinSerial => Ok(Self::MarlinSerial),
            HostName::Moonraker => Err(HostError::Moonraker),
            HostName::Octoprint => Err(HostError::Octoprint),
        }
    }
}

/// How Marlin is asked and read.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawMarlinParams")]
pub struct MarlinParams(RawMarlinParams);

/// As [`MarlinParams`], as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawMarlinParams {
    /// Pause after the line was opened, for a board that restarts then `[s]`; a greeting ends it.
    pub greeting_s: f64,
    /// Period of temperature reports (M155, or M105 where that is not there) `[s]`.
    pub temperature_period_s: u8,
    /// Period of the questions for the position (M114) and the card (M27) `[s]`.
    pub question_period_s: f64,
    /// Whether the position is asked for in a print: only for a Marlin that answers without emptying its planner.
    pub position_while_printing: bool,
    /// Silence after a question beyond which it is taken for lost `[s]`; `busy:` begins it anew.
    pub answer_limit_s: f64,
    /// Silence beyond which nothing is known any more `[s]`.
    pub stale_after_s: f64,
    /// Period of the state `[s]`.
    pub state_period_s: f64,
    /// Value of `@:` at full power `[-]`.
    pub duty_full: f64,
    /// Highest set-point that can be meant `[degC]`.
    pub target_max_c: f64,
    /// Largest coordinate that can be meant `[m]`.
    pub position_max_m: f64,
}

impl std::ops::Deref for MarlinParams {
    type Target = RawMarlinParams;

    fn deref(&self) -> &RawMarlinParams {
        &self.0
    }
}

impl TryFrom<RawMarlinParams> for MarlinParams {
    type Error = ParamError;

    fn try_from(raw: RawMarlinParams) -> Result<Self, ParamError> {
        in_range("greeting_s", raw.greeting_s, "s", (0.0, 30.0))?;
        in_range("temperature_period_s", f64::from(raw.temperature_period_s), "s", (1.0, 60.0))?;
        in_range("question_period_s", raw.question_period_s, "s", (0.2, 60.0))?;
        in_range("answer_limit_s", raw.answer_limit_s, "s", (0.5, 60.0))?;
        in_range("stale_after_s", raw.stale_after_s, "s", (0.5, 60.0))?;
        in_range("state_period_s", raw.state_period_s, "s", (0.02, 1.0))?;
        in_range("duty_full", raw.duty_full, "-", (1.0, 65535.0))?;
        in_range("target_max_c", raw.target_max_c, "degC", (100.0, 600.0))?;
        in_range("position_max_m", raw.position_max_m, "m", (0.1, 10.0))?;
        Ok(Self(raw))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHIPPED: &str = include_str!("../../../config/printer_bridge.param.yaml");

    #[derive(Debug, Deserialize)]
    struct File {
        #[serde(rename = "/**")]
        all: Block,
    }

    #[derive(Debug, Deserialize)]
    struct Block {
        #[serde(rename = "ros__parameters")]
        parameters: Params,
    }

    fn read(text: &str) -> Result<Params, String> {
        // The frames are no business of the bridge's parameters: the node takes them out.
        let own = text.split("    frames:").next().unwrap();
        serde_saphyr::from_str::<File>(own).map(|file| file.all.parameters).map_err(|error| error.to_string())
    }

    #[test]
    fn the_shipped_file_is_valid_and_read_only() {
        let params = read(SHIPPED).unwrap();
        assert_eq!((params.host, params.read_only), (Host::MarlinSerial, Access::ReadOnly));
    }

    #[test]
    fn hosts_to_come_and_writing_are_refused_with_what_to_do() {
        for (wish, answer) in [
            (("host: marlin_serial", "host: moonraker"), "use marlin_serial on a Marlin printer"),
            (("host: marlin_serial", "host: octoprint"), "disconnect OctoPrint"),
            (("read_only: true", "read_only: false"), "set it to true"),
            (("duty_full: 127", "duty_full: .nan"), "duty_full"),
            (("temperature_period_s: 1", "temperature_period_s: 0"), "temperature_period_s"),
        ] {
            assert!(SHIPPED.contains(wish.0), "{}", wish.0);
            let error = read(&SHIPPED.replace(wish.0, wish.1)).unwrap_err();
            assert!(error.contains(answer), "{error}");
        }
    }
}
