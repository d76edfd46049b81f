//! Parameters of the node.

use crate::compensation::Bounds;
use models::advance::DriveKind;
use serde::Deserialize;

/// All of `config/advance_predictor.param.yaml`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Drive of the printer.
    pub drive: DriveKind,
    /// Polymer that is printed.
    pub polymer: String,
    /// Bounds of what is answered.
    pub bounds: Bounds,
}
