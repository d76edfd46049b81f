//! Rows of the paper's Tables 1 and 2, as `config/machines/published.yaml` holds them: data to compare with, not parameters.

use serde::Deserialize;

/// Both tables.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Radius of the paper's hemisphere `[m]`.
    pub radius_m: f64,
    /// Motor angle of Table 1 `[deg]`.
    pub table_1_angle_deg: f64,
    /// Table 1: error over the height.
    pub table_1: Vec<OverHeight>,
    /// Height of Table 2 `[m]`.
    pub table_2_height_m: f64,
    /// Table 2: error over the motor's angle.
    pub table_2: Vec<OverAngle>,
}

/// One row of Table 1.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OverHeight {
    /// Height on the hemisphere `[m]`.
    pub height_m: f64,
    /// Largest error along the normal as printed `[m]`.
    pub error_m: f64,
}

/// One row of Table 2.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OverAngle {
    /// Angle as printed `[deg]`.
    pub angle_deg: f64,
    /// The angle that we take to be meant, 1.8 degrees over a power of two `[deg]`; absent where printed exactly.
    #[serde(default)]
    pub read_as_deg: Option<f64>,
    /// Largest error along the normal as printed `[m]`.
    pub error_m: f64,
}
