//! What was printed, how far it came, and under which mode of the supervisor.

use super::super::decode::short;
use super::ending::Ending;
use crate::operate::stop;
use crate::up::words::mode_name;
use fdm_loop_msgs::{PrintEvent, PrintInfo, PrinterState, SafetyState};
use runtime::topics;
use std::collections::{BTreeMap, BTreeSet};

/// Longest text of a field.
const TEXT_MAX: usize = 200;
/// Longest configuration that is shown `[byte]`.
const CONFIG_MAX: usize = 80_000;
/// Changes of mode that are kept.
const MODES_MAX: usize = 400;
/// A supervisor that has said nothing for longer was not there `[s]`: three times its period.
const SILENT_S: f64 = 3.0 * topics::SAFETY_STATE_PERIOD.0;
/// Prints that are told apart in one bag.
const PRINTS_MAX: usize = 100;
/// Time in which no supervisor was heard.
const NO_SUPERVISOR: &str = "no supervisor";
/// Filament where the configuration does not say `[m]`.
const FILAMENT_DIAMETER_M: f64 = 1.75e-3;

/// The print as a whole.
#[derive(Debug, Default)]
pub(crate) struct Print {
    /// Names and values of the newest description: from the topic, or from the recorder's note.
    pub(crate) described: BTreeMap<&'static str, String>,
    pub(crate) config: String,
    /// Material, control level, host, mode at the start, sensors fitted and not, by the configuration.
    pub(crate) configured: BTreeMap<&'static str, String>,
    diameter_m: Option<f64>,
    /// When recording began, wall clock `[s]` since 1970.
    pub(crate) began_wall_s: Option<u64>,
    pub(crate) last: Option<PrinterState>,
    pub(crate) last_s: f64,
    /// First deposit on the axis.
    pub(crate) first_road_s: Option<f64>,
    pub(crate) last_road_s: f64,
    /// Modes of the supervisor with the time each was entered; `None` where it was silent.
    modes: Vec<(f64, Option<u8>)>,
    safety_s: f64,
    pub(crate) safety: Option<SafetyState>,
    /// What held the print up and ended it.
    pub(crate) ending: Ending,
    /// Prints by their names.
    pub(crate) prints: BTreeSet<String>,
}

/// Fields of a description by their names in the recorder's note.
const DESCRIBED: [&str; 6] = ["print_id", "gcode_file", "gcode_sha256", "config_sha256", "build", "scenario"];

impl Print {
    /// Takes the description of a print in.
    pub(crate) fn info(&mut self, _at: f64, info: &PrintInfo) {
        let values = [
            &info.print_id,
            &info.gcode_file,
            &info.gcode_sha256,
            &info.config_sha256,
            &info.build,
            &info.scenario,
        ];
        self.described = DESCRIBED.into_iter().zip(values.map(|value| short(value, TEXT_MAX))).collect();
        self.named(&info.print_id);
        self.configuration(&info.config);
    }

    /// Takes a note of the recorder in.
    pub(crate) fn note(&mut self, values: &BTreeMap<String, String>) {
        self.named(values.get("print_id").map_or("", String::as_str));
        for name in DESCRIBED {
            if let Some(value) = values.get(name) {
                self.described.entry(name).or_insert_with(|| short(value, TEXT_MAX));
            }
        }
        if self.config.is_empty()
            && let Some(config) = values.get("config")
        {
            self.configuration(config);
        }
        let wall_ns = values.get("start_wall_ns").and_then(|text| text.parse::<u64>().ok());
        self.began_wall_s = self.began_wall_s.or(wall_ns.map(|ns| ns / 1_000_000_000));
    }

    fn named(&mut self, print_id: &str) {
        if !print_id.is_empty() && self.prints.len() < PRINTS_MAX {
            self.prints.insert(short(print_id, TEXT_MAX));
        }
    }

    fn configuration(&mut self, text: &str) {
        const WANTED: [(&str, &str); 7] = [
            ("material.name", "material"),
            ("control", "control"),
            ("simulator.host", "host"),
            ("start_mode", "start_mode"),
            ("sensors.without", "without"),
            ("sensors.with", "with"),
            ("printer.extruder.filament_diameter_m", "filament"),
        ];
        for line in text.lines() {
            let Some((key, value)) = line.split_once(": ") else { continue };
            let Some((_, name)) = WANTED.iter().find(|(wanted, _)| *wanted == key) else { continue };
            let value = value.trim().trim_matches('"');
            if *name == "filament" {
                self.diameter_m = value.parse().ok().filter(|m: &f64| (1e-4..1e-2).contains(m));
            } else {
                // A bare `off` is recorded as the boolean that YAML reads it as.
                let value = if *name == "control" && value == "false" { "off" } else { value };
                self.configured.insert(name, short(value, TEXT_MAX));
            }
        }
        let mut config = text.get(..CONFIG_MAX).unwrap_or_default().to_owned();
        if text.len() <= CONFIG_MAX {
            text.clone_into(&mut config);
        }
        self.config = config;
    }

