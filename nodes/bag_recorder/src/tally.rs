//! Counts that the threads of the recorder share.

use crate::metadata::RunCounts;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Counts of one topic in this run.
#[derive(Debug, Default)]
pub struct TopicTally {
    /// Messages received.
    pub received: Count,
    /// Messages handed to the system: they survive the end of this process.
    pub written: Count,
    /// Messages dropped because the queue was full.
    pub dropped: Count,
    /// Messages that did not arrive: gaps in the publishers' numbers.
    pub missed: Count,
}

/// A counter.
#[derive(Debug, Default)]
pub struct Count(AtomicU64);

impl Count {
    /// Counts on.
    pub fn add(&self, amount: u64) {
        self.0.fetch_add(amount, Ordering::Relaxed);
    }

    /// The count.
    pub fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Counts of a run.
#[derive(Debug, Default)]
pub struct Tally {
    /// By topic, as the recorder numbers them.
    pub topics: Vec<TopicTally>,
    /// Messages whose log time was raised to keep the order.
    pub raised: Count,
    /// Syncs of the file that failed.
    pub sync_failed: Count,
    /// Files of earlier runs made whole.
    pub recovered: Count,
    /// Files that could not be read, or not be finished.
    pub unreadable: Count,
    /// Messages that came while nothing was written.
    pub passed_over: Count,
    /// Files dropped for room.
    pub forgotten: Count,
    /// Files written anew in compressed chunks.
    pub compacted: Count,
    /// Files that must not be dropped.
    pub kept: Count,
    /// Nothing is written until somebody asks for it.
    pub paused: AtomicBool,
    /// The disk is nearly full, and nothing may be dropped.
    pub full: AtomicBool,
    /// Bytes of the file being written that are on disk: what a loss of power leaves.
    pub synced_bytes: AtomicU64,
    /// What the run has counted that is described, where this is none.
    pub earlier: RunCounts,
}

impl Tally {
    /// Zeros for a number of topics.
    pub fn new(topics: usize) -> Self {
        Self { topics: std::iter::repeat_with(TopicTally::default).take(topics).collect(), ..Self::default() }
    }

    /// For a bag that a run has written before: what it counted stands.
    pub fn after(earlier: RunCounts) -> Self {
        Self { earlier, ..Self::default() }
    }

    /// Messages dropped.
    pub fn dropped(&self) -> u64 {
        self.topics.iter().map(|topic| topic.dropped.get()).sum()
    }

    /// Messages that did not arrive.
    pub fn missed(&self) -> u64 {
        self.topics.iter().map(|topic| topic.missed.get()).sum()
    }

    /// Messages written.
    pub fn written(&self) -> u64 {
        self.topics.iter().map(|topic| topic.written.get()).sum()
    }

    /// The numbers for `counts.json`.
    pub fn run(&self) -> RunCounts {
        let received: u64 = self.topics.iter().map(|topic| topic.received.get()).sum();
        RunCounts {
            received: received + self.earlier.received,
            dropped: self.dropped() + self.earlier.dropped,
            missed: self.missed() + self.earlier.missed,
            raised: self.raised.get() + self.earlier.raised,
        }
    }
}
