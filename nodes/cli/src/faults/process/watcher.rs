//! What follows on a fault, by the clock of the observer and by that of the graph.

use super::jitter::Jitter;
use super::observer::{Seen, is_neutral};
use super::off::Off;
use crate::up::fleet::Happening;
use crate::up::words::mode_name;
use fdm_loop_msgs::{DiagnosticArray, DiagnosticStatus, Header, PrinterState, SafetyState, SimTruth};
use models::units::Seconds;

/// So long a graph stays whole to be called whole `[s]`: longer than the supervisor's patience with any stream.
const LASTS_S: f64 = 1.0;
/// What the supervisor's own status says where its permits come irregularly.
const ALARM: &str = "irregular";

/// What was seen since a moment. Times count from there `[s]`; what printer and supervisor do is dated by their stamps, on
/// the graph's clock, which lags behind the observer's where the machine is loaded; the rest by its arrival.
#[derive(Debug)]
pub(super) struct Watcher {
    begin: Seconds,
    stamp_s: f64,
    /// Mode of the supervisor, and why.
    pub(super) mode: u8,
    pub(super) cause: String,
    /// Corrections are in force.
    pub(super) corrected: bool,
    /// Highest mode, and why.
    pub(super) worst: (u8, String),
    /// The supervisor left its mode.
    pub(super) acted: Option<f64>,
    /// The printer was at the slicer's values.
    pub(super) neutral: Option<f64>,
    pub(super) paused: Option<f64>,
    pub(super) safe_off: Option<f64>,
    /// The mains relay was open.
    pub(super) mains_open: Option<f64>,
    /// What was seen behind SAFE_OFF and ESTOP.
    pub(super) off: Off,
    /// Newest state of the printer.
    pub(super) printer: Option<Box<PrinterState>>,
    /// The supervisor told that its permits come irregularly.
    pub(super) alarmed: bool,
    /// Nodes that ended or fell silent.
    pub(super) fallen: Vec<&'static str>,
    /// How regularly it ticked.
    pub(super) jitter: Jitter,
    /// Longest time between two states of the printer `[s]`.
    pub(super) gap_s: f64,
    heard: Option<Seconds>,
    heard_act: bool,
    looks_whole: Option<f64>,
}

impl Watcher {
    /// Looks from `begin` on, `stamp_s` on the graph's clock.
    pub(super) fn new(begin: Seconds, stamp_s: f64) -> Self {
        Self {
            begin,
            stamp_s,
            mode: SafetyState::MODE_ACT,
            cause: String::new(),
            corrected: true,
            worst: (0, String::new()),
            acted: None,
            neutral: None,
            paused: None,
            safe_off: None,
            mains_open: None,
            off: Off::default(),
            printer: None,
            alarmed: false,
            fallen: Vec::new(),
            jitter: Jitter::default(),
            gap_s: 0.0,
            heard: None,
            heard_act: false,
            looks_whole: None,
        }
    }

    /// Time since the beginning `[s]`.
    pub(super) fn since(&self, now: Seconds) -> f64 {
        (now - self.begin).0
    }

    /// Takes in what was seen.
    pub(super) fn take(&mut self, at: Seconds, seen: &Seen) {
        // What was on its way before says nothing of what came after.
        if at <= self.begin {
            return;
        }
        match seen {
            Seen::Printer(state) => self.on_printer(at, state),
            Seen::Truth(truth) => self.on_truth(truth),
            Seen::Safety(state) => self.on_safety(state),
            Seen::Report(report) => self.on_report(report),
            Seen::Happened(Happening::Silent { name }) => self.fallen.push(name),
            Seen::Happened(happening) => self.fallen.extend(happening.ended()),
            _ => {}
        }
        let at_s = self.since(at);
        let whole =
            self.heard_act && self.mode == SafetyState::MODE_ACT && self.printer.is_some() && self.corrected;
        self.looks_whole = whole.then(|| self.looks_whole.unwrap_or(at_s));
    }

    /// Since when the loop is closed, where it has been for a while.
    pub(super) fn is_whole_since(&self) -> Option<f64> {
        let heard = self.since(self.heard?);
        self.looks_whole.filter(|since| heard - since > LASTS_S)
    }

    /// Everything that says that control was affected.
    pub(super) fn affected(&self) -> Option<String> {
        let (mode, cause) = &self.worst;
        if *mode > SafetyState::MODE_ACT {
            return Some(format!("{} ({cause})", mode_name(*mode)));
        }
        self.neutral.map(|at_s| format!("at the slicer's values after {at_s:.2} s"))
    }

    fn on_printer(&mut self, at: Seconds, state: &PrinterState) {
        if let Some(before) = self.heard.replace(at) {
            self.gap_s = self.gap_s.max((at - before).0);
        }
        let Some(at_s) = self.on_graph(&state.header) else { return };
        self.corrected = !is_neutral(state);
        if !self.corrected {
            self.neutral.get_or_insert(at_s);
        }
        if !state.mains_on {
            self.mains_open.get_or_insert(at_s);
            self.off.react(at_s);
        }
        self.off.on_printer(at_s, state);
        self.printer = Some(Box::new(state.clone()));
    }

    fn on_truth(&mut self, truth: &SimTruth) {
        if let Some(at_s) = self.on_graph(&truth.header) {
            self.off.on_truth(at_s, truth);
        }
    }

    fn on_report(&mut self, report: &DiagnosticArray) {
        let own = |status: &&DiagnosticStatus| status.name.ends_with("safety_supervisor");
        for status in report.status.iter().filter(own) {
            self.alarmed |= status.level >= DiagnosticStatus::WARN && status.message.contains(ALARM);
            self.jitter.take(status);
        }
    }

    fn on_safety(&mut self, state: &SafetyState) {
        let Some(at_s) = self.on_graph(&state.header) else { return };
        self.mode = state.mode;
        self.cause.clone_from(&state.cause);
        self.heard_act |= state.mode == SafetyState::MODE_ACT;
        if state.mode > self.worst.0 {
            self.worst = (state.mode, state.cause.clone());
        }
        if state.mode >= SafetyState::MODE_DEGRADED {
            self.acted.get_or_insert(at_s);
        }
        if state.mode == SafetyState::MODE_PAUSED {
            self.paused.get_or_insert(at_s);
        }
        if state.mode >= SafetyState::MODE_SAFE_OFF {
            self.off.react(at_s);
        }
        if state.mode == SafetyState::MODE_SAFE_OFF {
            self.safe_off.get_or_insert(at_s);
        }
    }

    /// Time on the graph's clock since the beginning.
    fn on_graph(&self, header: &Header) -> Option<f64> {
        header.stamp.seconds().map(|stamp_s| stamp_s - self.stamp_s)
    }
}
