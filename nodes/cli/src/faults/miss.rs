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
    } else if let Some(found) = outcome.found_as.as_ref().filter(|found| !may_be(id, spec, found)) {
        format!("found as {found}")
    } else if let (Some(took_s), Some(limit_s)) = (counted_s(spec, outcome), spec.limit_s)
        && took_s > limit_s
    {
        let after = spec.limit_mm.map_or(String::new(), |way_mm| format!(" after {way_mm} mm"));
        format!("{took_s:.2} s{after}")
    } else if let Some(most) = spec.limit_layers.filter(|most| outcome.layers > *most) {
        format!("{} layers begun, allowed {most}", outcome.layers)
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

/// The part of a reaction that its limit in seconds is about.
fn counted_s(spec: &TrialSpec, outcome: &Outcome) -> Option<f64> {
    let reaction_s = outcome.reaction_s?;
    match spec.limit_mm {
        None => Some(reaction_s),
        Some(_) => outcome.pushed_s.map(|pushed_s| reaction_s - pushed_s),
    }
}

/// Whether a fault may be found under this name; an empty one where the printer acted by itself.
fn may_be(id: &str, spec: &TrialSpec, found: &str) -> bool {
    if spec.found_as.is_empty() { found == id } else { spec.found_as.iter().any(|name| name == found) }
}
