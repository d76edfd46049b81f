//! Figures of `fdm faults` with the names of the JSON contract.

use super::catalogue::{FaultSpec, LimitSource, Peers, Reaction, TrialSpec};
use super::measure::Measure;
use super::miss::miss;
use super::trial::Outcome;
use serde::Serialize;
use std::collections::BTreeMap;

/// One way to bring a fault about, over all seeds.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct TrialFigures {
    /// What is special about it.
    pub name: String,
    /// What has to follow.
    pub action: &'static str,
    /// Runs in which the fault set in.
    pub runs: usize,
    /// Runs in which the reaction followed.
    pub detected: usize,
    /// Median time from injection to actuation `[s]`.
    pub reaction_p50_s: Option<f64>,
    /// Longest.
    pub reaction_max_s: Option<f64>,
    /// Longest that is allowed `[s]`.
    pub limit_s: Option<f64>,
    /// What the motor may push before that time begins `[mm]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_mm: Option<f64>,
    /// Most that it pushed between onset and reaction `[mm]`, where it is limited.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pushed_max_mm: Option<f64>,
    /// Layers that may be begun before the reaction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_layers: Option<u32>,
    /// Most that were, where they are limited.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub layers_max: Option<u32>,
    /// Where its limit comes from, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_source: Option<LimitSource>,
    /// Longest time until `fdm` told that the process ended, hangs or cannot write `[s]`: detection, not actuation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub told_max_s: Option<f64>,
    /// Longest that is allowed for that `[s]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub told_limit_s: Option<f64>,
    /// Where that limit comes from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub told_limit_source: Option<LimitSource>,
    /// Every run did what is asked for.
    pub within_limit: bool,
    /// How the supervisor called it, every name once.
    pub found_as: Vec<String>,
    /// What was wrong, one line a run.
    pub misses: Vec<String>,
    /// Largest temperature of the block above its set-point `[K]`, where it is limited.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub overshoot_max_k: Option<f64>,
    /// Longest time until corrections were back `[s]`, where it is limited.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recovered_max_s: Option<f64>,
    /// What other firmware needs for the same.
    pub peers: Peers,
    /// Runs in which something was found before the fault.
    pub false_trips: usize,
    /// Where a limit may be missed with an alarm: whether one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alarmed: Option<bool>,
    /// Further figures by name and unit, the largest of all runs.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub figures: BTreeMap<String, f64>,
    /// What was measured many times.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub measures: Vec<Measure>,
}

/// One ID of the catalogue.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FaultFigures {
    /// Its ID.
    pub id: String,
    /// What goes wrong.
    pub fault: String,
    /// `virtual` or `process`.
    pub level: &'static str,
    /// What has to follow.
    pub action: &'static str,
    /// Runs of all trials.
    pub runs: usize,
    /// Runs in which the reaction followed; after what is no fault (action `none`) nothing does.
    pub detected: usize,
    /// Median reaction of the trial that comes nearest to its own limit `[s]`.
    pub reaction_p50_s: Option<f64>,
    /// Its longest reaction `[s]`.
    pub reaction_max_s: Option<f64>,
    /// Its limit `[s]`.
    pub limit_s: Option<f64>,
    /// What the motor may push before that time begins `[mm]`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_mm: Option<f64>,
    /// Layers that may be begun before the reaction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_layers: Option<u32>,
    /// Where the limit comes from; `null` where there is none.
    pub limit_source: Option<LimitSource>,
    /// The limit where it is not one of seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit: Option<String>,
    /// Every run of every trial did what is asked for; `null` where nothing ran.
    pub within_limit: Option<bool>,
    /// Test of the workspace that shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub test: Option<String>,
    /// Why it cannot be shown yet.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waiting: Option<String>,
    /// Its trials.
    pub trials: Vec<TrialFigures>,
}

/// Everything that ran.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Figures {
    /// `virtual` or `process`.
    pub level: &'static str,
    /// By ID.
    pub faults: Vec<FaultFigures>,
    /// How often something was found with nothing wrong: before a fault, or in sound prints.
    pub false_trips: usize,
    /// What that was.
    pub false_trip_list: Vec<String>,
    /// Simulated time of sound prints `[h]`.
    pub hours: f64,
    /// Of it with the camera, its frames judged `[h]`.
    pub camera_hours: f64,
    /// Sound prints, the last ones not to their end.
    pub sound_prints: usize,
    /// Pauses that their files asked for, after which they went on.
    pub file_pauses: usize,
}

