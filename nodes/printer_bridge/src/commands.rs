//! Commands come with the command side; this is its place, and it is empty.
//!
//! What will stand here: the permits of `safety/command` through [`models::command::Gate`] and
//! [`models::command::DeadMan`] (250 ms without a permit: back to the slicer's values), clamped by the bridge's own
//! limits, written by one formatter from one typed enum, each confirmed by read-back with a time limit, none sent
//! twice; the first command after a start restores the slicer's values. M112 passes a busy Marlin only with
//! `EMERGENCY_PARSER`, which the bridge finds out at its start.
//!
//! Until then [`Access`] has one value, and the bridge sends nothing but the questions of
//! [`Question`](crate::asking::Question), none of which changes a print.

use serde::Deserialize;

/// What the bridge may do to the printer, from `read_only`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(try_from = "bool")]
pub enum Access {
    /// Asks and listens.
    ReadOnly,
}

/// Writing was asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("read_only = false: the bridge sends no commands yet; set it to true")]
pub struct NoCommandSide;

impl TryFrom<bool> for Access {
    type Error = NoCommandSide;

    fn try_from(read_only: bool) -> Result<Self, NoCommandSide> {
        if read_only { Ok(Self::ReadOnly) } else { Err(NoCommandSide) }
    }
}
