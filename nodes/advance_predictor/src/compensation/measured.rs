//! Lines that a person printed and scored.

use models::advance::{Condition, DriveKind};

/// One measured line.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Drive.
    pub drive: DriveKind,
    /// Polymer, in capitals as in `config/advance/physics.yaml`.
    pub polymer: String,
    /// Condition.
    pub at: Condition,
    /// Best `K_A` of the pattern `[s]`.
    pub advance_s: f64,
}
