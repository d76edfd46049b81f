//! Limits of the acceptance and the table of what was measured.

use crate::trial::{Fault, Role, STOPPED, Trial};
use std::fmt::Write;

/// A fault is seen within this time `[s]`.
const SEEN_S: f64 = 1.0;
/// A node of the control path away: the printer is at the slicer's values `[s]`.
const NEUTRAL_S: f64 = 2.5;
/// Frames overdue, the ramp and delays: nobody watches `[s]`.
const NEUTRAL_WATCH_S: f64 = 4.0;
/// The same without the supervisor `[s]`: the permit's validity.
const NEUTRAL_SUPERVISOR_S: f64 = 0.25;
/// Between a permit that lapses and a state that shows it: a look of the printer and two periods of `printer/state` `[s]`.
const OBSERVED_S: f64 = 0.05;
/// All is whole again after the process is back `[s]`.
const WHOLE_S: f64 = 5.0;
/// S7 of the thermistor: pause and switch-off `[s]`, and a period of its samples, ticks and states.
const PAUSED_S: f64 = 1.5;
const SAFE_OFF_S: f64 = 3.0;
const S7_SPAN_S: f64 = 0.2;

/// Whether this trial ends the print by S7.
fn trips(trial: &Trial) -> bool {
    trial.node == "thermistor" && trial.fault == Fault::Stop
}

/// One row a trial, all times in seconds from the fault but the last column.
pub(crate) fn table(trials: &[Trial]) -> String {
    let mut text = String::new();
    let cell = |time: Option<f64>| time.map_or("-".to_owned(), |time| format!("{time:.2}"));
    _ = writeln!(
        text,
        "{:<18} {:<5} {:>6} {:>6} {:>8} {:>6} {:>8} {:>6} {:>7} {:>9} {:>6} {:>16}",
        "node",
        "fault",
        "told",
        "acted",
        "neutral",
        "back",
        "started",
        "beats",
        "paused",
        "safe off",
        "whole",
        "whole after back"
    );
    for trial in trials {
        let times = &trial.times;
        let fault = if trial.fault == Fault::Kill { "kill" } else { "stop" };
        _ = writeln!(
            text,
            "{:<18} {fault:<5} {:>6} {:>6} {:>8} {:>6} {:>8} {:>6} {:>7} {:>9} {:>6} {:>16}",
            trial.node,
            cell(times.told),
            cell(times.acted),
            cell(times.neutral),
            cell(times.back),
            cell(times.started),
            cell(times.beats),
            cell(times.paused),
            cell(times.safe_off),
            cell(times.whole),
            cell(trial.whole_after_back_s()),
        );
    }
    text
}

/// What lies outside of the limits.
pub(crate) fn failures(trials: &[Trial]) -> Vec<String> {
    trials.iter().flat_map(failures_of).collect()
}

fn failures_of(trial: &Trial) -> Vec<String> {
    let mut failures = Vec::new();
    let mut within = |what: &str, time: Option<f64>, limit_s: f64| {
        if time.is_none_or(|time| time > limit_s) {
            failures.push(format!("{} {:?}: {what} {time:?}, limit {limit_s} s", trial.node, trial.fault));
        }
    };
    let times = &trial.times;
    let seen = [times.told, times.acted].into_iter().flatten().reduce(f64::min);
    within("seen", seen, SEEN_S);
    // A process that is replaced before anybody had to miss it changes nothing.
    let missed = trial.fault == Fault::Stop || times.acted.is_some();
    match trial.role {
        Role::ControlPath if missed => {
            within("acted", times.acted, SEEN_S);
            within("neutral", times.neutral, NEUTRAL_S);
        }
        Role::Watch if trial.fault == Fault::Stop => within("neutral", times.neutral, NEUTRAL_WATCH_S),
        Role::Supervisor => within("neutral", times.neutral, NEUTRAL_SUPERVISOR_S + OBSERVED_S),
        Role::ControlPath | Role::Watch | Role::Aside => {}
    }
    if trips(trial) {
        within("paused", times.paused, PAUSED_S + S7_SPAN_S);
        within("safe off", times.safe_off, SAFE_OFF_S + S7_SPAN_S);
        within("beats", times.beats, STOPPED.0 + WHOLE_S);
        within("not paused too early", times.paused.map(|time| -time), -PAUSED_S + S7_SPAN_S);
        within("not off too early", times.safe_off.map(|time| -time), -SAFE_OFF_S + S7_SPAN_S);
    } else {
        within("whole after back", trial.whole_after_back_s(), WHOLE_S);
        if times.paused.is_some() || times.safe_off.is_some() {
            failures.push(format!("{} {:?}: the print was paused or ended", trial.node, trial.fault));
        }
    }
    if trial.role == Role::Aside && (times.acted.is_some() || times.neutral.is_some()) {
        failures.push(format!("{} {:?}: control was affected", trial.node, trial.fault));
    }
    failures
}
