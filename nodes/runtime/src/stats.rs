//! What a node counts of one of its topics, and the watchdog over the age of its newest message.

use crate::diagnostics::pair;
use fdm_loop_msgs::KeyValue;
use models::units::Seconds;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Counters of one end of a topic.
#[derive(Debug)]
pub(crate) struct TopicStats {
    name: String,
    publishes: bool,
    passed: AtomicU64,
    lost: AtomicU64,
    newest: Mutex<Newest>,
    was_late: AtomicBool,
}

/// Age of the newest message and how old it may get.
#[derive(Debug, Default, Clone, Copy)]
struct Newest {
    received: Option<Seconds>,
    oldest: Option<Seconds>,
    /// Not known where a simulated clock had no reading yet.
    watched_from: Option<Seconds>,
}

impl TopicStats {
    /// Counters of a publisher.
    pub(crate) fn publisher(name: &str) -> Self {
        Self::new(name, true)
    }

    /// Counters of a subscriber.
    pub(crate) fn subscriber(name: &str) -> Self {
        Self::new(name, false)
    }

    fn new(name: &str, publishes: bool) -> Self {
        Self {
            name: name.to_owned(),
            publishes,
            passed: AtomicU64::new(0),
            lost: AtomicU64::new(0),
            newest: Mutex::default(),
            was_late: AtomicBool::new(false),
        }
    }

    /// A message was sent.
    pub(crate) fn sent(&self) {
        self.passed.fetch_add(1, Ordering::Relaxed);
    }

    /// A message was received.
    pub(crate) fn received(&self, at: Seconds) {
        self.passed.fetch_add(1, Ordering::Relaxed);
        self.newest.lock().unwrap_or_else(PoisonError::into_inner).received = Some(at);
    }

    /// A message was dropped by the sender, or could not be decoded by the receiver.
    pub(crate) fn lose(&self) {
        self.lost.fetch_add(1, Ordering::Relaxed);
    }

    /// Messages sent or received.
    pub(crate) fn passed_count(&self) -> u64 {
        self.passed.load(Ordering::Relaxed)
    }

    /// Messages dropped or not decodable.
    pub(crate) fn lost_count(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }

    /// Demands a message at least every `oldest` from `now` on.
    pub(crate) fn watch(&self, oldest: Seconds, now: Seconds) {
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        newest.oldest = Some(oldest);
        newest.watched_from = (now.0 > 0.0).then_some(now);
    }

    /// Age of the newest message.
    pub(crate) fn age(&self, now: Seconds) -> Option<Seconds> {
        self.newest().received.map(|received| now - received)
    }

    /// Says what is late, where something is.
    pub(crate) fn late(&self, now: Seconds) -> Option<String> {
        let mut newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let limit = newest.oldest?;
        // A node that is started again late in a print has not listened since the print's start.
        if now.0 > 0.0 {
            newest.watched_from.get_or_insert(now);
        }
        let age = now - newest.received.or(newest.watched_from)?;
        (age > limit).then(|| format!("no message on {} for {:.2} s (limit {} s)", self.name, age.0, limit.0))
    }

    /// Whether lateness changed since the last call.
    pub(crate) fn lateness_changed(&self, now: Seconds) -> bool {
        let late = self.late(now).is_some();
        self.was_late.swap(late, Ordering::Relaxed) != late
    }

    /// Counters and age for `/diagnostics`.
    pub(crate) fn values(&self, now: Seconds) -> Vec<KeyValue> {
        let name = &self.name;
        if self.publishes {
            return vec![
                pair(format!("{name} sent"), self.passed_count()),
                pair(format!("{name} dropped"), self.lost_count()),
            ];
        }
        let mut values = vec![
            pair(format!("{name} received"), self.passed_count()),
            pair(format!("{name} undecodable"), self.lost_count()),
        ];
        if let Some(age) = self.age(now) {
            values.push(pair(format!("{name} age_s"), format!("{:.3}", age.0)));
        }
        values
    }

    fn newest(&self) -> Newest {
        *self.newest.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// S7: silence is late from the moment it is watched, also where no message ever came.
    #[test]
    fn silence_is_late_with_and_without_a_first_message() {
        let stats = TopicStats::subscriber("/printer/state");
        assert_eq!(stats.late(Seconds(100.0)), None);
        stats.watch(Seconds(0.3), Seconds(100.0));
        assert_eq!(stats.late(Seconds(100.2)), None);
        assert!(stats.late(Seconds(100.4)).is_some());
        stats.received(Seconds(100.5));
        assert_eq!(stats.late(Seconds(100.7)), None);
        let text = stats.late(Seconds(101.0)).unwrap();
        assert_eq!(text, "no message on /printer/state for 0.50 s (limit 0.3 s)");
    }

    /// The clock of a node that is started again under `use_sim_time` stands at zero until its first reading.
    #[test]
    fn silence_counts_from_the_start_of_the_node_not_of_the_print() {
        let stats = TopicStats::subscriber("/printer/state");
        stats.watch(Seconds(0.3), Seconds(0.0));
        assert_eq!(stats.late(Seconds(0.0)), None);
        assert_eq!(stats.late(Seconds(193.0)), None, "the first reading");
        let text = stats.late(Seconds(193.5)).unwrap();
        assert_eq!(text, "no message on /printer/state for 0.50 s (limit 0.3 s)");
    }

    #[test]
    fn a_change_is_told_once() {
        let stats = TopicStats::subscriber("x");
        stats.watch(Seconds(1.0), Seconds(0.0));
        assert!(!stats.lateness_changed(Seconds(0.1)));
        assert!(!stats.lateness_changed(Seconds(0.5)));
        assert!(stats.lateness_changed(Seconds(1.5)));
        assert!(!stats.lateness_changed(Seconds(2.0)));
    }
}
