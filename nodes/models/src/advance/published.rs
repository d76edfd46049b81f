//! The seven `K_A` that the paper prints, as `config/advance/published.yaml` holds them: data to compare with, never
//! trained with. The direct ones are from the paper's reference 1.

use serde::Deserialize;

use super::drive::DriveKind;
use crate::params::{ParamError, in_range};

/// All points. Built only from a valid [`RawPublished`], whose fields it shows.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawPublished")]
pub struct Published(RawPublished);

read_only!(Published(RawPublished));

/// The block `advance_published` as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawPublished {
    /// Polymer, by its name in the parameters.
    pub polymer: String,
    /// Temperature `[degC]`, in `[100, 400]`.
    pub temperature_c: f64,
    /// Width of the line `[m]`, in `[1e-5, 0.01]`.
    pub width_m: f64,
    /// The points.
    pub points: Vec<Point>,
}

/// One point.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// Drive.
    pub drive: DriveKind,
    /// Layer height `[m]`, in `[1e-5, 5e-3]`.
    pub height_m: f64,
    /// `K_A` as printed `[s]`, in `[1e-3, 5]`.
    pub advance_s: f64,
}

impl TryFrom<RawPublished> for Published {
    type Error = ParamError;

    fn try_from(raw: RawPublished) -> Result<Self, ParamError> {
        in_range("temperature_c", raw.temperature_c, "degC", (100.0, 400.0))?;
        in_range("width_m", raw.width_m, "m", (1e-5, 1e-2))?;
        for point in &raw.points {
            in_range("height_m", point.height_m, "m", (1e-5, 5e-3))?;
            in_range("advance_s", point.advance_s, "s", (1e-3, 5.0))?;
        }
        Ok(Self(raw))
    }
}
