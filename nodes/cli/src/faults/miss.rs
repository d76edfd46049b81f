//! What of a run in virtual time was not as asked for, in words.

use super::catalogue::{Reaction, TrialSpec};
use super::trial::Outcome;

/// What was wrong with a run.
pub(super) fn miss((id, spec): (&str, &TrialSpec), reaction: Reaction, outcome: &Outcome) -> Option<String> {
    let what = if let Some(early) = &outcome.early {
        format!("{early} before the fault")
    } else if outcome.onset_s.is_none() {
        "the job ended before the fault".to_owned()
    } else if let Some(worse) = &outcome.too_much {
        format!("too much: {worse}")
    } else if outcome.reaction_s.is_none() && reaction != Reaction::None {
        "no reaction".to_owned()
    } else if let Some(found) = misnamed((id, spec), reaction, outcome) {
        found
    } else if let Some(late) = late(spec, outcome) {
        late
    } else if let Some(most_k) = spec.overshoot_max_k.filter(|most_k| outcome.overshoot_k > *most_k) {
        format!("{:.1} K above the set-point, allowed {most_k}", outcome.overshoot_k)
    } else if let Some(recover_s) = spec.recover_s
        && outcome.recovered_s.is_none_or(|took_s| took_s > recover_s)
    {
        outcome
            .recovered_s
            .map_or("never whole again".to_owned(), |took_s| format!("whole after {took_s:.2} s"))
    } else {
        return None;
    };
    Some(format!("seed {}: {what}", outcome.seed))
}

/// What was found instead; nobody's find is a printer that acted by itself.
fn misnamed((id, spec): (&str, &TrialSpec), reaction: Reaction, outcome: &Outcome) -> Option<String> {
    let found = outcome.found_as.as_deref().or((reaction >= Reaction::Degraded).then_some(""))?;
    let what = if found.is_empty() { "found by nobody".to_owned() } else { format!("found as {found}") };
    (!may_be(id, &spec.found_as, found)).then_some(what)
}

/// How much later a reaction came than it may; where seconds and layers are allowed, the later of them counts.
fn late(spec: &TrialSpec, outcome: &Outcome) -> Option<String> {
    let took_s =
        counted_s(spec, outcome).filter(|took_s| spec.limit_s.is_some_and(|limit_s| *took_s > limit_s));
    let slow = took_s.map(|took_s| {
        let after = spec.limit_mm.map_or(String::new(), |way_mm| format!(" after {way_mm} mm"));
        format!("{took_s:.2} s{after}")
    });
    let most = spec.limit_layers.filter(|most| outcome.layers > *most);
    let begun = most.map(|most| format!("{} layers begun, allowed {most}", outcome.layers));
    if spec.limit_s.is_some() && spec.limit_layers.is_some() {
        return slow.zip(begun).map(|(slow, begun)| format!("{slow}, {begun}"));
    }
    slow.or(begun)
}

/// The part of a reaction that its limit in seconds is about.
fn counted_s(spec: &TrialSpec, outcome: &Outcome) -> Option<f64> {
    let reaction_s = outcome.reaction_s?;
    match spec.limit_mm {
        None => Some(reaction_s),
        Some(_) => outcome.pushed_s.map(|pushed_s| reaction_s - pushed_s),
    }
}

/// Whether a fault may be found under this name: its own, where none are named; an empty one where the printer acted by
/// itself.
pub(super) fn may_be(id: &str, named: &[String], found: &str) -> bool {
    if named.is_empty() { found == id } else { named.iter().any(|name| name == found) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// Whether a reaction after `reaction_s` and `layers` begun is late.
    fn is_late(limits: &serde_json::Value, reaction_s: f64, layers: u32) -> bool {
        missed((limits, Reaction::Paused), (reaction_s, layers), Some("P8")).is_some()
    }

    /// What was wrong with a reaction, and with its name.
    fn missed(
        (limits, reaction): (&serde_json::Value, Reaction),
        (reaction_s, layers): (f64, u32),
        found_as: Option<&str>,
    ) -> Option<String> {
        let mut spec = json!({"name": "a", "job": "print", "onset": {"after": "start", "time_s": 0.0}});
        for (name, value) in limits.as_object().unwrap() {
            spec[name] = value.clone();
        }
        let spec: TrialSpec = serde_json::from_value(spec).unwrap();
        let outcome = Outcome {
            seed: 1,
            onset_s: Some(10.0),
            reaction_s: Some(reaction_s),
            pushed_s: Some(2.0),
            pushed_mm: 8.0,
            layers,
            found_as: found_as.map(str::to_owned),
            early: None,
            too_much: None,
            recovered_s: None,
            overshoot_k: 0.0,
        };
        miss(("P8", &spec), reaction, &outcome)
    }

    /// A pause that a file asked for, or the flag of another fault, is none of this one.
    #[test]
    fn what_nobody_found_or_as_something_else_is_a_miss() {
        let none = json!({});
        let named = |reaction, found_as| missed((&none, reaction), (1.0, 0), found_as);
        assert_eq!(named(Reaction::Paused, Some("P8")), None);
        assert_eq!(named(Reaction::Paused, None).as_deref(), Some("seed 1: found by nobody"));
        assert_eq!(named(Reaction::Flagged, Some("P4")).as_deref(), Some("seed 1: found as P4"));
        assert_eq!(named(Reaction::Baseline, None), None, "the dead-man has no name for it");
        let alone = json!({"found_as": ["", "C14"]});
        assert_eq!(missed((&alone, Reaction::Paused), (1.0, 0), None), None);
    }

    #[test]
    fn seconds_and_layers_are_limits_each_and_together_the_later_counts() {
        let (seconds, layers) = (json!({"limit_s": 30.0}), json!({"limit_layers": 1}));
        assert!(!is_late(&seconds, 30.0, 9) && is_late(&seconds, 30.1, 0));
        assert!(!is_late(&layers, 99.0, 1) && is_late(&layers, 1.0, 2));
        let both = json!({"limit_s": 30.0, "limit_layers": 1});
        assert!(!is_late(&both, 99.0, 1) && !is_late(&both, 30.0, 9));
        assert!(is_late(&both, 30.1, 2));
        let way = json!({"limit_s": 1.0, "limit_mm": 7.0});
        assert!(!is_late(&way, 3.0, 0) && is_late(&way, 3.1, 0));
    }
}
