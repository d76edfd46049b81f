//! Rows of the paper's Tables 1 and 2, as `config/wire/published.yaml` holds them: data to compare with, no parameters.

use serde::Deserialize;

/// The rows of both tables.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Dip first, then bump.
    pub rows: Vec<Row>,
}

/// One row of Table 1 or 2.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    /// Number of the table.
    pub table: u32,
    /// Height as printed `[m]`.
    pub height_m: f64,
    /// Height that we read instead, a hypothesis `[m]`; absent where the printed one fits.
    #[serde(default)]
    pub read_as_m: Option<f64>,
    /// Speed of the wire as printed `[m/s]`.
    pub wire_m_s: f64,
    /// Speed of the head as printed `[m/s]`.
    pub head_m_s: f64,
}
