//! The nominal process as plan, controller and printer believe it: `config/wire/process.yaml`.

use serde::Deserialize;

use super::{Feed, Law, Limits};

/// The `wire_process` block.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Process {
    /// Name of the metal, a block of `config/wire/materials.yaml`.
    pub material: String,
    /// Wire and power.
    pub feed: Feed,
    /// Planned layer, planned speeds and the correction law.
    pub law: Law,
    /// What drives and laser can do.
    pub limits: Limits,
}
