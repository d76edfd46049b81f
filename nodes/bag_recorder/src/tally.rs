//! Counts that the threads of the recorder share.

use bag_recorder::metadata::RunCounts;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts of one topic in this run.
#[derive(Debug, Default)]
pub(crate) struct TopicTally {
    /// Messages received.
    pub(crate) received: Count,
    /// Messages handed to the system: they survive the end of this process.
    pub(crate) written: Count,
    /// Messages dropped because the queue was full.
    pub(crate) dropped: Count,
    /// Messages that did not arrive: gaps in the publishers' numbers.
    pub(crate) missed: Count,
}

/// A counter.
#[derive(Debug, Default)]
pub(crate) struct Count(AtomicU64);

impl Count {
    /// Counts on.
    pub(crate) fn add(&self, amount: u64) {
        self.0.fetch_add(amount, Ordering::Relaxed);
    }

    /// The count.
    pub(crate) fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Counts of a run.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    /// By topic, as the recorder numbers them.
    pub(crate) topics: Vec<TopicTally>,
    /// Messages whose log time was raised to keep the order.
    pub(crate) raised: Count,
    /// Syncs of the file that failed.
    pub(crate) sync_failed: Count,
    /// Files of earlier runs made whole.
    pub(crate) recovered: Count,
    /// Files of earlier runs that could not be read.
    pub(crate) unreadable: Count,
}

impl Tally {
    /// Zeros for a number of topics.
    pub(crate) fn new(topics: usize) -> Self {
        Self { topics: std::iter::repeat_with(TopicTally::default).take(topics).collect(), ..Self::default() }
    }

    /// Messages dropped.
    pub(crate) fn dropped(&self) -> u64 {
        self.topics.iter().map(|topic| topic.dropped.get()).sum()
    }

    /// Messages that did not arrive.
    pub(crate) fn missed(&self) -> u64 {
        self.topics.iter().map(|topic| topic.missed.get()).sum()
    }

    /// Messages written.
    pub(crate) fn written(&self) -> u64 {
        self.topics.iter().map(|topic| topic.written.get()).sum()
    }

    /// The numbers for `counts.json`.
    pub(crate) fn run(&self) -> RunCounts {
        let received = self.topics.iter().map(|topic| topic.received.get()).sum();
        RunCounts { received, dropped: self.dropped(), missed: self.missed(), raised: self.raised.get() }
    }
}
