//! System 1: soft and hard states of the fused confidence.

use safety_supervisor::attention::levels;
use safety_supervisor::params::{AttentionParams, RawAttentionParams};
use serde_json::{Value, json};

use super::vector::{Handler, Inputs, Set};

pub(crate) fn handler(function: &str) -> Option<Handler> {
    (function == "supervisor").then_some(supervisor as Handler)
}

fn supervisor(_set: &Set, given: Inputs<'_>) -> Result<Value, String> {
    let params = AttentionParams::try_from(RawAttentionParams {
        soft: given.num("soft")?,
        hard: given.num("hard")?,
        hysteresis: given.num("hyst")?,
        n_soft: given.count("n_soft")?,
        n_hard: given.count("n_hard")?,
        n_off: given.count("n_off")?,
    })
    .map_err(|error| format!("refused: {error}"))?;
    Ok(json!({"state": levels(params, &given.nums("c")?)}))
}
