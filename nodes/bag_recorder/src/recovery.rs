//! Earlier files of a bag: what finished ones hold, and finished ones made out of what a kill left.

use crate::contents::{Channel, FileContents};
use crate::error::RecorderError;
use crate::file::{BagFile, Form, QOS_KEY};
use crate::folder::Folder;
use crate::tally::Tally;
use crate::walk::Walked;
use mcap::McapError;
use runtime::input;
use std::collections::BTreeMap;
use std::io::Read;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::sync::atomic::AtomicBool;

mod copy;
mod summary;

pub use copy::look;
use copy::{Copied, copy_records};

/// What a finished file holds.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finished {
    /// Channels and counts.
    pub contents: FileContents,
    /// Its messages lie in chunks with an index.
    pub indexed: bool,
}

/// Reads what a finished file holds from its summary.
pub fn read_finished(folder: &Folder, number: u32) -> Result<Finished, RecorderError> {
    let name = folder.layout().finished(number);
    let path = folder.path(&name);
    let summary = summary::read(&path).map_err(RecorderError::mcap("read", &path))?;
    let mut contents = FileContents { number, name, ..FileContents::default() };
    let Some(stats) = summary.stats else {
        return Err(RecorderError::mcap("read", &path)(McapError::UnexpectedEof));
    };
    contents.span_ns =
        (stats.message_count > 0).then_some((stats.message_start_time, stats.message_end_time));
    for (id, count) in &stats.channel_message_counts {
        if let Some(channel) = summary.channels.get(id) {
            let type_name = channel.schema.as_ref().map(|schema| schema.name.clone());
            let key = channel_of(&channel.topic, type_name.unwrap_or_default(), &channel.metadata);
            *contents.messages.entry(key).or_insert(0) += count;
        }
    }
    let indexed = !summary.chunk_indexes.is_empty() || stats.message_count == 0;
    Ok(Finished { contents, indexed })
}

/// The key of a channel.
fn channel_of(topic: &str, type_name: String, metadata: &BTreeMap<String, String>) -> Channel {
    let offered_qos = metadata.get(QOS_KEY).cloned().unwrap_or_default();
    Channel { topic: topic.to_owned(), type_name, offered_qos }
}

/// Copies the whole records of each leftover into a finished file. `stop` ends it early: the rest waits for the next
/// start. What cannot be read at all is left as it is, and told.
pub fn recover_all(folder: &Folder, leftover: &[u32], tally: &Tally, stop: &AtomicBool) {
    for number in leftover {
        match recover(folder, *number, stop) {
            Ok(Some(Recovered { messages, walked })) => {
                tally.recovered.add(1);
                let name = folder.layout().finished(*number);
                tracing::warn!("{name}: recovered {messages} messages after a kill");
                if let Some(damage) = walked.damage_in_words() {
                    tracing::warn!("{name} {damage}");
                }
            }
            Ok(None) => return,
            Err(error) => {
                tally.unreadable.add(1);
                let cause = std::error::Error::source(&error).map(ToString::to_string).unwrap_or_default();
                tracing::error!("{error}: {cause}");
            }
        }
    }
}

/// A finished file that was made, and what was found in the one that it was made of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recovered {
    /// Messages in the new file.
    pub messages: u64,
    /// What the old one was like.
    pub walked: Walked,
}

/// Makes a finished file out of what a kill left; `None` where it was stopped. Where that was damaged or changed before its end, it
/// is kept beside, with the ending `.torn`.
///
/// # Errors
/// A file that cannot be read at all, or a disk that refuses; the file is then where it was.
pub fn recover(folder: &Folder, number: u32, stop: &AtomicBool) -> Result<Option<Recovered>, RecorderError> {
    let active = folder.layout().active(number);
    let recovered = finished_from(folder, number, &folder.path(&active), Walked::is_damaged, stop)?;
    if recovered.is_some() {
        folder.remove(&active)?;
    }
    Ok(recovered)
}

