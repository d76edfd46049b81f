//! Parameters that belong to the runtime: they hold from the start of the process to its end.

use super::ParamFileError;
use super::tree::{Origin, Tree};
use serde_json::Value;

/// Name of the parameter that chooses the clock.
pub(super) const USE_SIM_TIME: &str = "use_sim_time";
/// Name of the parameter by which a node goes to active by itself. It changes nothing of what the node does there, so
/// it stands outside of text and hash.
pub(super) const AUTOSTART: &str = "autostart";
/// Name of the parameter with the nodes that have to be active before this one goes there by itself. Outside of text and
/// hash too.
pub(super) const START_AFTER: &str = "start_after";
/// All of them.
pub(super) const OWN: [&str; 3] = [AUTOSTART, START_AFTER, USE_SIM_TIME];

/// What is said of one of them.
pub(super) fn description(name: &str) -> &'static str {
    match name {
        AUTOSTART => "whether the node configures and activates itself when its process starts",
        START_AFTER => "names of the nodes that have to be active before this one activates itself",
        USE_SIM_TIME => "time from /clock instead of the host's monotonic clock",
        _ => "",
    }
}

/// Takes a boolean out of the root.
pub(super) fn flag(merged: &mut Tree, name: &str, default: bool) -> Result<bool, ParamFileError> {
    match merged.take(name) {
        None => Ok(default),
        Some((Tree::Leaf(Value::Bool(value)), _)) => Ok(value),
        Some((other, origin)) => Err(refused(&origin, (name, &other.to_json()), "a boolean")),
    }
}

/// Takes a list of names out of the root.
pub(super) fn names(merged: &mut Tree, name: &str) -> Result<Vec<String>, ParamFileError> {
    let Some((tree, origin)) = merged.take(name) else { return Ok(Vec::new()) };
    let value = tree.to_json();
    let list = value.as_array().and_then(|list| {
        list.iter().map(|item| item.as_str().map(str::to_owned)).collect::<Option<Vec<String>>>()
    });
    list.ok_or_else(|| refused(&origin, (name, &value), "a list of names"))
}

/// A value of the wrong kind.
fn refused(origin: &Origin, (name, value): (&str, &Value), rule: &str) -> ParamFileError {
    let value = crate::args::short(&value.to_string());
    ParamFileError::Refused { at: origin.to_string(), message: format!("{name} = {value}: must be {rule}") }
}