    /// Section of the filament `[m2]`.
    pub(crate) fn filament_area_m2(&self) -> f64 {
        let diameter_m = self.diameter_m.unwrap_or(FILAMENT_DIAMETER_M);
        std::f64::consts::FRAC_PI_4 * diameter_m * diameter_m
    }

    /// Takes the state of the printer in.
    pub(crate) fn state(&mut self, at: f64, state: &PrinterState) {
        if at >= self.last_s {
            self.last_s = at;
            self.last = Some(state.clone());
            self.ending.phase(at, state.phase);
        }
        if state.depositing {
            self.first_road_s.get_or_insert(at);
            self.last_road_s = self.last_road_s.max(at);
        }
    }

    /// Takes the supervisor's state in.
    pub(crate) fn safety(&mut self, at: f64, state: &SafetyState) {
        if !self.modes.is_empty() && at - self.safety_s > SILENT_S {
            self.enter(self.safety_s, None);
        }
        self.enter(at, Some(state.mode));
        self.safety_s = self.safety_s.max(at);
        let goes_on = self.last.as_ref().is_some_and(|last| last.phase == PrinterState::PHASE_PRINTING);
        self.ending.safety(at, state, goes_on);
        self.safety = Some(state.clone());
    }

    /// Takes an event in: who stops a print past a supervisor that does not answer leaves its cause there alone.
    pub(crate) fn event(&mut self, at: f64, event: &PrintEvent) {
        if stop::is_past_the_supervisor(event) {
            self.ending.past_the_supervisor(at, event);
        }
    }

    fn enter(&mut self, at: f64, mode: Option<u8>) {
        let changed = self.modes.last().is_none_or(|(_, last)| *last != mode);
        if changed && self.modes.len() < MODES_MAX {
            self.modes.push((at, mode));
        }
    }

    /// Time in each mode until `end_s`, by name; time in which the supervisor was silent is in none.
    pub(crate) fn time_in_modes(&self, end_s: f64) -> BTreeMap<&'static str, f64> {
        let mut times = BTreeMap::new();
        let silent = (end_s - self.safety_s > SILENT_S).then_some((self.safety_s, None));
        let entered: Vec<_> = self.modes.iter().copied().chain(silent).collect();
        let ends = entered.iter().skip(1).map(|(at, _)| *at).chain([end_s]);
        for ((from, mode), to) in entered.iter().zip(ends) {
            *times.entry(mode.map_or(NO_SUPERVISOR, mode_name)).or_insert(0.0) += (to - from).max(0.0);
        }
        times
    }

    /// Phase of the job at the end, as a name.
    pub(crate) fn phase(&self) -> Option<&'static str> {
        const NAMES: [&str; 6] = ["idle", "preparing", "printing", "paused", "done", "failed"];
        let phase = self.last.as_ref()?.phase;
        Some(NAMES.get(usize::from(phase)).copied().unwrap_or("unknown"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::command::Request;
    use models::units::Seconds;

    /// C2: a supervisor that is killed in `act` guards nothing until it is there again, and after its last word.
    #[test]
    fn time_without_a_supervisor_is_in_no_mode() {
        let mut print = Print::default();
        let state = SafetyState { mode: SafetyState::MODE_ACT, ..SafetyState::default() };
        for tenths in (0..=50).chain(200..=300) {
            print.safety(f64::from(tenths) * 0.1, &state);
        }
        let times = print.time_in_modes(40.0);
        assert_eq!(times.keys().copied().collect::<Vec<_>>(), ["act", NO_SUPERVISOR]);
        assert!(
            (times["act"] - 15.0).abs() < 1e-9 && (times[NO_SUPERVISOR] - 25.0).abs() < 1e-9,
            "{times:?}"
        );
    }

    /// Whoever else says so.
    #[test]
    fn a_stop_past_the_supervisor_is_told_by_the_command_alone() {
        let mut print = Print::default();
        let event = stop::told(Seconds(12.0), Request::HeatersOff);
        print.event(11.0, &PrintEvent { who: "somebody".to_owned(), ..event.clone() });
        assert_eq!(print.ending.stop(), None);
        print.event(12.0, &event);
        assert!(print.ending.stop().is_some());
    }
}
