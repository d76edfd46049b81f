//! Earlier files of a bag: what finished ones hold, and finished ones made out of what a kill left.

use crate::contents::{Channel, FileContents};
use crate::error::RecorderError;
use crate::file::{BagFile, Form, QOS_KEY, Stamp};
use crate::folder::Folder;
use crate::tally::Tally;
use crate::walk::{Walk, Walked};
use mcap::records::Record;
use mcap::sans_io::{SummaryReadEvent, SummaryReader};
use mcap::{McapError, Summary};
use runtime::input;
use std::collections::BTreeMap;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

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
    let summary = read_summary(&path).map_err(RecorderError::mcap("read", &path))?;
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

/// The summary at the end of a file.
fn read_summary(path: &Path) -> Result<Summary, McapError> {
    let mut file = input::open(path)?;
    let mut reader = SummaryReader::new();
    while let Some(event) = reader.next_event() {
        match event? {
            SummaryReadEvent::ReadRequest(wanted) => {
                let read = file.read(reader.insert(wanted))?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(file.seek(to)?),
        }
    }
    reader.finish().ok_or(McapError::UnexpectedEof)
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

/// Makes a finished file out of what a kill left; `None` where it was stopped. Where that was damaged before its end, it is
/// kept beside, with the ending `.torn`.
///
/// # Errors
/// A file that cannot be read at all, or a disk that refuses.
pub fn recover(folder: &Folder, number: u32, stop: &AtomicBool) -> Result<Option<Recovered>, RecorderError> {
    let active = folder.layout().active(number);
    let recovered = finished_from(folder, number, &folder.path(&active), stop)?;
    match &recovered {
        None => {}
        Some(Recovered { walked, .. }) if walked.damages == 0 => folder.remove(&active)?,
        Some(_) => {
            let (active, torn) = (folder.path(&active), torn(folder, number)?);
            std::fs::rename(&active, torn).map_err(RecorderError::file("rename", &active))?;
        }
    }
    Ok(recovered)
}

/// Goes through every record of a finished file.
///
/// # Errors
/// A file that cannot be read, or is none of a bag.
pub fn check(folder: &Folder, number: u32) -> Result<Walked, RecorderError> {
    let path = folder.path(&folder.layout().finished(number));
    let mut walk = open(&path)?;
    loop {
        let unsound = match walk.next_record().map_err(RecorderError::file("read", &path))? {
            None => return Ok(walk.finish()),
            Some((opcode, fields)) => mcap::parse_record(opcode, fields).is_err(),
        };
        if unsound {
            walk.reject();
        }
    }
}

/// Where a damaged file is kept. What was kept from an earlier damage is not given up for this one.
fn torn(folder: &Folder, number: u32) -> Result<PathBuf, RecorderError> {
    let torn = folder.path(&format!("{}.torn", folder.layout().finished(number)));
    if torn.exists() {
        return Err(RecorderError::file("keep", &torn)(std::io::ErrorKind::AlreadyExists.into()));
    }
    Ok(torn)
}

/// As [`recover`] for a finished file that was cut off or damaged since: it is kept beside, with the ending `.torn`, as more
/// of it may be read by other means.
///
/// # Errors
/// As [`recover`]; the file is then where it was.
pub fn salvage(folder: &Folder, number: u32, stop: &AtomicBool) -> Result<Option<Recovered>, RecorderError> {
    let finished = folder.path(&folder.layout().finished(number));
    let mut head = [0; mcap::MAGIC.len()];
    let begun = input::open(&finished).and_then(|mut file| file.read_exact(&mut head));
    begun.map_err(RecorderError::file("read", &finished))?;
    if head != mcap::MAGIC {
        return Err(RecorderError::mcap("read", &finished)(McapError::BadMagic));
    }
    let torn = torn(folder, number)?;
    std::fs::rename(&finished, &torn).map_err(RecorderError::file("rename", &finished))?;
    let recovered = finished_from(folder, number, &torn, stop);
    if !matches!(recovered, Ok(Some(_))) {
        std::fs::rename(&torn, &finished).map_err(RecorderError::file("rename", &torn))?;
    }
    recovered
}

/// Copies the whole records of `source` into a finished file; `None` where it was stopped.
fn finished_from(
    folder: &Folder,
    number: u32,
    source: &Path,
    stop: &AtomicBool,
) -> Result<Option<Recovered>, RecorderError> {
    let half_made = folder.layout().recovering(number);
    let target = folder.path(&half_made);
    let mut copy = BagFile::create(&target, Form::Indexed, number, folder.layout().finished(number))?;
    match copy_records(source, &mut copy, stop) {
        Ok(Copied::All(walked)) => {
            let contents = copy.finish()?;
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
    let contents = copy.finish()?;
    folder.add(contents)?;
    Ok(true)
}

/// How a copy ended.
enum Copied {
    All(Walked),
    Stopped,
}

/// Schemas and channels by their numbers in the file that is read.
#[derive(Default)]
struct Seen {
    schemas: BTreeMap<u16, (String, String)>,
    channels: BTreeMap<u16, (Channel, String)>,
}

/// Opens a file for a walk through its records.
fn open(path: &Path) -> Result<Walk, RecorderError> {
    let walk = Walk::open(path).map_err(RecorderError::file("read", path))?;
    walk.ok_or(McapError::BadMagic).map_err(RecorderError::mcap("read", path))
}

/// Copies every record that can be read.
fn copy_records(source: &Path, copy: &mut BagFile, stop: &AtomicBool) -> Result<Copied, RecorderError> {
    let mut walk = open(source)?;
    let mut seen = Seen::default();
    loop {
        if stop.load(Ordering::Relaxed) {
            return Ok(Copied::Stopped);
        }
        let taken = match walk.next_record().map_err(RecorderError::file("read", source))? {
            None => return Ok(Copied::All(walk.finish())),
            Some((opcode, fields)) => match mcap::parse_record(opcode, fields) {
                Ok(record) => copy_record(record, &mut seen, copy)?,
                Err(_broken) => false,
            },
        };
        if !taken {
            walk.reject();
        }
    }
}

/// Copies a message or a note, and remembers what messages refer to. The rest of a file is made anew. False for a message
/// of which nothing says what it is.
fn copy_record(record: Record<'_>, seen: &mut Seen, copy: &mut BagFile) -> Result<bool, RecorderError> {
    match record {
        Record::Schema { header, data } => {
            let text = String::from_utf8_lossy(&data).into_owned();
            seen.schemas.insert(header.id, (header.name, text));
        }
        Record::Channel(channel) => {
            let (type_name, schema) = seen.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
            let key = channel_of(&channel.topic, type_name, &channel.metadata);
            seen.channels.insert(channel.id, (key, schema));
        }
        Record::Message { header, data } => {
            let Some((channel, schema)) = seen.channels.get(&header.channel_id) else { return Ok(false) };
            let stamp =
                Stamp { log_ns: header.log_time, publish_ns: header.publish_time, sequence: header.sequence };
            copy.write(channel, schema, stamp, &data)?;
        }
        Record::Metadata(note) => copy.note(&note)?,
        _ => {}
    }
    Ok(true)
}

#[cfg(test)]
mod tests;
