//! What one run of a trial showed, and all runs of it together.

use super::watcher::Watcher;
use crate::faults::catalogue::{Bound, ProcessSpec, Reaction};
use crate::faults::figures::TrialFigures;
use crate::faults::measure::Measure;
use crate::faults::miss::may_be;
use crate::up::words::mode_name;
use fdm_loop_msgs::SafetyState;
use std::collections::{BTreeMap, BTreeSet};

/// One run.
#[derive(Debug, Default)]
pub(super) struct Observed {
    /// Decided the moment of the fault.
    pub(super) seed: u64,
    /// From the fault until `fdm` told of it `[s]`.
    pub(super) told_s: Option<f64>,
    /// From the fault to the reaction `[s]`.
    pub(super) reaction_s: Option<f64>,
    /// From the end of the fault until all was whole again `[s]`.
    pub(super) recovered_s: Option<f64>,
    /// Where it is asked for: when the printer was at the slicer's values `[s]`.
    pub(super) neutral_s: Option<Option<f64>>,
    /// How the supervisor called it.
    pub(super) found_as: Option<String>,
    /// Highest mode that followed.
    pub(super) worst: u8,
    /// What it was called, or what became of the corrections.
    pub(super) affected: Option<String>,
    /// The supervisor told that its permits come irregularly.
    pub(super) alarmed: bool,
    /// The machine had something else to do.
    pub(super) excused: bool,
    /// What else was wrong.
    pub(super) wrong: Vec<String>,
    /// Named figures.
    pub(super) figures: BTreeMap<&'static str, f64>,
    /// Times that were measured often `[s]`.
    pub(super) measures: BTreeMap<&'static str, Vec<f64>>,
}

impl Observed {
    /// What a watcher saw of supervisor and printer.
    pub(super) fn of(watcher: &Watcher) -> Self {
        let cause = watcher.worst.1.split_whitespace().next().map(|id| id.trim_end_matches(':').to_owned());
        Self {
            worst: watcher.worst.0,
            affected: watcher.affected(),
            found_as: cause.filter(|_| watcher.worst.0 > SafetyState::MODE_ACT),
            alarmed: watcher.alarmed,
            ..Self::default()
        }
    }

    /// The run could not be made.
    pub(super) fn failed(seed: u64, why: String) -> Self {
        Self { seed, wrong: vec![why], ..Self::default() }
    }

    /// Bounds that were not kept, in words.
    fn unkept(&self, spec: &ProcessSpec) -> Vec<String> {
        let measured = self.measures.iter().map(|(name, samples)| {
            let bound = spec.bounds.get(*name).copied().unwrap_or_default();
            Measure::of(name, samples.clone(), bound)
        });
        measured.filter(|measure| !measure.within_limit).map(|measure| measure.text()).collect()
    }

    /// Whether a bound counts as kept because the supervisor told of it, where the machine gave no time.
    fn is_excused(&self, spec: &ProcessSpec) -> bool {
        self.alarmed && self.excused && !self.unkept(spec).is_empty()
    }

    /// The name under which the supervisor found what it may not be found as.
    fn misnamed(&self, id: &str, spec: &ProcessSpec) -> Option<&str> {
        self.found_as.as_deref().filter(|found| !may_be(id, &spec.found_as, found))
    }

