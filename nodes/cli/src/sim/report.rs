//! Results of `fdm sim` with the names of the JSON contract.

use super::consistency::Told;
use super::sight::SightFigures;
use serde::Serialize;
use std::collections::BTreeMap;

/// Something that the loop noticed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Detection {
    /// Fault as its finder names it.
    pub fault: String,
    /// Onset of the newest fault that had set in by then `[s]`; absent where none had.
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
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
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
    /// Source of the pressure advance that was asked for.
    pub advance: String,
    /// The one in force under this control level and behind this host.
    pub advance_in_force: &'static str,
    /// Moves that the firmware knows ahead; `null` for the printer's own look-ahead.
    pub buffer: Option<u32>,
    /// Sensors that the printer does without.
    pub without: Vec<String>,
    /// Sensors that are fitted besides.
    pub with: Vec<String>,
    /// States that no sensor told of while roads were laid: what the estimator says of them is its model's.
    pub states_not_observed: Vec<&'static str>,
    /// Those of them that it held at what it believed.
    pub states_held: Vec<&'static str>,
    /// Form of the estimator's filter.
    pub filter: &'static str,
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
    /// The same over deposits no more than 0.2 s before or after a change of the tool's speed in the file.
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
    /// The same of the states alone that sensors tell of, and its 95 % band; `null` before a road.
    pub nees_told: Option<Told>,
    /// Share of the time within the stated 95 % interval, by state.
    pub coverage: Option<[f64; 6]>,
    /// Names of these states.
    pub coverage_states: [&'static str; 6],
    /// Share of the time of deposition with a trim of flow or speed beyond 1 %.
    pub trimmed_share: Option<f64>,
    /// The same of feedback alone: the spool's calibration is taken out.
    pub feedback_share: Option<f64>,
    /// Share of the time of deposition in moves that are planned more than 1 % slower than the file's, since the drive's force
    /// would not suffice.
    pub slowed_share: Option<f64>,
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
