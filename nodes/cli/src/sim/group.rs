//! The runs of one control level together: means, over how many runs, and which of them did not finish.

use super::report::Run;
use serde::Serialize;
use std::collections::BTreeMap;

/// A run that ended before its file did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unfinished {
    /// Seed of the run.
    pub seed: u64,
    /// `paused` or `failed`.
    pub ended: String,
    /// When `[s]`.
    pub at_s: f64,
    /// Code of the cause, or the line of the file that asks for the pause; `null` where nobody told one.
    pub by: Option<String>,
}

/// Mean and spread of the runs of one control level.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Group {
    /// Control level.
    pub control: String,
    /// One run a seed.
    pub runs: Vec<Run>,
    /// Number of seeds.
    pub seeds: usize,
    /// Runs that printed their file to its end.
    pub done: usize,
    /// Those that did not. Their figures are of what they printed, and count in the means; their time does not.
    pub unfinished: Vec<Unfinished>,
    /// Mean by figure, over the runs that have it.
    pub mean: BTreeMap<&'static str, f64>,
    /// Standard deviation by figure.
    pub spread: BTreeMap<&'static str, f64>,
    /// Number of runs that mean and deviation are over, by figure; 0 where none has it.
    pub count: BTreeMap<&'static str, usize>,
}

/// Several runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// One group a control level.
    pub results: Vec<Group>,
}

type Figure = (&'static str, fn(&Run) -> Option<f64>);

/// Mean NIS of a channel.
fn nis(run: &Run, channel: &str) -> Option<f64> {
    run.nis_mean.get(channel).copied().flatten()
}

/// Share of the time for which the stated 95 % interval of a state held.
fn coverage(run: &Run, state: usize) -> Option<f64> {
    run.coverage.map(|coverage| coverage[state])
}

/// Figures that are averaged.
const FIGURES: [Figure; 25] = [
    ("quality_mean", |run| run.quality_mean),
    ("width_rms_rel", |run| run.width_rms_rel),
    ("corner_width_rms_rel", |run| run.corner_width_rms_rel),
    ("print_time_s", |run| run.is_done().then_some(run.print_time_s)),
    ("feed_error_rel", |run| run.feed_error_rel),
    ("feed_error_after_2s_rel", |run| run.feed_error_after_2s_rel),
    ("feed_error_after_8s_rel", |run| run.feed_error_after_8s_rel),
    ("recovery_time_s", |run| run.recovery_time_s),
    ("recovery_5s_s", |run| run.recovery_5s_s),
    ("trimmed_share", |run| run.trimmed_share),
    ("feedback_share", |run| run.feedback_share),
    ("slowed_share", |run| run.slowed_share),
    ("nees_median", |run| run.nees_median),
    ("nees_told_median", |run| run.nees_told.as_ref().map(|told| told.nees_median)),
    ("nis_thermistor", |run| nis(run, "thermistor")),
    ("nis_encoder", |run| nis(run, "encoder")),
    ("nis_width", |run| nis(run, "width")),
    ("nis_nozzle", |run| nis(run, "nozzle")),
    ("coverage_block", |run| coverage(run, 0)),
    ("coverage_nozzle", |run| coverage(run, 1)),
    ("coverage_thermistor", |run| coverage(run, 2)),
    ("coverage_flow", |run| coverage(run, 3)),
    ("coverage_slip", |run| coverage(run, 4)),
    ("coverage_gain", |run| coverage(run, 5)),
    ("realtime_factor", |run| Some(run.realtime_factor)),
];

impl Run {
    /// The file was printed to its end.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.ended == "done"
    }

    /// When and by what a run was ended that is not done.
    fn unfinished(&self) -> Option<Unfinished> {
        let stops = |action: &str| !matches!(action, "flagged" | "degraded" | "observe");
        let found = self.detections.iter().chain(&self.false_alarm_list);
        let causes =
            found.filter(|found| stops(&found.action)).map(|found| (found.detected_s, found.fault.clone()));
        let asked = self.file_pauses.iter().map(|pause| (pause.detected_s, format!("line {}", pause.line)));
        let last = causes.chain(asked).max_by(|(left_s, _), (right_s, _)| left_s.total_cmp(right_s));
        (!self.is_done()).then(|| Unfinished {
            seed: self.seed,
            ended: self.ended.clone(),
            at_s: last.as_ref().map_or(self.print_time_s, |(at_s, _)| *at_s),
            by: last.map(|(_, by)| by).filter(|by| !by.is_empty()),
        })
    }
}

impl Group {
    /// Averages the runs of one control level.
    #[must_use]
    pub fn of(control: String, runs: Vec<Run>) -> Self {
        let (mut mean, mut spread, mut count) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        for (name, figure) in FIGURES {
            let values: Vec<f64> = runs.iter().filter_map(figure).collect();
            count.insert(name, values.len());
            if let Some((average, deviation)) = mean_and_deviation(&values) {
                mean.insert(name, average);
                spread.insert(name, deviation);
            }
        }
        let unfinished: Vec<Unfinished> = runs.iter().filter_map(Run::unfinished).collect();
        let (seeds, done) = (runs.len(), runs.len() - unfinished.len());
        Self { control, seeds, done, unfinished, runs, mean, spread, count }
    }

