//! System 1: fast trims and model predictive controller.

use serde_json::Value;

use super::vector::{Handler, Inputs, Set};

/// Functions that `mpc_controller` does not offer yet: their vectors fail until they are called here.
const AWAITED: [&str; 2] = ["trims", "mpc_step"];

pub(crate) fn handler(function: &str) -> Option<Handler> {
    AWAITED.contains(&function).then_some(awaited as Handler)
}

fn awaited(_set: &Set, _given: Inputs<'_>) -> Result<Value, String> {
    Err("awaited from mpc_controller, not wired in yet".into())
}
