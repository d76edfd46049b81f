//! `fdm` as a participant of the graph: follows the print, shows progress, notes what happens.

use super::ears::Ears;
use super::ended::{Ended, Marks};
use super::ending;
use super::failure::Failure;
use super::fleet::{Fleet, Happening};
use super::guard::Guard;
use super::hearing::Hearing;
use super::recipes::{NODES, Plan};
use super::reports::Reports;
use super::words::{at_the_end, mode_name, text, todo};
use crate::output;
use crate::suspension::Suspension;
use anyhow::bail;
use fdm_loop_msgs::{PrinterState, SafetyState, SimTruth};
use indicatif::ProgressBar;
use models::status::JobPhase;
use models::units::Seconds;
use printer_sim::score::Integrals;
use rustix::process::Signal;
use std::io::IsTerminal;

mod fate;
mod news;
mod shown;

/// How often processes and topics are looked at `[s]`.
const LOOK_S: f64 = 0.05;
/// Time to hear a graph that already runs `[s]`.
const LISTEN_S: f64 = 1.0;
/// From here on after the onset the feed error counts as settled `[s]`.
const SETTLE_S: f64 = 2.0;
/// The printer's state stays away this long after it was heard: the simulation is over or dead `[s]`.
const LOST_S: f64 = 20.0;

/// The graph as `fdm` sees it.
pub struct Watch {
    pub(super) ears: Ears,
    pub(super) namespace: String,
    hearing: Hearing,
    bar: ProgressBar,
    /// When progress was told last, where no terminal shows a bar.
    told: Option<Seconds>,
    newest_state: Option<PrinterState>,
    newest_safety: Option<SafetyState>,
    guard: Guard,
    failure: Failure,
    reports: Reports,
    started: Seconds,
    stay: bool,
    host_clock: bool,
    /// Integrals of the truth.
    pub marks: Marks,
    /// Processes that ended or fell silent, and what became of them.
    pub happenings: Vec<Happening>,
    /// Modes of the supervisor and its causes, as they change: simulated time and text.
    pub modes: Vec<(f64, String)>,
}

impl Watch {
    /// Joins the graph.
    ///
    /// # Errors
    /// What keeps the participant from starting.
    pub fn start(plan: &Plan, quiet: bool) -> anyhow::Result<Self> {
        let ears = Ears::join(&plan.namespace)?;
        let bar = if quiet { ProgressBar::hidden() } else { output::bar(1000, "permille") };
        Ok(Self {
            hearing: Hearing::default(),
            started: ears.node.clock().now(),
            ears,
            namespace: plan.namespace.clone(),
            bar,
            told: (!quiet && !std::io::stderr().is_terminal()).then_some(Seconds(0.0)),
            newest_state: None,
            newest_safety: None,
            guard: Guard::default(),
            failure: Failure::default(),
            reports: Reports::default(),
            stay: plan.stay,
            host_clock: plan.host_clock,
            marks: Marks::default(),
            happenings: Vec::new(),
            modes: Vec::new(),
        })
    }

    /// Two graphs in one domain and namespace would command one printer.
    ///
    /// # Errors
    /// Names a node that is already there.
    pub async fn refuse_second_graph(&mut self) -> anyhow::Result<()> {
        let mut ticks = self.ears.node.timer(Seconds(LOOK_S));
        while self.elapsed_s() < LISTEN_S {
            _ = ticks.next().await;
            while let Some(beat) = self.ears.heartbeats.try_recv() {
                let name = beat.message.node.rsplit('/').next().unwrap_or_default().to_owned();
                if NODES.contains(&name.as_str()) {
                    let node = beat.message.node;
                    bail!(
                        "{node} already runs in this domain: stop it, or set another ROS_DOMAIN_ID or --namespace"
                    );
                }
            }
        }
        self.started = self.ears.node.clock().now();
        Ok(())
    }

    /// Follows the print to its end.
    pub async fn follow(&mut self, fleet: &mut Fleet) -> Ended {
        let mut ticks = self.ears.node.timer(Seconds(LOOK_S));
        let mut heard = self.ears.node.clock().now();
        let mut suspended = Suspension::listen();
        // What the nodes said of themselves while they came up.
        while self.ears.reports.try_recv().is_some() {}
        loop {
            let now = tokio::select! {
                now = ticks.next() => now,
                () = self.ears.node.shutdown() => return self.leave(fleet, &mut ticks).await,
                () = suspended.asked() => {
                    self.bar.suspend(|| output::note("a print cannot be suspended: it goes on; Ctrl-C ends it"));
                    continue;
                }
            };
            self.tend(fleet, now);
            let hears = self.rejoin_if_deaf();
            self.hear();
            self.replace_hung(fleet);
            if !hears || fleet.has_lost("printer_sim") {
                return self.finish(Ended::Lost);
            }
            if self.listen() {
                heard = now;
            }
            self.take_news(fleet);
            self.show();
            self.tell_progress(now);
            let lost = || ((now - heard).0 > LOST_S).then_some(Ended::Lost);
            match self.fate().or_else(lost) {
                Some(ended) if !self.stay || ended == Ended::Lost => {
                    return self.last_words(ended, fleet, &mut ticks).await;
                }
                _ => {}
            }
        }
    }