    /// What was wrong, in words.
    fn miss(&self, (id, spec): (&str, &ProcessSpec), reaction: Reaction) -> Option<String> {
        let mut wrong = self.wrong.clone();
        wrong.extend(self.misnamed(id, spec).map(|found| format!("found as {found}")));
        let time = |time: Option<f64>| time.map_or("never".to_owned(), |time| format!("after {time:.2} s"));
        let late = |took: Option<f64>, limit_s: f64| took.is_none_or(|took| took > limit_s);
        if let Some(limit_s) = spec.told_s.filter(|limit_s| late(self.told_s, *limit_s)) {
            wrong.push(format!("told {}, limit {limit_s} s", time(self.told_s)));
        }
        // Nobody has to act where a process is there again before it was missed.
        let due = reaction != Reaction::Told || self.reaction_s.is_some();
        if let Some(limit_s) = spec.limit_s.filter(|limit_s| due && late(self.reaction_s, *limit_s)) {
            let reaction = followed(reaction, due);
            wrong.push(format!("{reaction} {}, limit {limit_s} s", time(self.reaction_s)));
        }
        if let Some(earliest_s) = spec.earliest_s.filter(|limit_s| !late(self.reaction_s, *limit_s)) {
            wrong.push(format!("{} {}, before {earliest_s} s", reaction.name(), time(self.reaction_s)));
        }
        if let (Some(limit_s), Some(neutral)) = (spec.neutral_s, self.neutral_s)
            && late(neutral, limit_s)
        {
            wrong.push(format!("slicer's values {}, limit {limit_s} s", time(neutral)));
        }
        if let Some(limit_s) = spec.recover_s.filter(|limit_s| late(self.recovered_s, *limit_s)) {
            wrong.push(format!("whole {}, limit {limit_s} s", time(self.recovered_s)));
        }
        let most = spec.at_most.unwrap_or(reaction);
        match &self.affected {
            Some(what) if most == Reaction::None => wrong.push(format!("control was affected: {what}")),
            _ if self.worst > highest(most) => {
                wrong.push(format!(
                    "too much: {} {}",
                    mode_name(self.worst),
                    self.found_as.as_deref().unwrap_or("")
                ));
            }
            _ => {}
        }
        // What is excused is a late tick, not that there was none.
        let none = |name: &&String| self.measures.get(name.as_str()).is_none_or(Vec::is_empty);
        wrong.extend(spec.bounds.keys().filter(none).map(|name| format!("{name}: never measured")));
        let told = self.alarmed && (spec.or_alarm || self.excused);
        if !told {
            wrong.extend(self.unkept(spec));
        }
        (!wrong.is_empty()).then(|| format!("seed {}: {}", self.seed, wrong.join("; ")))
    }
}

/// The reaction as it is named: `told` only where the supervisor had no cause to act.
fn followed(reaction: Reaction, acted: bool) -> &'static str {
    let degraded = reaction == Reaction::Told && acted;
    if degraded { Reaction::Degraded.name() } else { reaction.name() }
}

/// Highest mode that a reaction allows.
fn highest(most: Reaction) -> u8 {
    match most {
        Reaction::None | Reaction::Told | Reaction::Flagged | Reaction::Observe => SafetyState::MODE_ACT,
        Reaction::Baseline | Reaction::Degraded => SafetyState::MODE_DEGRADED,
        Reaction::Paused => SafetyState::MODE_PAUSED,
        Reaction::SafeOff => SafetyState::MODE_SAFE_OFF,
        Reaction::Estop => SafetyState::MODE_ESTOP,
    }
}