    /// ` (3 of 4)` where fewer runs than seeds have the figure, else nothing.
    #[must_use]
    pub fn share(&self, name: &str) -> String {
        let count = self.count.get(name).copied().unwrap_or(0);
        if count < self.seeds { format!(" ({count} of {})", self.seeds) } else { String::new() }
    }
}

/// Mean and sample standard deviation (zero for a single value).
fn mean_and_deviation(values: &[f64]) -> Option<(f64, f64)> {
    if values.is_empty() {
        return None;
    }
    #[allow(clippy::cast_precision_loss, reason = "seeds are few")]
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Some((mean, (squares / (count - 1.0).max(1.0)).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::consistency::STATE_NAMES;
    use crate::sim::report::Detection;
    use crate::sim::text;

    fn run(seed: u32, ended: &str, recovery_5s_s: Option<f64>) -> Run {
        let (quality_mean, print_time_s) = (Some(1.0), 100.0 * f64::from(seed));
        Run {
            seed: seed.into(),
            ended: ended.to_owned(),
            recovery_5s_s,
            quality_mean,
            print_time_s,
            ..Run::default()
        }
    }

    fn found(fault: &str, detected_s: f64, action: &str) -> Detection {
        Detection { fault: fault.to_owned(), onset_s: None, detected_s, action: action.to_owned() }
    }

    /// Seed 2 is paused by P6 at 190 s, what was flagged before and after is not why; seed 3 never recovers; seed 4 has no Q.
    #[test]
    fn means_say_over_how_many_runs_they_are_and_who_did_not_finish() {
        let mut runs = vec![
            run(1, "done", Some(1.0)),
            run(2, "paused", Some(3.0)),
            run(3, "done", None),
            run(4, "done", None),
        ];
        runs[1].false_alarm_list =
            vec![found("K1", 90.0, "degraded"), found("P6", 190.0, "paused"), found("P8", 191.0, "flagged")];
        runs[3].quality_mean = None;
        let group = Group::of("mpc".to_owned(), runs);
        let by = Some("P6".to_owned());
        assert_eq!(group.unfinished, [Unfinished { seed: 2, ended: "paused".to_owned(), at_s: 190.0, by }]);
        assert_eq!((group.done, group.mean["recovery_5s_s"]), (3, 2.0));
        // what was paused at 200 s has no print time: 100, 300 and 400 s
        assert!((group.mean["print_time_s"] - 800.0 / 3.0).abs() < 1e-9);
        let counts =
            ["recovery_5s_s", "quality_mean", "print_time_s", "width_rms_rel"].map(|name| group.count[name]);
        assert_eq!(counts, [2, 3, 3, 0]);
        let told = text::table(&[group]);
        for part in [
            "3 of 4",
            "2.000 +- 1.414 (2 of 4)",
            "1.000 +- 0.000 (3 of 4)",
            "266.7 s (3 of 4)",
            "seed 2 paused at 190.0 s by P6",
        ] {
            assert!(told.contains(part), "{part} is missing in\n{told}");
        }
    }

    /// Each channel and state under its own name, over the runs that have it.
    #[test]
    fn what_a_filter_states_is_averaged_by_channel_and_state() {
        let stated = |encoder: f64, gain: f64| Run {
            nis_mean: [("encoder", Some(encoder)), ("width", None)].into(),
            coverage: Some([0.9, 0.91, 0.92, 0.93, 0.94, gain]),
            ..run(1, "done", None)
        };
        let group =
            Group::of("mpc".to_owned(), vec![stated(0.5, 0.95), stated(0.7, 0.97), run(3, "done", None)]);
        for (name, mean) in [("nis_encoder", 0.6), ("coverage_gain", 0.96)] {
            assert!((group.mean[name] - mean).abs() < 1e-12 && group.count[name] == 2, "{name}: {group:?}");
        }
        let states = STATE_NAMES.map(|state| group.mean[format!("coverage_{state}").as_str()]);
        assert!(states.is_sorted() && group.count["nis_width"] == 0, "{states:?}");
    }

    #[test]
    fn a_group_that_is_complete_says_nothing_of_counts() {
        let group = Group::of("off".to_owned(), vec![run(1, "done", Some(1.0)), run(2, "done", Some(1.0))]);
        let told = text::table(&[group]);
        assert!(
            told.contains("2 of 2") && !told.contains("(2 of 2)") && !told.contains("NOT FINISHED"),
            "{told}"
        );
    }

    #[test]
    fn mean_and_sample_deviation() {
        // Deviations -1, 0, 1: variance 2 / (3 - 1) = 1.
        assert_eq!(mean_and_deviation(&[1.0, 2.0, 3.0]), Some((2.0, 1.0)));
        assert_eq!(mean_and_deviation(&[5.0]), Some((5.0, 0.0)));
        assert_eq!(mean_and_deviation(&[]), None);
    }
}