/// As [`recover`] for a finished file that was cut off or damaged since: it is kept beside, with the ending `.torn`, as more
/// of it may be read by other means.
///
/// # Errors
/// As [`recover`].
pub fn salvage(folder: &Folder, number: u32, stop: &AtomicBool) -> Result<Option<Recovered>, RecorderError> {
    let finished = folder.path(&folder.layout().finished(number));
    let mut head = [0; mcap::MAGIC.len()];
    let begun = input::open(&finished).and_then(|mut file| file.read_exact(&mut head));
    begun.map_err(RecorderError::file("read", &finished))?;
    if head != mcap::MAGIC {
        return Err(RecorderError::mcap("read", &finished)(McapError::BadMagic));
    }
    finished_from(folder, number, &finished, |_| true, stop)
}

/// Copies the whole records of `source` into a finished file; `None` where it was stopped. Where `is_kept`, the source has
/// its second name before the new file has its own: whenever this ends, neither is lost.
fn finished_from(
    folder: &Folder,
    number: u32,
    source: &Path,
    is_kept: impl Fn(&Walked) -> bool,
    stop: &AtomicBool,
) -> Result<Option<Recovered>, RecorderError> {
    let half_made = folder.layout().recovering(number);
    let target = folder.path(&half_made);
    let mut copy = BagFile::create(&target, Form::Indexed, number, folder.layout().finished(number))?;
    let copied = copy_records(source, &mut copy, stop).and_then(|copied| match copied {
        Copied::All(walked) if is_kept(&walked) => {
            keep(source, &folder.path(&format!("{}.torn", folder.layout().finished(number))))?;
            Ok(Copied::All(walked))
        }
        other => Ok(other),
    });
    match copied {
        Ok(Copied::All(walked)) => {
            let contents = finish(folder, copy, &half_made)?;
            let messages = contents.total();
            folder.add(contents)?;
            Ok(Some(Recovered { messages, walked }))
        }
        stopped => {
            drop(copy);
            folder.remove(&half_made)?;
            stopped.map(|_| None)
        }
    }
}

/// Ends a copy; where the disk refuses, nothing half-made takes the room that is left.
fn finish(folder: &Folder, copy: BagFile, half_made: &str) -> Result<FileContents, RecorderError> {
    // What it failed of is told; that the rest could not be removed either helps nobody.
    copy.finish().inspect_err(|_| _ = folder.remove(half_made))
}

/// Gives a damaged file a second name. What was kept from an earlier damage is not given up for this one.
fn keep(source: &Path, torn: &Path) -> Result<(), RecorderError> {
    let failed = |error| RecorderError::file("keep", torn)(error);
    let file = |path: &Path| std::fs::metadata(path).map(|found| (found.dev(), found.ino()));
    if torn.exists() {
        // A kill came between the second name and the end of a recovery.
        let same = file(torn).map_err(failed)? == file(source).map_err(failed)?;
        return if same { Ok(()) } else { Err(failed(std::io::ErrorKind::AlreadyExists.into())) };
    }
    // Not every disk knows second names.
    std::fs::hard_link(source, torn).or_else(|_| std::fs::copy(source, torn).map(drop)).map_err(failed)
}

/// Writes a finished file anew in compressed chunks with an index; false where it was stopped. The plain one stands until
/// the other is whole and on disk.
pub fn compact(folder: &Folder, number: u32, stop: &AtomicBool) -> Result<bool, RecorderError> {
    let layout = folder.layout();
    let source = folder.path(&layout.finished(number));
    let before = read_finished(folder, number)?.contents.total();
    let half_made = layout.recovering(number);
    let target = folder.path(&half_made);
    let mut copy = BagFile::create(&target, Form::Indexed, number, layout.finished(number))?;
    let copied = copy_records(&source, &mut copy, stop);
    let whole = matches!(&copied, Ok(Copied::All(walked)) if walked.is_sound());
    if !(whole && copy.contents().total() == before) {
        drop(copy);
        folder.remove(&half_made)?;
        return match copied? {
            Copied::Stopped => Ok(false),
            Copied::All(_) => Err(RecorderError::Damaged(source)),
        };
    }
    let contents = finish(folder, copy, &half_made)?;
    folder.add(contents)?;
    Ok(true)
}

#[cfg(test)]
mod tests;
