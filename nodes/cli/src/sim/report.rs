//! Results of `fdm sim` with the names of the JSON contract.

use super::sight::SightFigures;
use serde::Serialize;
use std::collections::BTreeMap;

/// Something that the loop noticed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Detection {
    /// Fault as its finder names it.
    pub fault: String,
    /// Onset of the first fault `[s]`; absent where nothing was injected.
    pub onset_s: Option<f64>,
    /// When it was noticed `[s]`.
    pub detected_s: f64,
    /// What followed.
    pub action: String,
}

/// A pause that the file itself asks for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FilePause {
    /// Line of the file, from 1.
    pub line: u64,
    /// When the loop adopted it `[s]`.
    pub detected_s: f64,
}

/// Largest corrections of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Extremes {
    /// |flow trim - 1| `[-]`.
    pub flow: f64,
    /// |speed trim - 1| `[-]`.
    pub speed: f64,
    /// |set-point offset| `[K]`.
    pub setpoint_k: f64,
    /// |slip compensation| `[-]`.
    pub slip: f64,
}

/// What became of the pressure advance.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct AdvanceFigures {
    /// Mean of the advance in force over deposits `[s]`.
    pub mean_s: Option<f64>,
    /// Commands that hurried a change since a turn was foreseen.
    pub hurried: u64,
    /// Commands without a foretold advance where one was asked for.
    pub without: u64,
    /// Learnt factor on the foretold advance at the end `[-]`.
    pub learnt: f64,
    /// Conditions outside of the networks' data, for which the physical model answered; `null` where nothing is foretold.
    pub outside_hull: Option<u64>,
    /// Conditions that nothing was foretold for; `null` as above.
    pub unanswered: Option<u64>,
}

/// One run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Run {
    /// Odd lines of the file: read, refused or left out as `fdm gcode` says.
    pub gcode_oddities: u64,
    /// File name.
    pub gcode: String,
    /// Material.
    pub material: String,
    /// Scenario.
    pub scenario: String,
    /// `off`, `encoder` or `mpc`.
    pub control: String,
    /// Host profile.
    pub host: String,
    /// Source of the pressure advance.
    pub advance: String,
    /// Moves that the firmware knows ahead; `null` for the printer's own look-ahead.
    pub buffer: Option<u32>,
    /// Seed of all noise.
    pub seed: u64,
    /// How the job ended.
    pub ended: String,
    /// Simulated time of the job, heating included `[s]`.
    pub print_time_s: f64,
    /// Time that the simulation took `[s]`.
    pub wall_time_s: f64,
    /// Simulated over wall time.
    pub realtime_factor: f64,
    /// Mean of Q.
    pub quality_mean: Option<f64>,
    /// RMS of the relative width error.
    pub width_rms_rel: Option<f64>,
    /// The same over deposits no more than 0.2 s before or after a change of the tool's speed.
    pub corner_width_rms_rel: Option<f64>,
    /// Time of those deposits `[s]`.
    pub corner_time_s: f64,
    /// |delivered / commanded - 1|.
    pub feed_error_rel: Option<f64>,
    /// The same from 2 s after the first onset on.
    pub feed_error_after_2s_rel: Option<f64>,
    /// The same from 8 s after the first onset on.
    pub feed_error_after_8s_rel: Option<f64>,
    /// Time until the width is back, see `architecture.md`; `null` if never or without a fault.
    pub recovery_time_s: Option<f64>,
    /// Time until the width is back within 2 % for 5 s; `null` if never or without a fault.
    pub recovery_5s_s: Option<f64>,
    /// Mean NIS by channel.
    pub nis_mean: BTreeMap<&'static str, Option<f64>>,
    /// Median NEES; six states.
    pub nees_median: Option<f64>,
    /// Share of the time within the stated 95 % interval: block, nozzle, thermistor, flow, slip, gain.
    pub coverage: Option<[f64; 6]>,
    /// Share of the time of deposition with a trim of flow or speed beyond 1 %.
    pub trimmed_share: Option<f64>,
    /// The same of feedback alone: the spool's calibration is taken out.
    pub feedback_share: Option<f64>,
    /// What the loop noticed after the onset.
    pub detections: Vec<Detection>,
    /// How often it noticed something with nothing wrong.
    pub false_alarms: usize,
    /// What that was.
    pub false_alarm_list: Vec<Detection>,
    /// Pauses that the file itself asks for: no fault, no alarm.
    pub file_pauses: Vec<FilePause>,
    /// What became of the pressure advance.
    pub advance_control: AdvanceFigures,
    /// Largest corrections.
    pub max_command: Extremes,
    /// What the camera saw, beside the truth; absent without `--camera`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<SightFigures>,
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
    /// Mean by figure, over the runs that have it.
    pub mean: BTreeMap<&'static str, f64>,
    /// Standard deviation by figure.
    pub spread: BTreeMap<&'static str, f64>,
}

/// Several runs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// One group a control level.
    pub results: Vec<Group>,
}

type Figure = (&'static str, fn(&Run) -> Option<f64>);

/// Figures that are averaged.
const FIGURES: [Figure; 11] = [
    ("quality_mean", |run| run.quality_mean),
    ("width_rms_rel", |run| run.width_rms_rel),
    ("corner_width_rms_rel", |run| run.corner_width_rms_rel),
    ("print_time_s", |run| Some(run.print_time_s)),
    ("feed_error_rel", |run| run.feed_error_rel),
    ("feed_error_after_2s_rel", |run| run.feed_error_after_2s_rel),
    ("feed_error_after_8s_rel", |run| run.feed_error_after_8s_rel),
    ("recovery_time_s", |run| run.recovery_time_s),
    ("recovery_5s_s", |run| run.recovery_5s_s),
    ("nees_median", |run| run.nees_median),
    ("realtime_factor", |run| Some(run.realtime_factor)),
];

impl Group {
    /// Averages the runs of one control level.
    #[must_use]
    pub fn of(control: String, runs: Vec<Run>) -> Self {
        let (mut mean, mut spread) = (BTreeMap::new(), BTreeMap::new());
        for (name, figure) in FIGURES {
            let values: Vec<f64> = runs.iter().filter_map(figure).collect();
            if let Some((average, deviation)) = mean_and_deviation(&values) {
                mean.insert(name, average);
                spread.insert(name, deviation);
            }
        }
        Self { control, seeds: runs.len(), runs, mean, spread }
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

    #[test]
    fn mean_and_sample_deviation() {
        // Deviations -1, 0, 1: variance 2 / (3 - 1) = 1.
        assert_eq!(mean_and_deviation(&[1.0, 2.0, 3.0]), Some((2.0, 1.0)));
        assert_eq!(mean_and_deviation(&[5.0]), Some((5.0, 0.0)));
        assert_eq!(mean_and_deviation(&[]), None);
    }
}
