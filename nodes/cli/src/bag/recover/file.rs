//! What is told of one file.

use bag_recorder::error::RecorderError;
use bag_recorder::folder::Folder;
use serde::Serialize;
use std::path::PathBuf;

/// What became of a file.
#[derive(Debug, Default, Serialize)]
pub(super) struct File {
    pub(super) name: String,
    pub(super) messages: Option<u64>,
    /// `None` where the file does not say how many it had.
    pub(super) lost_messages: Option<u64>,
    pub(super) lost_bytes: u64,
    /// Places before the file's end that could not be read.
    pub(super) damages: u64,
    /// `recovered`, `compacted`, `sound`, `unreadable`, `foreign`: mending would lose something of it, or `unwritten`: what
    /// was to take its place could not be written.
    pub(super) outcome: &'static str,
    pub(super) why: String,
}

impl File {
    /// Whether it is whole now.
    pub(super) fn is_mended(&self) -> bool {
        !["unreadable", "foreign", "unwritten"].contains(&self.outcome)
    }

    /// Beside what the bag's description says that it had: a file that was cut off says nothing of it itself.
    pub(super) fn beside(mut self, stated: Option<u64>) -> Self {
        let (Some(stated), Some(messages)) = (stated, self.messages) else { return self };
        let lost = stated.saturating_sub(messages);
        if lost > self.lost_messages.unwrap_or(0) {
            self.lost_messages = Some(lost);
            let gap = if self.why.is_empty() { "" } else { "; " };
            self.why += &format!("{gap}the bag's description told of {stated} messages: {lost} are lost");
        }
        self
    }
}

/// A file that is as it was: it cannot be read, or the disk refused what was to take its place.
pub(super) fn failed_of(error: &RecorderError, folder: &Folder, sources: &[PathBuf]) -> File {
    let mut why = error.in_words();
    if let RecorderError::Foreign { .. } = error {
        return File { outcome: "foreign", why: why + "; it is as it was", ..File::default() };
    }
    if error.is_of_source() {
        return File { outcome: "unreadable", why, ..File::default() };
    }
    if error.is_full_disk() {
        let needed =
            sources.iter().find_map(|path| std::fs::metadata(path).ok()).map_or(0, |found| found.len());
        let mib = |bytes: u64| bytes.div_ceil(1 << 20);
        let free =
            folder.free_bytes().map_or_else(|_| String::new(), |free| format!(", {} are free", free >> 20));
        why += &format!(": up to {} MiB are needed{free}", mib(needed));
    }
    File { outcome: "unwritten", why: why + "; the original is as it was", ..File::default() }
}
