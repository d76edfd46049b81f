//! What a person has to know beside the supervisor's modes: whether there is one, who was taken out of its work, what the
//! recorder misses, which faults were injected.

use super::super::fleet::{Fleet, Happening};
use super::super::reports::{News, PRINTER};
use super::super::words::text;
use super::{Ended, Watch, output};
use crate::operate::stop;
use fdm_loop_msgs::PrintEvent;
use rustix::process::Signal;

/// What `events` says of a fault that somebody has injected.
const INJECTED: &str = "fault_injected";

impl Watch {
    /// Takes in what nodes report and what happened.
    pub(super) fn take_news(&mut self, fleet: &Fleet) {
        while let Some(event) = self.ears.events.try_recv() {
            if let Some(line) = injected(&event.message) {
                self.bar.suspend(|| output::note(&line));
            }
            if stop::is_past_the_supervisor(&event.message) {
                self.guard.past = Some(event.message.why);
            }
        }
        while let Some(report) = self.ears.reports.try_recv() {
            for status in &report.message.status {
                for news in self.reports.take(report.received, &self.namespace, status) {
                    self.bar.suspend(|| output::note(&news.text()));
                    if let News::Finalized { name } = news {
                        fleet.end(name, Signal::TERM);
                    }
                }
            }
        }
    }

    /// Looks whether somebody watches the printer; `came`: the supervisor was heard.
    pub(super) fn look_for_guard(&mut self, came: bool) {
        let stamp_s = self.newest_state.as_ref().and_then(|state| state.header.stamp.seconds());
        let Some(printer_s) = stamp_s else { return };
        if let Some(change) = self.guard.look(self.ears.node.clock().now(), printer_s, came) {
            self.bar.suspend(|| output::note(change.text()));
        }
    }

    /// Why it ended so, as far as anybody said: of a job that was given up what was in force then, of a printer that is gone
    /// what became of it, else what the supervisor says now.
    #[must_use]
    pub fn cause(&self, ended: Ended) -> Option<String> {
        let told = self.newest_safety.as_ref().map(|safety| safety.cause.clone());
        match ended {
            Ended::Failed | Ended::Stopped => self.failure.cause().map(str::to_owned),
            Ended::Lost => {
                let printer = |happening: &&Happening| happening.name() == PRINTER;
                self.happenings.iter().rev().find(printer).map(text)
            }
            Ended::Done | Ended::Interrupted => told.filter(|cause| !cause.is_empty()),
        }
    }

    /// Why the bag is not whole, if it is not.
    #[must_use]
    pub fn gap(&self) -> Option<&str> {
        self.reports.gap()
    }
}

/// A fault that was injected, for people.
fn injected(event: &PrintEvent) -> Option<String> {
    (event.what == INJECTED).then(|| format!("fault injected: {}", event.why))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_events_the_injected_faults_are_told() {
        let event = |what: &str| PrintEvent {
            what: what.to_owned(),
            why: "extruder slip, size 0.09".to_owned(),
            ..PrintEvent::default()
        };
        assert_eq!(injected(&event(INJECTED)).as_deref(), Some("fault injected: extruder slip, size 0.09"));
        assert_eq!(injected(&event("printer")), None);
    }
}
