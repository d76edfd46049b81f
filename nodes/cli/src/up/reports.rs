//! What the nodes say of themselves on `/diagnostics`, as far as a person has to know of it: who was taken out of its work,
//! and a recorder that does not record.

use super::recipes::NODES;
use fdm_loop_msgs::DiagnosticStatus;
use models::units::Seconds;
use std::collections::BTreeMap;

/// A node is told as out of its work when it says so for this long `[s]`: at its start it passes through inactive. It reports
/// once a second.
const OUT_S: f64 = 0.9;
/// Who keeps the record.
const RECORDER: &str = "bag_recorder";
/// Who has the job in its memory, and is not replaced.
pub(super) const PRINTER: &str = "printer_sim";
/// Who guards.
const SUPERVISOR: &str = "safety_supervisor";

/// What a person has to know, and `fdm` to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum News {
    /// It was deactivated, or cleaned up.
    Out { name: &'static str, state: String },
    /// It works again.
    In { name: &'static str },
    /// It was shut down: nothing but its process is left.
    Finalized { name: &'static str },
    /// The recorder does not record, or not all.
    Unrecorded(String),
    /// It records again.
    Recorded,
}

impl News {
    /// For people.
    pub(super) fn text(&self) -> String {
        match self {
            Self::Out { name, state } if *name == SUPERVISOR => format!(
                "{name} is {state}, somebody has taken it out of its work: `ros2 lifecycle set` activates it again"
            ),
            Self::Out { name, state } => format!("{name} is {state}, somebody has taken it out of its work"),
            Self::In { name } => format!("{name} is active again"),
            Self::Finalized { name } if *name == PRINTER => {
                format!("{name} was shut down (finalized), by somebody: the print is lost")
            }
            Self::Finalized { name } => {
                format!("{name} was shut down (finalized), by somebody: its process is ended")
            }
            Self::Unrecorded(why) => format!("{RECORDER}: {why}"),
            Self::Recorded => format!("{RECORDER} records again"),
        }
    }
}

/// What was told of nodes so far.
#[derive(Debug, Default)]
pub(super) struct Reports {
    /// Who is not active: its state, since when, and whether it was told.
    out: BTreeMap<&'static str, (String, Seconds, bool)>,
    unrecorded: bool,
    /// Why the bag is not whole, first.
    gap: Option<String>,
}

impl Reports {
    /// Takes a status in that came at `now`. What a witness says of a node is its own view: that one may be at work.
    pub(super) fn take(&mut self, now: Seconds, namespace: &str, status: &DiagnosticStatus) -> Vec<News> {
        let own = status.name.strip_prefix(namespace.trim_end_matches('/'));
        let own = own.and_then(|name| name.strip_prefix('/'));
        let Some(name) = NODES.into_iter().find(|name| Some(*name) == own) else { return Vec::new() };
        if status.values.iter().any(|value| value.key == runtime::WITNESS) {
            return Vec::new();
        }
        let state = status.values.iter().find(|value| value.key == "lifecycle");
        let mut news = Vec::new();
        news.extend(state.and_then(|state| self.state(now, name, &state.value)));
        if name == RECORDER {
            news.extend(self.record(status));
        }
        news
    }

    /// Why the bag is not whole, if it is not.
    pub(super) fn gap(&self) -> Option<&str> {
        self.gap.as_deref()
    }

    /// What was on its way to the disk when the recorder ended is lost.
    pub(super) fn ended(&mut self, name: &str) {
        if name == RECORDER {
            self.gap.get_or_insert_with(|| "the recorder ended while it recorded".to_owned());
        }
    }

    fn state(&mut self, now: Seconds, name: &'static str, state: &str) -> Option<News> {
        match state {
            "active" => self.out.remove(name).and_then(|(_, _, told)| told.then_some(News::In { name })),
            "finalized" => {
                let before = self.out.insert(name, (state.to_owned(), now, false));
                let news = before.is_none_or(|(before, ..)| before != state);
                news.then_some(News::Finalized { name })
            }
            "inactive" | "unconfigured" => {
                let (before, since, told) =
                    self.out.entry(name).or_insert_with(|| (state.to_owned(), now, false));
                state.clone_into(before);
                if (now - *since).0 < OUT_S || std::mem::replace(told, true) {
                    return None;
                }
                Some(News::Out { name, state: state.to_owned() })
            }
            _ => None,
        }
    }

    fn record(&mut self, status: &DiagnosticStatus) -> Option<News> {
        let failed = status.level >= DiagnosticStatus::ERROR;
        if failed || status.message.contains("dropped") {
            self.gap.get_or_insert_with(|| status.message.clone());
        }
        match (failed, std::mem::replace(&mut self.unrecorded, failed)) {
            (true, false) => Some(News::Unrecorded(status.message.clone())),
            (false, true) => Some(News::Recorded),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fdm_loop_msgs::KeyValue;

    fn status(name: &str, state: &str, level: u8, message: &str) -> DiagnosticStatus {
        let values = vec![KeyValue { key: "lifecycle".to_owned(), value: state.to_owned() }];
        DiagnosticStatus {
            level,
            name: name.to_owned(),
            message: message.to_owned(),
            values,
            ..Default::default()
        }
    }

    fn says(reports: &mut Reports, now_s: f64, name: &str, state: &str) -> Vec<News> {
        reports.take(Seconds(now_s), "/printer", &status(name, state, 0, "ok"))
    }

    #[test]
    fn who_is_deactivated_is_told_once_and_again_when_it_works() {
        let (mut reports, name) = (Reports::default(), "/printer/safety_supervisor");
        assert_eq!(says(&mut reports, 1.0, name, "active"), []);
        assert_eq!(says(&mut reports, 2.0, name, "inactive"), [], "at its start it passes through it");
        let out = says(&mut reports, 3.0, name, "inactive");
        assert!(
            matches!(&out[..], [News::Out { name: "safety_supervisor", state }] if state == "inactive"),
            "{out:?}"
        );
        assert_eq!(says(&mut reports, 4.0, name, "inactive"), []);
        assert_eq!(says(&mut reports, 5.0, name, "active"), [News::In { name: "safety_supervisor" }]);
        assert_eq!(says(&mut reports, 6.0, name, "active"), []);
        for other in ["/left/safety_supervisor", "/printer/stranger", "/printer/safety_supervisor: topics"] {
            assert_eq!(says(&mut reports, 9.0, other, "finalized"), [], "{other}");
        }
    }

    #[test]
    fn who_is_finalized_is_ended_once() {
        let (mut reports, name) = (Reports::default(), "/printer/imu");
        assert_eq!(says(&mut reports, 1.0, name, "finalized"), [News::Finalized { name: "imu" }]);
        assert_eq!(says(&mut reports, 2.0, name, "finalized"), []);
        assert_eq!(says(&mut reports, 3.0, name, "active"), [], "its next run: told by its process");
        assert_eq!(says(&mut reports, 4.0, name, "finalized"), [News::Finalized { name: "imu" }]);
    }

    #[test]
    fn a_recorder_that_does_not_record_is_told_and_the_bag_is_not_whole() {
        let mut reports = Reports::default();
        let mut says = |level, message: &str| {
            let told = reports.take(Seconds(1.0), "/", &status("/bag_recorder", "active", level, message));
            (told, reports.gap().map(str::to_owned))
        };
        let full = "the disk is nearly full and nothing may be dropped: not recording";
        assert_eq!(says(DiagnosticStatus::OK, "recording"), (vec![], None));
        let told = says(DiagnosticStatus::ERROR, full);
        assert_eq!(told, (vec![News::Unrecorded(full.to_owned())], Some(full.to_owned())));
        assert_eq!(says(DiagnosticStatus::ERROR, full).0, [], "told once");
        assert_eq!(says(DiagnosticStatus::OK, "recording"), (vec![News::Recorded], Some(full.to_owned())));
        let mut ended = Reports::default();
        ended.ended("imu");
        assert_eq!(ended.gap(), None);
        ended.ended("bag_recorder");
        assert!(ended.gap().is_some());
    }

    /// A supervisor that was stopped itself said so of a recorder that missed nothing.
    #[test]
    fn what_a_witness_says_of_the_recorder_is_no_gap() {
        let mut reports = Reports::default();
        let mut said =
            status("/printer/bag_recorder", "active", DiagnosticStatus::ERROR, "not heard for 5.9 s");
        assert_eq!(reports.take(Seconds(1.0), "/printer", &said).len(), 1);
        let mut reports = Reports::default();
        said.values.push(KeyValue {
            key: runtime::WITNESS.to_owned(),
            value: "/printer/safety_supervisor".to_owned(),
        });
        assert!(reports.take(Seconds(1.0), "/printer", &said).is_empty() && reports.gap().is_none());
    }
}