/// Sums up all runs of a trial.
pub(super) fn sum_up(
    (id, spec): (&str, &ProcessSpec),
    reaction: Reaction,
    runs: &[Observed],
) -> TrialFigures {
    let mut times: Vec<f64> = runs.iter().filter_map(|run| run.reaction_s).collect();
    times.sort_by(f64::total_cmp);
    let told: Vec<f64> = runs.iter().filter_map(|run| run.told_s).collect();
    let due = reaction != Reaction::Told || !times.is_empty();
    let misses: Vec<String> = runs.iter().filter_map(|run| run.miss((id, spec), reaction)).collect();
    let found_as: BTreeSet<String> = runs.iter().filter_map(|run| run.found_as.clone()).collect();
    let recovered = runs.iter().filter_map(|run| run.recovered_s).max_by(f64::total_cmp);
    let mut figures: BTreeMap<String, f64> = BTreeMap::new();
    let mut samples: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for run in runs {
        for (name, figure) in &run.figures {
            let most = figures.entry((*name).to_owned()).or_insert(*figure);
            *most = most.max(*figure);
        }
        for (name, measured) in &run.measures {
            samples.entry(name).or_default().extend(measured);
        }
    }
    if let Some(recovered_s) = recovered {
        figures.insert("whole_s".to_owned(), recovered_s);
    }
    let excused = runs.iter().filter(|run| run.is_excused(spec)).count();
    if excused > 0 {
        #[allow(clippy::cast_precision_loss, reason = "a handful")]
        figures.insert("excused_runs".to_owned(), excused as f64);
    }
    let bound = |name: &str| spec.bounds.get(name).copied().unwrap_or(Bound::default());
    TrialFigures {
        name: spec.name.clone(),
        action: followed(reaction, due),
        runs: runs.len(),
        detected: if due && reaction != Reaction::None { times.len() } else { told.len().max(times.len()) },
        reaction_p50_s: times.get(times.len().saturating_sub(1) / 2).copied(),
        reaction_max_s: times.last().copied(),
        limit_s: spec.limit_s.filter(|_| due),
        told_max_s: told.into_iter().max_by(f64::total_cmp),
        told_limit_s: spec.told_s,
        within_limit: misses.is_empty(),
        found_as: found_as.into_iter().collect(),
        misses,
        recovered_max_s: recovered.filter(|_| spec.recover_s.is_some()),
        // Trips without a cause are those of trials in which nothing may follow.
        false_trips: runs
            .iter()
            .filter(|run| reaction == Reaction::None && run.worst > SafetyState::MODE_DEGRADED)
            .count(),
        alarmed: spec.or_alarm.then(|| runs.iter().any(|run| run.alarmed)),
        figures,
        measures: samples.into_iter().map(|(name, all)| Measure::of(name, all, bound(name))).collect(),
        ..TrialFigures::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    /// L1: an alarm excuses a tick that is late, not one that was never counted.
    #[test]
    fn what_was_never_measured_is_a_miss_whatever_was_told() {
        let spec = json!({"name": "a", "do": {"spin": {"processes": 4, "for_s": 1.0}}, "or_alarm": true,
            "bounds": {"permit late": {"p999_s": 0.01}}});
        let spec: ProcessSpec = serde_json::from_value(spec).unwrap();
        let miss = |late: Option<Vec<f64>>, alarmed| {
            let measures = late.map(|late| ("permit late", late)).into_iter().collect();
            let run = Observed { seed: 3, alarmed, measures, ..Observed::default() };
            run.miss(("L1", &spec), Reaction::None)
        };
        assert_eq!(miss(Some(vec![0.02; 10]), true), None, "late and told");
        assert!(miss(Some(vec![0.02; 10]), false).is_some(), "late and not told");
        for late in [None, Some(Vec::new())] {
            assert_eq!(miss(late, true).as_deref(), Some("seed 3: permit late: never measured"));
        }
    }

    /// Another fault that happened to be found in time is none of this one.
    #[test]
    fn what_was_found_as_something_else_is_a_miss() {
        let miss = |named: &[&str], found: Option<&str>| {
            let spec = json!({"name": "a", "do": {"kill": "imu"}, "found_as": named});
            let spec: ProcessSpec = serde_json::from_value(spec).unwrap();
            let found_as = found.map(str::to_owned);
            let run =
                Observed { seed: 3, found_as, worst: SafetyState::MODE_DEGRADED, ..Observed::default() };
            run.miss(("C1", &spec), Reaction::Degraded)
        };
        assert_eq!(miss(&["S7"], Some("C13")).as_deref(), Some("seed 3: found as C13"));
        assert_eq!(miss(&[], Some("S7")).as_deref(), Some("seed 3: found as S7"));
        assert_eq!((miss(&["S7"], Some("S7")), miss(&[], Some("C1")), miss(&[], None)), (None, None, None));
    }
}