    /// Looks after every process.
    pub(super) fn tend(&mut self, fleet: &mut Fleet, now: Seconds) {
        for happening in fleet.tend(now) {
            if let Some(name) = happening.ended() {
                self.hearing.forget(name);
                self.reports.ended(name);
            }
            // One of many tries is no news.
            if !matches!(happening, Happening::EndedAgain { .. }) {
                self.tell(happening);
            }
        }
    }

    /// Ends the nodes in order.
    pub async fn stop(&mut self, fleet: &mut Fleet) {
        ending::end(fleet, &self.ears.node).await;
    }

    /// Wall time since the processes were started `[s]`.
    #[must_use]
    pub fn elapsed_s(&self) -> f64 {
        (self.ears.node.clock().now() - self.started).0
    }

    fn tell(&mut self, happening: Happening) {
        self.bar.suspend(|| output::note(&text(&happening)));
        self.happenings.push(happening);
    }

    /// Joins anew where nothing is heard any more; whether that is possible.
    fn rejoin_if_deaf(&mut self) -> bool {
        if self.ears.are_deaf() {
            self.bar.suspend(|| output::note("fdm hears nothing any more: it joins the graph anew"));
            return Ears::join(&self.namespace).map(|ears| self.ears = ears).is_ok();
        }
        true
    }

    /// Takes the heartbeats that came in, and looks who is missing.
    fn hear(&mut self) {
        let now = self.ears.node.clock().now();
        let mut happenings = Vec::new();
        while let Some(beat) = self.ears.heartbeats.try_recv() {
            let name = beat.message.node.rsplit('/').next().unwrap_or_default();
            happenings.extend(self.hearing.beat(beat.received, name, beat.message.session_id));
        }
        happenings.extend(self.hearing.look(now));
        for happening in happenings {
            self.tell(happening);
        }
    }

    /// Ends by force who has hung for long.
    fn replace_hung(&mut self, fleet: &Fleet) {
        for name in self.hearing.hung(self.ears.node.clock().now()) {
            if fleet.end(name, Signal::KILL) {
                self.tell(Happening::Hung { name });
            }
        }
    }

    /// Takes everything that came in; whether the printer was heard.
    fn listen(&mut self) -> bool {
        let mut guarded = false;
        while let Some(safety) = self.ears.safety.try_recv() {
            self.note_mode(&safety.message);
            self.newest_safety = Some(safety.message);
            guarded = true;
        }
        while let Some(truth) = self.ears.truth.try_recv() {
            self.mark(&truth.message);
        }
        let newest = self.ears.state.drain_newest();
        let heard = newest.is_some();
        if let Some(state) = newest {
            self.newest_state = Some(state.message);
        }
        self.look_for_guard(guarded);
        let failed = self.newest_state.as_ref().is_some_and(|state| state.phase == JobPhase::Failed as u8);
        let now = self.ears.node.clock().now();
        self.failure.look(now, failed, self.newest_safety.as_ref(), self.guard.past.as_deref());
        heard
    }

    fn note_mode(&mut self, safety: &SafetyState) {
        let told = |before: &SafetyState| before.mode == safety.mode && before.cause == safety.cause;
        if self.newest_safety.as_ref().is_some_and(told) {
            return;
        }
        let why = if safety.cause.is_empty() { String::new() } else { format!(": {}", safety.cause) };
        let line = format!("{}{why}", mode_name(safety.mode));
        if safety.mode >= SafetyState::MODE_DEGRADED || !self.modes.is_empty() {
            // With a latched stop the job is given up; nobody could acknowledge to a graph that ends with it.
            let ends = safety.mode >= SafetyState::MODE_SAFE_OFF && !self.stay;
            let asked = if ends { at_the_end(&safety.what_to_do) } else { todo(&safety.what_to_do) };
            let then = if asked.is_empty() { String::new() } else { format!(". {asked}") };
            let shown = format!("supervisor at {:.1} s: {line}{then}", self.marks.last_s);
            self.bar.suspend(|| output::note(&shown));
        }
        self.modes.push((self.marks.last_s, line));
    }

    fn mark(&mut self, truth: &SimTruth) {
        let Some(stamp_s) = truth.header.stamp.seconds() else { return };
        let integrals = Integrals {
            deposit_s: truth.deposit_s,
            wanted_m: truth.deposit_wanted_m,
            delivered_m: truth.deposit_delivered_m,
            width_error_sq_s: truth.width_error_sq_s,
            quality_s: truth.quality_s,
        };
        self.marks.last = integrals;
        let begin_s = *self.marks.begin_s.get_or_insert(if self.host_clock { stamp_s } else { 0.0 });
        self.marks.last_s = stamp_s - begin_s;
        if truth.fault_set_in && stamp_s >= truth.first_onset_s + SETTLE_S {
            self.marks.settled.get_or_insert(integrals);
        }
    }
}
