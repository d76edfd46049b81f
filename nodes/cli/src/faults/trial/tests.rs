//! What counts as a reaction, and what may not follow.

use super::super::catalogue::Catalogue;
use super::*;
use crate::config::{Choice, ConfigDir};
use crate::sim;
use crate::sim::relay::Tampering;
use serde_json::{Value, json};
use std::path::Path;

/// A printer that waits hot beside a supervisor that sends no correction: time until it is at the slicer's values.
fn baseline_s(relay: &Value) -> Option<f64> {
    let config = ConfigDir::find(Some(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config"))).unwrap();
    let spec: TrialSpec = serde_json::from_value(json!({
        "name": "permits", "job": "hot", "onset": {"after": "start", "time_s": 1.0}, "limit_s": 0.25,
        "set": {"safety_supervisor": {"start_mode": "observe"}}, "relay": relay,
    }))
    .unwrap();
    let file = Catalogue::read(&config.file("faults.yaml")).unwrap().jobs["hot"].load(&config).unwrap();
    let overrides = spec.overrides();
    let choice = Choice { overrides, ..Choice::of(file.material(), sim::level(&spec.control).unwrap()) };
    let setup = config.load(&choice).unwrap();
    let trial = Trial { spec: &spec, reaction: Reaction::Baseline, setup: &setup, file: &file, warm: true };
    trial.run(1).unwrap().reaction_s
}

/// C2: the dead-man is what is measured. Values that nobody had corrected are the slicer's without it.
#[test]
fn the_slicers_values_count_where_the_dead_man_has_brought_them() {
    assert_eq!(baseline_s(&json!([])), None, "permits come, nothing lapses");
    let reaction_s = baseline_s(&json!([{"lanes": ["permit"], "how": "lose"}])).unwrap();
    assert!((0.1..=0.25).contains(&reaction_s), "{reaction_s}");
}

/// DEGRADED takes corrections back within 2 s: what is in force later is too much, what is on its way is not.
#[test]
fn corrections_that_outlive_their_ramp_are_too_much() {
    let left = Trims { flow: 1.001, ..Trims::NEUTRAL };
    for (degraded_s, trims, kept) in [
        (None, left, false),
        (Some(0.0), left, false),
        (Some(RAMP_S), left, false),
        (Some(RAMP_S + 0.02), left, true),
        (Some(RAMP_S + 0.02), Trims::NEUTRAL, false),
    ] {
        assert_eq!(kept_too_long(degraded_s, &trims).is_some(), kept, "{degraded_s:?} {trims:?}");
    }
}

/// C6: what is on its way is not kept.
#[test]
fn corrections_may_outlive_their_ramp_by_what_the_way_keeps_back() {
    let keeps_back_s = |how: Value, share: f64| {
        let relay = json!({"lanes": ["permit"], "how": how, "share": share});
        let relay: Tampering = serde_json::from_value(relay).unwrap();
        [Lane::Permit, Lane::Hotend].map(|lane| relay.keeps_back_s(lane))
    };
    assert_eq!(keeps_back_s(json!({"delay": [0.05, 0.5]}), 1.0), [0.5, 0.0]);
    assert_eq!(keeps_back_s(json!("lose"), 1.0), [f64::INFINITY, 0.0]);
    assert_eq!(keeps_back_s(json!("lose"), 0.3), [0.2, 0.0]);
    assert_eq!(keeps_back_s(json!("repeat"), 1.0), [0.0, 0.0]);
}
