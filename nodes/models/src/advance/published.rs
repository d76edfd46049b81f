//! The seven `K_A` that the paper prints, as `config/advance/published.yaml` holds them: data to compare with, never
//! trained with. The direct ones are from the paper's reference 1.

use serde::Deserialize;

use super::drive::DriveKind;

/// All points.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Polymer, by its name in the parameters.
    pub polymer: String,
    /// Temperature `[degC]`.
    pub temperature_c: f64,
    /// Width of the line `[m]`.
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
    /// Layer height `[m]`.
    pub height_m: f64,
    /// `K_A` as printed `[s]`.
    pub advance_s: f64,
}
