//! What counts as a reaction, and what may not follow.

use super::super::catalogue::Catalogue;
use super::*;
use crate::config::{Choice, ConfigDir};
use crate::sim;
use crate::sim::relay::Tampering;
use serde_json::{Value, json};
use std::path::Path;

/// A printer that waits hot beside a supervisor that sends no correction, and what it came to.
fn waiting(relay: &Value) -> Outcome {
    let config = ConfigDir::find(Some(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config"))).unwrap();
    let spec: TrialSpec = serde_json::from_value(json!({
        "name": "permits", "job": "hot", "onset": {"after": "start", "time_s": 1.0}, "limit_s": 0.25,
        "set": {"safety_supervisor": {"start_mode": "observe"}}, "at_most": "safe_off", "watch_s": 20.0, "relay": relay,
    }))
    .unwrap();
    outcome(&config, &spec, Reaction::Baseline)
}

/// What a trial comes to.
fn outcome(config: &ConfigDir, spec: &TrialSpec, reaction: Reaction) -> Outcome {
    let file = Catalogue::read(&config.file("faults.yaml")).unwrap().jobs["hot"].load(config).unwrap();
    let overrides = spec.overrides();
    let choice = Choice { overrides, ..Choice::of(file.material(), sim::level(&spec.control).unwrap()) };
    let setup = config.load(&choice).unwrap();
    let trial = Trial { spec, reaction, setup: &setup, file: &file, warm: true };
    trial.run(1).unwrap()
}

/// C2: the dead-man is what is measured. Values that nobody had corrected are the slicer's without it.
#[test]
fn the_slicers_values_count_where_the_dead_man_has_brought_them() {
    assert_eq!(waiting(&json!([])).reaction_s, None, "permits come, nothing lapses");
    let reaction_s = waiting(&json!([{"lanes": ["permit"], "how": "lose"}])).reaction_s.unwrap();
    assert!((0.1..=0.25).contains(&reaction_s), "{reaction_s}");
}

/// C4: what comes late may not end what it was to keep up: of a silence of a second, the permits after it do.
#[test]
fn a_reaction_that_has_to_last_and_ends_is_too_much() {
    let config = ConfigDir::find(Some(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config"))).unwrap();
    let too_much = |how: &Value, lasts: bool, duration_s: Option<f64>| {
        let spec = json!({
            "name": "permits", "job": "hot", "onset": {"after": "start", "time_s": 1.0}, "limit_s": 0.25,
            "at_most": "degraded", "watch_s": 8.0, "lasts": lasts, "duration_s": duration_s,
            "set": {"safety_supervisor": {"start_mode": "observe"}}, "relay": [{"lanes": ["permit"], "how": how}],
        });
        outcome(&config, &serde_json::from_value(spec).unwrap(), Reaction::Baseline).too_much
    };
    let lost = json!("lose");
    assert!(too_much(&lost, true, Some(1.0)).is_some_and(|what| what.starts_with("let go after 1.")));
    assert_eq!(too_much(&lost, false, Some(1.0)), None);
    for late_s in [0.4, 5.0] {
        let how = json!({"delay": [late_s, late_s]});
        assert_eq!(too_much(&how, true, None), None, "permits {late_s} s old are refused");
    }
}

/// S7: a stream that only degrades, and after some seconds switches the heaters off.
#[test]
fn what_is_worse_seconds_after_degraded_is_too_much() {
    let config = ConfigDir::find(Some(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config"))).unwrap();
    for (set, worse) in [(json!({}), false), (json!({"stale.encoder.safe_off_s": "6.0"}), true)] {
        let spec = json!({
            "name": "encoder", "job": "hot", "onset": {"after": "start", "time_s": 3.0}, "limit_s": 1.0,
            "set": {"safety_supervisor": set}, "relay": [{"lanes": ["encoder"], "how": "lose"}],
        });
        let found = outcome(&config, &serde_json::from_value(spec).unwrap(), Reaction::Degraded);
        assert!(found.reaction_s.is_some(), "{found:?}");
        assert_eq!(found.too_much.is_some(), worse, "{found:?}");
    }
}

/// C8: beside the supervisor nobody is obeyed; where its permits stay away for longer than they hold, another one is, and
/// that is too much from the first permit on.
#[test]
fn a_permit_of_a_second_publisher_that_is_taken_is_too_much() {
    let rival = json!({"lanes": ["permit"], "how": "rival"});
    assert_eq!(waiting(&json!([rival])).too_much, None);
    let rare = json!({"lanes": ["permit"], "how": "lose", "share": 0.97});
    // Of each pair the one or the other comes first.
    let late = json!({"lanes": ["permit"], "how": {"delay": [0.0, 0.2]}});
    let too_much = waiting(&json!([rival, rare, late])).too_much;
    assert_eq!(too_much.as_deref(), Some("a permit of a second publisher was taken"));
}

/// C6: what is on its way is not kept.
#[test]
fn corrections_may_outlive_their_ramp_by_what_the_way_keeps_back() {
    let keeps_back_s = |how: Value, share: f64| {
        let relay = json!({"lanes": ["permit"], "how": how, "share": share});
        let relay: Tampering = serde_json::from_value(relay).unwrap();
        [Lane::Permit, Lane::Hotend].map(|lane| relay.keeps_back_s(lane))
    };
    for (how, share, expected_s) in [
        (json!({"delay": [0.05, 0.5]}), 1.0, 0.5),
        (json!("lose"), 1.0, f64::INFINITY),
        (json!("lose"), 0.3, 0.2),
        (json!("repeat"), 1.0, 0.0),
    ] {
        let [permit_s, hotend_s] = keeps_back_s(how, share);
        assert!(permit_s.total_cmp(&expected_s).is_eq() && hotend_s.abs() < 1e-12, "{permit_s} {hotend_s}");
    }
}

/// C6, with the seeds in which the supervisor is well for 20 ms, corrects, and no permit of that time arrives: not too much.
#[test]
fn corrections_of_a_moment_of_health_that_the_printer_missed_go_back_in_their_own_time() {
    let config = ConfigDir::find(Some(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config"))).unwrap();
    let catalogue = Catalogue::read(&config.file("faults.yaml")).unwrap();
    let fault = catalogue.faults.iter().find(|fault| fault.id == "C6").unwrap();
    let spec = &fault.trials[0];
    let file = catalogue.jobs[&spec.job].load(&config).unwrap();
    let choice = Choice::of(file.material(), sim::level(&spec.control).unwrap());
    let setup = config.load(&choice).unwrap();
    for seed in [5, 9] {
        let trial = Trial { spec, reaction: fault.reaction, setup: &setup, file: &file, warm: true };
        assert_eq!(trial.run(seed).unwrap().too_much, None, "seed {seed}");
    }
}
