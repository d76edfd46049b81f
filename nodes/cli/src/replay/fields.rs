//! Fields in which two messages differ.

use crate::report::decode::decode;
use fdm_loop_msgs::{
    AdvancePrediction, BeadWidth, ControlCommand, DefectReport, LayerQuality, MotionTrim, PrintEvent,
    RosType, StateEstimate,
};
use runtime::topics;
use serde_json::Value;
use std::collections::BTreeMap;

/// A message as a tree of values.
pub(super) fn value(topic: &str, payload: &[u8]) -> Option<Value> {
    fn of<T: RosType>(payload: &[u8]) -> Option<Value> {
        serde_json::to_value(decode::<T>(payload)?).ok()
    }
    match topic {
        name if name == topics::ESTIMATE.name() => of::<StateEstimate>(payload),
        name if name == topics::CONTROL_SCHEDULE.name() || name == topics::SAFETY_SCHEDULE.name() => {
            of::<MotionTrim>(payload)
        }
        name if name == topics::EVENTS.name() => of::<PrintEvent>(payload),
        name if name == topics::ADVANCE_PREDICTION.name() => of::<AdvancePrediction>(payload),
        name if name == topics::DEFECTS.name() => of::<DefectReport>(payload),
        name if name == topics::BEAD_WIDTH.name() => of::<BeadWidth>(payload),
        name if name == topics::LAYER_QUALITY.name() => of::<LayerQuality>(payload),
        _ => of::<ControlCommand>(payload),
    }
}

/// Size of a difference, and both values.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Found {
    pub(super) size: f64,
    pub(super) values: (Value, Value),
}

/// Numbers that are nearer to each other differ by what summing in another order leaves `[-]`.
const ROUND_OFF: f64 = 1e-12;

/// Whether two values that differ are the same number but for round-off.
pub(super) fn is_round_off((before, after): &(Value, Value)) -> bool {
    before
        .as_f64()
        .zip(after.as_f64())
        .is_some_and(|(before, after)| (before - after).abs() <= ROUND_OFF * before.abs().max(after.abs()))
}

/// Fields in which two messages differ. Elements of a list count as one field, the largest of them; but for the estimate's `x`,
/// whose states are of different units: each is one by its name.
pub(super) fn differences(path: &str, left: &Value, right: &Value, found: &mut BTreeMap<String, Found>) {
    let below = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
    match (left, right) {
        (Value::Object(one), Value::Object(other)) => {
            let states = one.get("names").and_then(Value::as_array);
            for (name, value) in one {
                let Some(counterpart) = other.get(name) else { continue };
                match (states, value.as_array(), counterpart.as_array()) {
                    (Some(states), Some(value), Some(counterpart)) if name == "x" => {
                        for ((state, value), counterpart) in states.iter().zip(value).zip(counterpart) {
                            let path = below(&format!("x.{}", state.as_str().unwrap_or_default()));
                            differences(&path, value, counterpart, found);
                        }
                    }
                    _ => differences(&below(name), value, counterpart, found),
                }
            }
        }
        (Value::Array(one), Value::Array(other)) if one.len() == other.len() => {
            for (value, counterpart) in one.iter().zip(other) {
                differences(path, value, counterpart, found);
            }
        }
        _ if left == right => {}
        _ => {
            let size = match (left.as_f64(), right.as_f64()) {
                (Some(one), Some(other)) => (one - other).abs(),
                // What is no number differs or does not.
                _ => 1.0,
            };
            let this = Found { size, values: (left.clone(), right.clone()) };
            let known = found.entry(path.to_owned()).or_insert_with(|| this.clone());
            if size > known.size {
                *known = this;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::wire::STATES;

    /// 2 K of the block and 1 um/s of the flow are no one figure.
    #[test]
    fn each_state_is_a_field_by_its_name_and_unit() {
        let estimate = |x: [f64; 6]| StateEstimate {
            names: STATES.map(str::to_owned).to_vec(),
            x: x.to_vec(),
            covariance: vec![x[0]; 36],
            ..StateEstimate::default()
        };
        let [one, other] = [[480.0, 475.0, 483.0, 2e-3, 0.0, 1.0], [482.0, 475.0, 483.0, 2.001e-3, 0.0, 1.0]]
            .map(|x| serde_json::to_value(estimate(x)).unwrap());
        let mut found = BTreeMap::new();
        differences("", &one, &other, &mut found);
        assert_eq!(found.keys().collect::<Vec<_>>(), ["covariance", "x.block_k", "x.flow_m_s"]);
        assert!(
            (found["x.flow_m_s"].size - 1e-6).abs() < 1e-12 && (found["x.block_k"].size - 2.0).abs() < 1e-12
        );
    }

    #[test]
    fn round_off_is_relative() {
        let is = |before: f64, after: f64| is_round_off(&(before.into(), after.into()));
        assert!(is(480.0, 480.0 + 1e-10) && !is(480.0, 480.0 + 1e-9));
        assert!(is(2e-9, 2e-9 + 1e-21) && !is(2e-9, 2.000_1e-9) && !is(0.0, 1e-15));
        assert!(!is_round_off(&(true.into(), false.into())));
    }
}
