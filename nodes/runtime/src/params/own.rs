//! Parameters that belong to the runtime: they hold from the start of the process to its end.

use super::ParamFileError;
use super::tree::{Origin, Tree};
use serde_json::Value;

/// Name of the parameter that chooses the clock.
pub(super) const USE_SIM_TIME: &str = "use_sim_time";
/// Name of the parameter by which a node goes to active by itself. It changes nothing of what the node does there, so
/// it stands outside of text and hash.
pub(super) const AUTOSTART: &str = "autostart";
/// All of them.
pub(super) const OWN: [&str; 2] = [AUTOSTART, USE_SIM_TIME];

/// Takes a boolean out of the root.
pub(super) fn flag(merged: &mut Tree, name: &str, default: bool) -> Result<bool, ParamFileError> {
    match merged.take(name) {
        None => Ok(default),
        Some((Tree::Leaf(Value::Bool(value)), _)) => Ok(value),
        Some((other, origin)) => Err(refused(&origin, name, &other.to_json())),
    }
}

/// A value of the wrong kind.
fn refused(origin: &Origin, name: &str, value: &Value) -> ParamFileError {
    ParamFileError::Refused {
        at: origin.to_string(),
        message: format!("{name} = {value}: must be a boolean"),
    }
}
