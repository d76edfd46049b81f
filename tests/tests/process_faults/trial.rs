//! One fault of one node, and the times of what followed.

use crate::graph::{Graph, Said};
use crate::observer::{Observer, Seen, is_neutral};
use fdm_loop_msgs::{Header, PrinterState, SafetyState};
use models::units::Seconds;
use rustix::process::Signal;

/// How long a process is stopped: the acceptance's own figure.
pub(crate) const STOPPED: Seconds = Seconds(5.0);
/// Longest wait for a graph that is whole.
const PATIENCE: Seconds = Seconds(12.0);
/// So long a graph stays whole to be called whole `[s]`: longer than the supervisor's patience with any stream.
const LASTS_S: f64 = 1.0;

/// What is done to the process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// kill -9.
    Kill,
    /// SIGSTOP for 5 s, then SIGCONT.
    Stop,
}

/// What a node is to the printer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// Without it the printer runs on as it is.
    Aside,
    /// Without it the supervisor takes the corrections back once its stream is overdue: nobody watches the print.
    Watch,
    /// Without it the supervisor takes the corrections back.
    ControlPath,
    /// Without it the printer takes the corrections back.
    Supervisor,
}

/// Times from the fault on; `None` for what was not observed. What printer and supervisor do is dated by their stamps, on
/// the graph's clock, which lags behind the observer's where the machine is loaded; the rest by its arrival.
#[derive(Debug, Default)]
pub(crate) struct Times {
    /// `fdm` says that the process has ended or hangs.
    pub(crate) told: Option<f64>,
    /// The supervisor leaves its mode; for the supervisor's own absence: the printer's dead-man acts.
    pub(crate) acted: Option<f64>,
    /// The printer is at the slicer's values.
    pub(crate) neutral: Option<f64>,
    /// The process is there again: started again, or continued.
    pub(crate) back: Option<f64>,
    /// `fdm` started it again.
    pub(crate) started: Option<f64>,
    /// The first heartbeat of its next run.
    pub(crate) beats: Option<f64>,
    /// Mode `act`, and corrections in force.
    pub(crate) whole: Option<f64>,
    /// The job was paused.
    pub(crate) paused: Option<f64>,
    /// Heaters off, latched.
    pub(crate) safe_off: Option<f64>,
}

/// One fault of one node.
pub(crate) struct Trial {
    pub(crate) node: &'static str,
    pub(crate) fault: Fault,
    pub(crate) role: Role,
    pub(crate) times: Times,
    /// Run of the node before the fault.
    session: Option<u64>,
    /// Time of the fault on the graph's clock, at most a period of `printer/state` too early.
    stamp_s: f64,
    mode: u8,
    corrected: bool,
    /// Since when all looks whole.
    looks_whole: Option<f64>,
}

impl Trial {
    /// Waits for a graph that is whole, then stops or kills the process and looks on until it is whole again.
    pub(crate) async fn run(
        node: &'static str,
        role: Role,
        fault: Fault,
        (observer, graph): (&mut Observer, &mut Graph),
    ) -> Self {
        let (session, stamp_s) = whole(node, observer, graph).await;
        let signal = if fault == Fault::Kill { Signal::KILL } else { Signal::STOP };
        println!("{node}: {signal:?}");
        let begin = observer.now();
        graph.signal(node, signal);
        let mut trial = Self {
            node,
            fault,
            role,
            times: Times::default(),
            session: Some(session),
            stamp_s,
            mode: SafetyState::MODE_ACT,
            corrected: true,
            looks_whole: None,
        };
        loop {
            let (at, seen) = observer.next(graph).await;
            trial.take((at - begin).0, &seen);
            let now_s = (observer.now() - begin).0;
            if fault == Fault::Stop && trial.times.back.is_none() && now_s >= STOPPED.0 {
                graph.signal(node, Signal::CONT);
                trial.times.back = Some(now_s);
            }
            if trial.ended() || now_s > trial.times.back.unwrap_or(0.0) + PATIENCE.0 {
                return trial;
            }
        }
    }

    fn ended(&self) -> bool {
        self.times.whole.is_some() || (self.times.safe_off.is_some() && self.times.beats.is_some())
    }

    fn take(&mut self, at_s: f64, seen: &Seen) {
        // What was on its way before the fault says nothing of it.
        if at_s <= 0.0 {
            return;
        }
        match seen {
            Seen::Printer(state) => self.on_printer(state),
            Seen::Safety(state) => self.on_safety(state),
            Seen::Heart(name, session) if name == self.node && Some(*session) != self.session => {
                self.times.beats.get_or_insert(at_s);
            }
            Seen::Said(Said::Ended(name) | Said::Silent(name)) if name == self.node => {
                self.times.told.get_or_insert(at_s);
            }
            Seen::Said(Said::RunsAgain(name)) if name == self.node => {
                self.times.started.get_or_insert(at_s);
                self.times.back.get_or_insert(at_s);
            }
            _ => {}
        }
        let acts = self.mode == SafetyState::MODE_ACT && self.corrected;
        let whole = acts && self.times.beats.is_some();
        self.looks_whole = whole.then(|| self.looks_whole.unwrap_or(at_s));
        if self.looks_whole.is_some_and(|since| at_s - since > LASTS_S) {
            self.times.whole = self.looks_whole;
        }
    }

    fn on_printer(&mut self, state: &PrinterState) {
        let at_s = stamp_s(&state.header) - self.stamp_s;
        self.corrected = !is_neutral(state);
        if self.corrected {
            return;
        }
        if self.role == Role::Supervisor {
            self.times.acted.get_or_insert(at_s);
        }
        self.times.neutral.get_or_insert(at_s);
    }

    fn on_safety(&mut self, state: &SafetyState) {
        let at_s = stamp_s(&state.header) - self.stamp_s;
        self.mode = state.mode;
        if state.mode >= SafetyState::MODE_DEGRADED {
            self.times.acted.get_or_insert(at_s);
        }
        if state.mode == SafetyState::MODE_PAUSED {
            self.times.paused.get_or_insert(at_s);
        }
        if state.mode == SafetyState::MODE_SAFE_OFF {
            self.times.safe_off.get_or_insert(at_s);
        }
    }

    /// From the return of the process until all is whole again.
    pub(crate) fn whole_after_back_s(&self) -> Option<f64> {
        Some(self.times.whole? - self.times.back?)
    }
}

fn stamp_s(header: &Header) -> f64 {
    header.stamp.seconds().unwrap()
}

/// Waits until the loop is closed and the node is heard; yields the node's session and the time on the graph's clock.
async fn whole(node: &str, observer: &mut Observer, graph: &mut Graph) -> (u64, f64) {
    let (mut acts, mut corrected, mut session, mut newest_s) = (false, false, None, 0.0);
    let closed = observer.until(graph, PATIENCE, |_, seen| {
        match seen {
            Seen::Safety(state) => acts = state.mode == SafetyState::MODE_ACT,
            Seen::Printer(state) => {
                corrected = !is_neutral(state);
                newest_s = stamp_s(&state.header);
            }
            Seen::Heart(name, run) if name == node => session = Some(*run),
            _ => {}
        }
        acts && corrected && session.is_some()
    });
    let closed = closed.await;
    assert!(closed, "before {node}: acts {acts}, corrected {corrected}, heard {}", session.is_some());
    (session.unwrap(), newest_s)
}
