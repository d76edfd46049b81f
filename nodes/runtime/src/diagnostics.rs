//! Named counters and values of a node and its topics, published on `/diagnostics` at 1 Hz and when the level changes.

use crate::clock::Clock;
use crate::stats::TopicStats;
use fdm_loop_msgs::{DiagnosticArray, DiagnosticStatus, Header, KeyValue};
use std::collections::BTreeMap;
use std::fmt::Display;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// Level of a status, as `diagnostic_msgs/DiagnosticStatus` has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
#[repr(u8)]
pub enum Level {
    /// All is well.
    #[default]
    Ok = 0,
    /// Works with restrictions.
    Warn = 1,
    /// Does not work.
    Error = 2,
    /// Nothing is heard of it.
    Stale = 3,
}

/// The registry; clones share it.
#[derive(Debug, Clone, Default)]
pub struct Diagnostics {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Notify,
}

#[derive(Debug, Default)]
struct State {
    level: Level,
    message: String,
    counters: BTreeMap<String, u64>,
    values: BTreeMap<String, String>,
    /// What restricts the node beside what it reports itself.
    alarms: BTreeMap<&'static str, String>,
    topics: Vec<Arc<TopicStats>>,
}

impl Diagnostics {
    /// Adds one to a counter.
    pub fn count(&self, name: &str) {
        self.add(name, 1);
    }

    /// Adds `amount` to a counter.
    pub fn add(&self, name: &str, amount: u64) {
        let mut state = self.state();
        match state.counters.get_mut(name) {
            Some(counter) => *counter = counter.saturating_add(amount),
            None => _ = state.counters.insert(name.to_owned(), amount),
        }
    }

    /// A counter; 0 where nothing was counted.
    #[must_use]
    pub fn counter(&self, name: &str) -> u64 {
        self.state().counters.get(name).copied().unwrap_or(0)
    }

    /// Sets a value.
    pub fn set(&self, name: &str, value: impl Display) {
        self.state().values.insert(name.to_owned(), value.to_string());
    }

    /// Sets level and message of the node; a change is published at once.
    pub fn report(&self, level: Level, message: &str) {
        let mut state = self.state();
        if state.level != level || state.message != message {
            state.level = level;
            message.clone_into(&mut state.message);
            self.shared.changed.notify_one();
        }
    }

    /// Raises or ends an alarm: a warning beside what the node reports itself. Its first word and its end are published
    /// at once.
    pub(crate) fn alarm(&self, name: &'static str, text: Option<String>) {
        let mut state = self.state();
        let changed = state.alarms.contains_key(name) != text.is_some();
        match text {
            Some(text) => _ = state.alarms.insert(name, text),
            None => _ = state.alarms.remove(name),
        }
        if changed {
            self.shared.changed.notify_one();
        }
    }

    /// Publishes at once.
    pub fn publish_now(&self) {
        self.shared.changed.notify_one();
    }

    /// Waits for a change of level or message.
    pub(crate) async fn changed(&self) {
        self.shared.changed.notified().await;
    }

    /// Takes the statistics of a topic in.
    pub(crate) fn watch(&self, topic: Arc<TopicStats>) {
        self.state().topics.push(topic);
    }

    /// The shell is configured anew: the topics of the former one are gone, and what it reported.
    pub(crate) fn forget_shell(&self) {
        let mut state = self.state();
        // Whoever else holds the statistics still sends or listens.
        state.topics.retain(|topic| Arc::strong_count(topic) > 1);
        state.level = Level::Ok;
        state.message.clear();
    }

    /// Whether a topic became too old, or fresh again, since the last call.
    pub(crate) fn ages_changed(&self, clock: &Clock) -> bool {
        let now = clock.now();
        let state = self.state();
        // Every topic is asked: each one notes what it answered.
        state.topics.iter().filter(|topic| topic.lateness_changed(now)).count() > 0
    }

    /// The message for `/diagnostics`: a status of the node and one of its topics.
    pub(crate) fn array(&self, node: &str, clock: &Clock) -> DiagnosticArray {
        let now = clock.now();
        let state = self.state();
        let mut values: Vec<KeyValue> =
            state.values.iter().map(|(key, value)| pair(key.clone(), value)).collect();
        values.extend(state.counters.iter().map(|(key, value)| pair(key.clone(), value)));
        let mut message = if state.message.is_empty() { "ok".to_owned() } else { state.message.clone() };
        for alarm in state.alarms.values() {
            message = format!("{message}; {alarm}");
        }
        let level = if state.alarms.is_empty() { state.level } else { state.level.max(Level::Warn) };
        let own = status(node.to_owned(), level, message, values);

        let late: Vec<String> = state.topics.iter().filter_map(|topic| topic.late(now)).collect();
        let level = if late.is_empty() { Level::Ok } else { Level::Warn };
        let message = if late.is_empty() { "ok".to_owned() } else { late.join("; ") };
        let values = state.topics.iter().flat_map(|topic| topic.values(now)).collect();
        let topics = status(format!("{node}: topics"), level, message, values);
        DiagnosticArray { header: Header::at(clock.stamp().0), status: vec![own, topics] }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.shared.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A named value as text.
pub(crate) fn pair(key: String, value: impl Display) -> KeyValue {
    KeyValue { key, value: value.to_string() }
}

/// One status.
pub(crate) fn status(name: String, level: Level, message: String, values: Vec<KeyValue>) -> DiagnosticStatus {
    // The printer is the hardware: its namespace tells it from others.
    let hardware_id =
        name.trim_start_matches('/').rsplit_once('/').map_or("", |(printer, _)| printer).to_owned();
    DiagnosticStatus { level: level as u8, name, message, hardware_id, values }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_values_and_level_reach_the_message() {
        let diagnostics = Diagnostics::default();
        diagnostics.count("refused_nan");
        diagnostics.add("refused_nan", 2);
        diagnostics.set("mode", "observe");
        diagnostics.report(Level::Warn, "gate refuses");
        let array = diagnostics.array("/printer/estimator", &Clock::simulated());
        let own = &array.status[0];
        assert_eq!((own.level, own.message.as_str()), (DiagnosticStatus::WARN, "gate refuses"));
        let topics = &array.status[1];
        assert_eq!((own.hardware_id.as_str(), topics.hardware_id.as_str()), ("printer", "printer"));
        assert_eq!(topics.name, "/printer/estimator: topics");
        assert!(own.values.contains(&pair("refused_nan".into(), 3)));
        assert!(own.values.contains(&pair("mode".into(), "observe")));
        assert_eq!(diagnostics.counter("refused_nan"), 3);
    }
}
