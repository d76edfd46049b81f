//! Files, channels and counts of a bag.

use std::collections::BTreeMap;

/// A topic as a file holds it. Readers match `metadata.yaml` and file by all three.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Channel {
    /// Name on the graph.
    pub topic: String,
    /// Type as `package/msg/Name`.
    pub type_name: String,
    /// Quality of service as bags write it, see [`crate::offered_qos`].
    pub offered_qos: String,
}

/// What one file holds.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FileContents {
    /// Number of the file in the bag.
    pub number: u32,
    /// Name in the folder.
    pub name: String,
    /// First and last log time `[ns]`; `None` without messages.
    pub span_ns: Option<(u64, u64)>,
    /// Messages of each channel.
    pub messages: BTreeMap<Channel, u64>,
}

impl FileContents {
    /// Takes a message in.
    pub fn add(&mut self, channel: &Channel, log_ns: u64) {
        self.span_ns = Some(match self.span_ns {
            None => (log_ns, log_ns),
            Some((first, last)) => (first.min(log_ns), last.max(log_ns)),
        });
        match self.messages.get_mut(channel) {
            Some(count) => *count += 1,
            None => _ = self.messages.insert(channel.clone(), 1),
        }
    }

    /// Messages of all channels.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.messages.values().sum()
    }

    /// First log time `[ns]` (0 without messages) and length `[ns]`.
    #[must_use]
    pub fn start_and_length_ns(&self) -> (u64, u64) {
        self.span_ns.map_or((0, 0), |(first, last)| (first, last - first))
    }
}

/// What the finished files of a bag hold.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Contents {
    files: BTreeMap<u32, FileContents>,
}

impl Contents {
    /// Takes a finished file in.
    pub fn add(&mut self, file: FileContents) {
        self.files.insert(file.number, file);
    }

    /// A file is no longer there.
    pub fn remove(&mut self, number: u32) {
        self.files.remove(&number);
    }

    /// The files, by number.
    pub fn files(&self) -> impl Iterator<Item = &FileContents> {
        self.files.values()
    }

    /// Messages of each channel in all files.
    #[must_use]
    pub fn messages(&self) -> BTreeMap<&Channel, u64> {
        let mut sums = BTreeMap::new();
        for (channel, count) in self.files.values().flat_map(|file| &file.messages) {
            *sums.entry(channel).or_insert(0) += count;
        }
        sums
    }

    /// Messages in all files.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.files.values().map(FileContents::total).sum()
    }

    /// First log time `[ns]` and length `[ns]` over all files; zeros without messages.
    #[must_use]
    pub fn start_and_length_ns(&self) -> (u64, u64) {
        let spans = || self.files.values().filter_map(|file| file.span_ns);
        let first = spans().map(|(first, _)| first).min().unwrap_or(0);
        let last = spans().map(|(_, last)| last).max().unwrap_or(0);
        (first, last - first)
    }
}
