//! What the recorder tells of itself.

use crate::error::RecorderError;
use crate::tally::Tally;
use runtime::{Diagnostics, Level};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// What is told of the counts.
pub(super) struct Report {
    pub(super) names: Vec<String>,
    pub(super) tally: Arc<Tally>,
    pub(super) diagnostics: Diagnostics,
}

impl Report {
    /// To `/diagnostics`.
    pub(super) fn publish(&self) {
        for (name, counts) in self.names.iter().zip(&self.tally.topics) {
            if counts.received.get() > 0 {
                self.diagnostics.set(&format!("{name} written"), counts.written.get());
                self.diagnostics.set(&format!("{name} dropped"), counts.dropped.get());
            }
        }
        let tally = &self.tally;
        self.diagnostics.set("written", tally.written());
        self.diagnostics.set("dropped", tally.dropped());
        self.diagnostics.set("missed", tally.missed());
        self.diagnostics.set("log_time_raised", tally.raised.get());
        self.diagnostics.set("files_recovered", tally.recovered.get());
        self.diagnostics.set("files_unreadable", tally.unreadable.get());
        self.diagnostics.set("sync_failed", tally.sync_failed.get());
        self.diagnostics.set("passed_over", tally.passed_over.get());
        self.diagnostics.set("files_dropped", tally.forgotten.get());
        self.diagnostics.set("files_kept", tally.kept.get());
        self.diagnostics.set("files_compacted", tally.compacted.get());
        let (full, paused) = (tally.full.load(Ordering::Relaxed), tally.paused.load(Ordering::Relaxed));
        let (level, message) = match () {
            () if full => (Level::Error, "the disk is nearly full and nothing may be dropped: not recording"),
            () if tally.sync_failed.get() > 0 => (Level::Error, "the disk failed"),
            () if tally.dropped() > 0 => (Level::Warn, "messages were dropped"),
            () if tally.unreadable.get() > 0 => (Level::Warn, "an earlier file is not readable"),
            () if paused => (Level::Ok, "paused"),
            () if tally.forgotten.get() > 0 => {
                (Level::Warn, "recording; the oldest files are dropped for room")
            }
            () => (Level::Ok, "recording"),
        };
        self.diagnostics.report(level, message);
    }

    /// To `/diagnostics` and the log: why nothing is recorded any more.
    pub(super) fn failed(&self, error: &RecorderError) {
        let words = format!("not recording: {}", error.in_words());
        tracing::error!("{words}");
        self.diagnostics.report(Level::Error, &words);
    }

    /// To the log, at the end.
    pub(super) fn log(&self) {
        for (name, counts) in self.names.iter().zip(&self.tally.topics) {
            let (received, written) = (counts.received.get(), counts.written.get());
            let (dropped, missed) = (counts.dropped.get(), counts.missed.get());
            if received > 0 {
                tracing::debug!(
                    "{name}: {received} received, {written} written, {dropped} dropped, {missed} missed"
                );
            }
        }
        let (written, missed) = (self.tally.written(), self.tally.missed());
        tracing::info!("{written} messages written, {missed} missed");
        if self.tally.dropped() > 0 {
            tracing::warn!("{} messages were dropped", self.tally.dropped());
        }
    }
}
