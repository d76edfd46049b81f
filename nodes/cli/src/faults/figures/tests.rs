//! Which trial an ID is told by.

use super::*;

fn trial(name: &str, runs: usize, figures: TrialFigures) -> TrialFigures {
    TrialFigures { name: name.to_owned(), action: Reaction::Paused.name(), runs, detected: runs, ..figures }
}

/// By the trial that is nearest to its own limit, of whatever kind that is; by one that found nothing before all; by one
/// after which nothing may follow never.
#[test]
fn an_id_is_told_by_the_trial_nearest_to_its_limit() {
    let seconds = |most_s: f64, limit_s: f64| TrialFigures {
        reaction_max_s: Some(most_s),
        limit_s: Some(limit_s),
        ..TrialFigures::default()
    };
    let way = |most_mm: f64| TrialFigures {
        limit_mm: Some(7.0),
        pushed_max_mm: Some(most_mm),
        ..seconds(most_mm, 1.0)
    };
    let layers = |most: u32, most_s: f64| TrialFigures {
        limit_layers: Some(1),
        layers_max: Some(most),
        ..seconds(most_s, 30.0)
    };
    let sound = || TrialFigures {
        action: Reaction::None.name(),
        detected: 0,
        ..trial("sound", 2, TrialFigures { limit_s: Some(270.0), ..TrialFigures::default() })
    };
    let missed = || TrialFigures { detected: 1, ..trial("missed", 2, seconds(0.1, 5.0)) };
    let spec: FaultSpec =
        serde_json::from_value(serde_json::json!({"id": "P6", "fault": "slip", "reaction": "paused"}))
            .unwrap();
    for (near, far) in [
        (trial("near", 2, seconds(4.0, 5.0)), trial("far", 2, seconds(7.0, 10.0))),
        (trial("near", 2, way(4.7)), trial("far", 2, way(2.5))),
        (trial("near", 2, way(4.7)), trial("far", 2, seconds(0.5, 1.0))),
        (trial("near", 2, layers(1, 24.0)), trial("far", 2, layers(1, 6.0))),
        (trial("near", 2, seconds(4.0, 5.0)), sound()),
        (missed(), trial("far", 2, seconds(4.9, 5.0))),
    ] {
        for trials in [[near.clone(), far.clone()], [far.clone(), near.clone()]] {
            let told = FaultFigures::of(&spec, "virtual", trials.to_vec());
            assert_eq!((told.reaction_max_s, told.limit_s), (near.reaction_max_s, near.limit_s), "{told:?}");
        }
    }
}