impl TrialFigures {
    /// Sums up the runs of a trial.
    #[must_use]
    pub fn of(id: &str, spec: &TrialSpec, reaction: Reaction, outcomes: &[Outcome]) -> Self {
        let mut times: Vec<f64> = outcomes.iter().filter_map(|outcome| outcome.reaction_s).collect();
        times.sort_by(f64::total_cmp);
        let mut found_as: Vec<String> =
            outcomes.iter().filter_map(|outcome| outcome.found_as.clone()).collect();
        found_as.sort();
        found_as.dedup();
        let misses: Vec<String> =
            outcomes.iter().filter_map(|outcome| miss((id, spec), reaction, outcome)).collect();
        let most =
            |figure: fn(&Outcome) -> Option<f64>| outcomes.iter().filter_map(figure).max_by(f64::total_cmp);
        Self {
            name: spec.name.clone(),
            action: reaction.name(),
            runs: outcomes.iter().filter(|outcome| outcome.onset_s.is_some()).count(),
            detected: times.len(),
            reaction_p50_s: times.get(times.len().saturating_sub(1) / 2).copied(),
            reaction_max_s: times.last().copied(),
            limit_s: spec.limit_s,
            limit_mm: spec.limit_mm,
            pushed_max_mm: spec.limit_mm.and_then(|_| most(|outcome| Some(outcome.pushed_mm))),
            limit_layers: spec.limit_layers,
            layers_max: spec.limit_layers.and_then(|_| outcomes.iter().map(|outcome| outcome.layers).max()),
            within_limit: misses.is_empty(),
            found_as,
            misses,
            overshoot_max_k: spec.overshoot_max_k.and_then(|_| most(|outcome| Some(outcome.overshoot_k))),
            recovered_max_s: spec.recover_s.and_then(|_| most(|outcome| outcome.recovered_s)),
            peers: spec.peers,
            false_trips: outcomes.iter().filter(|outcome| outcome.early.is_some()).count(),
            ..Self::default()
        }
    }

    /// The same with the source of its limit, where it has one.
    #[must_use]
    pub fn limited_by(self, source: Option<LimitSource>) -> Self {
        let limited = self.limit().is_some() || !self.measures.is_empty();
        Self { limit_source: source.filter(|_| limited), ..self }
    }

    /// The limit as it is printed, each number with its unit: seconds, filament and then seconds, layers, or the
    /// later of layers and seconds.
    #[must_use]
    pub fn limit(&self) -> Option<String> {
        match (self.limit_s, self.limit_mm, self.limit_layers) {
            (Some(limit_s), Some(limit_mm), _) => Some(format!("{limit_mm} mm + {limit_s} s")),
            (Some(limit_s), None, None) => Some(format!("{limit_s} s")),
            (limit_s, _, Some(layers)) => {
                let seconds = limit_s.map_or(String::new(), |limit_s| format!(" or {limit_s} s"));
                Some(format!("{layers} layer{}{seconds}", if layers == 1 { "" } else { "s" }))
            }
            (None, _, None) => None,
        }
    }

    /// Share of its limit that the worst run took, of filament where that is limited, of layers and seconds where the later
    /// one counts; more than any without the reaction, none where nothing may follow.
    fn strain(&self) -> f64 {
        let time = share(self.reaction_max_s, self.limit_s);
        let way = share(self.pushed_max_mm, self.limit_mm);
        let layers = share(self.layers_max.map(f64::from), self.limit_layers.map(f64::from));
        if self.action == Reaction::None.name() {
            return 0.0;
        } else if self.detected < self.runs {
            return f64::INFINITY;
        }
        way.or_else(|| time.zip(layers).map(|(time, layers)| time.min(layers)))
            .or(time)
            .or(layers)
            .unwrap_or(0.0)
    }
}

/// A figure as a share of its limit.
fn share(most: Option<f64>, limit: Option<f64>) -> Option<f64> {
    most.zip(limit).map(|(most, limit)| most / limit)
}

impl FaultFigures {
    /// Sums up the trials of an ID; with none, what is said of it.
    #[must_use]
    pub fn of(spec: &FaultSpec, level: &'static str, trials: Vec<TrialFigures>) -> Self {
        let nearest = trials.iter().max_by(|a, b| a.strain().total_cmp(&b.strain()));
        Self {
            id: spec.id.clone(),
            fault: spec.fault.clone(),
            level: if trials.is_empty() { "process" } else { level },
            action: spec.reaction.name(),
            runs: trials.iter().map(|trial| trial.runs).sum(),
            detected: trials.iter().map(|trial| trial.detected).sum(),
            reaction_p50_s: nearest.and_then(|trial| trial.reaction_p50_s),
            reaction_max_s: nearest.and_then(|trial| trial.reaction_max_s),
            limit_s: nearest.and_then(|trial| trial.limit_s),
            limit_mm: nearest.and_then(|trial| trial.limit_mm),
            limit_layers: nearest.and_then(|trial| trial.limit_layers),
            limit_source: nearest.and_then(|trial| trial.limit_source).or(spec.source),
            limit: spec.limit.clone(),
            within_limit: (!trials.is_empty()).then(|| trials.iter().all(|trial| trial.within_limit)),
            test: spec.test.clone(),
            waiting: spec.waiting.clone(),
            trials,
        }
    }
}

impl Figures {
    /// On what it ran, in words.
    #[must_use]
    pub fn title(&self) -> &'static str {
        if self.level == "process" {
            "Real processes over DDS with a simulated printer"
        } else {
            "Simulated printer in virtual time"
        }
    }

    /// Whether detection is told apart from actuation in any trial.
    #[must_use]
    pub fn has_told(&self) -> bool {
        let told = |trial: &TrialFigures| trial.told_max_s.is_some() || trial.told_limit_s.is_some();
        self.faults.iter().flat_map(|fault| &fault.trials).any(told)
    }

    /// Where an ID is tried that none of these trials shows, in words.
    #[must_use]
    pub fn elsewhere(&self) -> &'static str {
        if self.level == "process" {
            "tried without --process"
        } else {
            "not tried here: with --process, or with the camera"
        }
    }

    /// Whether nothing was missed and nothing tripped without a cause.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.false_trips == 0 && self.faults.iter().all(|fault| fault.within_limit != Some(false))
    }
}

#[cfg(test)]
mod tests;
