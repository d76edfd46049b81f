//! What the supervisor decides, in the log as well: a console, the journal and `/rosout` tell why a print stands still
//! where nobody listens to `events`.

use fdm_loop_msgs::PrintEvent;
use models::units::Seconds;
use std::collections::BTreeMap;

/// The same decision is told again after this long `[s]`: a refusal can come with every command.
const AGAIN_S: f64 = 10.0;
/// Lines within that time; decisions that flutter would fill a disk.
const MOST: usize = 20;

/// What was told lately.
#[derive(Debug, Default)]
pub(super) struct Journal {
    /// By what it is, and the modes before and after: the numbers in its words differ each time.
    told: BTreeMap<(String, String, String), Seconds>,
}

impl Journal {
    /// Writes an event to the log, at the level of its severity, unless it was told a moment ago.
    pub(super) fn write(&mut self, now: Seconds, event: &PrintEvent) {
        if !self.is_news(now, event) {
            return;
        }
        let line = line(event);
        match event.severity {
            PrintEvent::SEVERITY_ERROR => tracing::error!("{line}"),
            PrintEvent::SEVERITY_WARN => tracing::warn!("{line}"),
            _ => tracing::info!("{line}"),
        }
    }

    fn is_news(&mut self, now: Seconds, event: &PrintEvent) -> bool {
        // Simulated time may have jumped back.
        self.told.retain(|_, at| (0.0..AGAIN_S).contains(&(now - *at).0));
        let key = (event.what.clone(), event.before.clone(), event.after.clone());
        if self.told.contains_key(&key) || self.told.len() >= MOST {
            return false;
        }
        self.told.insert(key, now);
        true
    }
}

/// What happened, from which mode to which, why, and what to do.
fn line(event: &PrintEvent) -> String {
    let PrintEvent { what, why, before, after, .. } = event;
    if before == after { format!("{what} ({after}): {why}") } else { format!("{before} -> {after}: {why}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(what: &str, after: &str) -> PrintEvent {
        PrintEvent {
            what: what.to_owned(),
            before: "act".to_owned(),
            after: after.to_owned(),
            why: "P13: emergency stop by a person. What to do: look".to_owned(),
            ..PrintEvent::default()
        }
    }

    #[test]
    fn a_line_tells_the_modes_the_cause_and_what_to_do() {
        let why = "P13: emergency stop by a person. What to do: look";
        assert_eq!(line(&event("mode_changed", "estop")), format!("act -> estop: {why}"));
        assert_eq!(line(&event("resume_denied", "act")), format!("resume_denied (act): {why}"));
    }

    #[test]
    fn what_repeats_is_told_every_ten_seconds_and_what_flutters_twenty_times_in_them() {
        let mut journal = Journal::default();
        let refused = event("command_refused_stale", "act");
        let told = (0..250).filter(|step| journal.is_news(Seconds(0.1 * f64::from(*step)), &refused)).count();
        assert_eq!(told, 3, "at 0, 10 and 20 s");
        assert!(journal.is_news(Seconds(24.9), &event("mode_changed", "estop")), "another one");
        assert!(journal.is_news(Seconds(1.0), &refused), "time has jumped back");
        let many =
            (0..100).filter(|number| journal.is_news(Seconds(60.0), &event(&number.to_string(), "act")));
        assert_eq!(many.count(), MOST);
    }
}
