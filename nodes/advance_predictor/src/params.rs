//! Parameters of the node.

use crate::compensation::Bounds;
use crate::turn::TurnParams;
use models::advance::{Condition, DriveKind};
use models::params::{ParamError, in_range};
use models::units::Seconds;
use serde::Deserialize;
use std::path::PathBuf;

/// All of `config/advance_predictor.param.yaml`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Drive of the printer.
    pub drive: DriveKind,
    /// Polymer that is printed.
    pub polymer: String,
    /// Files of the networks.
    pub models: Files,
    /// Bounds of what is answered.
    pub bounds: Bounds,
    /// Changes of the conditions that are answered anew.
    pub steps: Steps,
    /// Time after which an answer is said again.
    #[serde(deserialize_with = "repeat")]
    pub repeat_s: Seconds,
    /// Changes of speed that are printed.
    pub speeds: SpeedParams,
    /// Foresight of turns.
    pub turn: TurnParams,
}

/// A time between 50 ms and 5 s, after which the controller as shipped forgets an answer.
fn repeat<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Seconds, D::Error> {
    let repeat_s = f64::deserialize(deserializer)?;
    in_range("repeat_s", repeat_s, "s", (0.05, 5.0)).map_err(serde::de::Error::custom)?;
    Ok(Seconds(repeat_s))
}

/// Changes of speed that are printed. Built only from a valid [`RawSpeeds`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawSpeeds")]
pub struct SpeedParams {
    /// Printing time after which a change counts `1/e` `[s]`.
    pub(crate) memory_s: f64,
    range: [f64; 2],
}

/// The block `speeds` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSpeeds {
    /// Printing time after which a change counts `1/e` `[s]`.
    pub memory_s: f64,
    /// Least and largest factor on the test line's `K_A` `[-]`; `[1, 1]` leaves it alone.
    pub range: [f64; 2],
}

impl TryFrom<RawSpeeds> for SpeedParams {
    type Error = ParamError;

    fn try_from(raw: RawSpeeds) -> Result<Self, ParamError> {
        in_range("speeds.memory_s", raw.memory_s, "s", (0.1, 3600.0))?;
        in_range("speeds.range", raw.range[0], "-", (0.1, 1.0))?;
        in_range("speeds.range", raw.range[1], "-", (1.0, 5.0))?;
        Ok(Self { memory_s: raw.memory_s, range: raw.range })
    }
}

impl SpeedParams {
    pub(crate) fn bounded(&self, factor: f64) -> f64 {
        factor.clamp(self.range[0], self.range[1])
    }
}

/// Files, relative to the folder that the node is started in.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Files {
    /// Networks of a Bowden drive.
    pub bowden: PathBuf,
    /// Networks of a direct drive.
    pub direct: PathBuf,
    /// Network of turns.
    pub turn: PathBuf,
}

impl Files {
    /// File of a drive's networks.
    #[must_use]
    pub fn of(&self, drive: DriveKind) -> &PathBuf {
        match drive {
            DriveKind::Bowden => &self.bowden,
            DriveKind::Direct => &self.direct,
        }
    }
}

/// Changes of the conditions that are answered anew. Built only from a valid [`RawSteps`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawSteps")]
pub struct Steps(RawSteps);

/// The block `steps` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawSteps {
    /// Of the temperature `[K]`.
    pub temperature_k: f64,
    /// Of the layer's height `[m]`.
    pub height_m: f64,
    /// Of the road's width `[m]`.
    pub width_m: f64,
}

impl TryFrom<RawSteps> for Steps {
    type Error = ParamError;

    fn try_from(raw: RawSteps) -> Result<Self, ParamError> {
        in_range("steps.temperature_k", raw.temperature_k, "K", (1e-3, 20.0))?;
        in_range("steps.height_m", raw.height_m, "m", (1e-8, 1e-4))?;
        in_range("steps.width_m", raw.width_m, "m", (1e-8, 1e-3))?;
        Ok(Self(raw))
    }
}

impl Steps {
    /// Whether two conditions differ by less than a step; a NaN differs.
    pub(crate) fn same(&self, a: &Condition, b: &Condition) -> bool {
        (a.temperature.0 - b.temperature.0).abs() < self.0.temperature_k
            && (a.height_m - b.height_m).abs() < self.0.height_m
            && (a.width_m - b.width_m).abs() < self.0.width_m
    }
}
