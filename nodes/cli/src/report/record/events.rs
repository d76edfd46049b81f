//! Decisions and changes, equal ones as one line.

use super::super::decode::short;
use fdm_loop_msgs::PrintEvent;
use safety_supervisor::Cause;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Different lines that are kept; a hostile bag may hold millions.
const LINES_MAX: usize = 500;
/// Times that are kept of each line.
const TIMES_MAX: usize = 20;
/// Longest text of a field.
const TEXT_MAX: usize = 200;
/// Longest reason: cause, number and what to do.
const WHY_MAX: usize = 400;

/// How much an event matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Severity {
    Info,
    Warn,
    Error,
}

impl Severity {
    /// An unknown value is taken for the worst.
    fn of(value: u8) -> Self {
        match value {
            PrintEvent::SEVERITY_INFO => Self::Info,
            PrintEvent::SEVERITY_WARN => Self::Warn,
            _ => Self::Error,
        }
    }

    /// Name for people.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Info => "info",
            Self::Warn => "warning",
            Self::Error => "error",
        }
    }
}

/// Who decided what, why.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Text {
    pub(crate) who: String,
    pub(crate) what: String,
    pub(crate) why: String,
    pub(crate) before: String,
    pub(crate) after: String,
}

/// One line of the table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Line {
    pub(crate) severity: Severity,
    pub(crate) text: Text,
    /// First ones.
    pub(crate) times_s: Vec<f64>,
    pub(crate) last_s: f64,
    pub(crate) count: u64,
}

/// All events.
#[derive(Debug, Default)]
pub(crate) struct Events {
    lines: Vec<Line>,
    index: BTreeMap<Text, usize>,
    /// Events by severity: info, warning, error.
    pub(crate) counts: [u64; 3],
    /// The same without those behind the end of the file.
    pub(crate) before_the_end: [u64; 3],
    /// Events for which there was no line left.
    pub(crate) beyond: u64,
}

/// A cause of the supervisor behind its code: an event carries the words alone.
pub(crate) fn coded(why: &str) -> Cow<'_, str> {
    match Cause::ALL.iter().find(|cause| cause.text() == why) {
        Some(cause) => Cow::Owned(format!("{}: {why}", cause.id())),
        None => Cow::Borrowed(why),
    }
}

impl Events {
    /// Takes an event in.
    pub(crate) fn take(&mut self, at: f64, event: &PrintEvent) {
        let severity = Severity::of(event.severity);
        self.counts[severity as usize] += 1;
        let cut = |text: &str| short(text, TEXT_MAX);
        let text = Text {
            who: cut(&event.who),
            what: cut(&event.what),
            why: short(&coded(&event.why), WHY_MAX),
            before: cut(&event.before),
            after: cut(&event.after),
        };
        if let Some(line) = self.index.get(&text).and_then(|index| self.lines.get_mut(*index)) {
            line.count += 1;
            line.last_s = line.last_s.max(at);
            line.severity = line.severity.max(severity);
            if line.times_s.len() < TIMES_MAX {
                line.times_s.push(at);
            }
        } else if self.lines.len() < LINES_MAX {
            self.index.insert(text.clone(), self.lines.len());
            self.lines.push(Line { severity, text, times_s: vec![at], last_s: at, count: 1 });
        } else {
            self.beyond += 1;
        }
    }

    /// Lines in the order of their first time.
    pub(crate) fn lines(&self) -> Vec<&Line> {
        let mut lines: Vec<&Line> = self.lines.iter().collect();
        lines.sort_by(|a, b| first(a).total_cmp(&first(b)));
        lines
    }

    /// The worst ones, the first of them first.
    pub(crate) fn worst(&self, count: usize) -> Vec<&Line> {
        let mut lines = self.lines();
        lines.retain(|line| line.severity > Severity::Info);
        lines.sort_by_key(|line| std::cmp::Reverse(line.severity));
        lines.truncate(count);
        lines
    }

    /// The worst severity.
    pub(crate) fn severity(&self) -> Option<Severity> {
        self.lines.iter().map(|line| line.severity).max()
    }
}

fn first(line: &Line) -> f64 {
    line.times_s.first().copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::command::Mode;
    use models::units::Seconds;
    use safety_supervisor::{Decision, Evidence, What, convert};

    /// What to do stands at the end: a reason that is cut says nothing of it.
    #[test]
    fn no_reason_of_the_supervisor_is_cut() {
        let why = "taken over from before the supervisor was started again";
        for cause in Cause::ALL.iter().copied() {
            let told = Some((cause, Evidence::of(cause, -123_456.789, Some(-123_456.789))));
            let (before, after) = (Mode::Act, Mode::SafeOff);
            let decision = Decision { what: What::Remembered, why, cause: told, before, after };
            let event = convert::event(Seconds(1.0), "/printer/safety_supervisor", &decision);
            let mut events = Events::default();
            events.take(0.0, &event);
            assert_eq!(events.lines()[0].text.why, event.why);
        }
    }
}
