//! The nominal printer: what the `printer` block of `config/printers/*.yaml` holds, for every node that believes in it.

use serde::Deserialize;

use crate::bed::Bed;
use crate::extruder::Extruder;
use crate::hotend::Hotend;
use crate::latent::Cooling;

/// The `printer` block. Each part checks its own numbers.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Printer {
    /// Hot end.
    pub hotend: Hotend,
    /// Bed.
    pub bed: Bed,
    /// Extruder.
    pub extruder: Extruder,
    /// Cooling of a road.
    pub cooling: Cooling,
}
