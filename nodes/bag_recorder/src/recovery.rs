//! Earlier files of a bag: what finished ones hold, and finished ones made out of what a kill left.

use crate::contents::{Channel, FileContents};
use crate::error::RecorderError;
use crate::file::{BagFile, Form, QOS_KEY, Stamp};
use crate::folder::Folder;
use crate::tally::Tally;
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions, SummaryReadEvent, SummaryReader};
use mcap::{McapError, Summary};
use runtime::input;
use std::collections::BTreeMap;
use std::io::{BufReader, Read, Seek};
use std::path::Path;
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
            Ok(Some(total)) => {
                tally.recovered.add(1);
                tracing::warn!(
                    "{}: recovered {total} messages after a kill",
                    folder.layout().finished(*number)
                );
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

/// Makes a finished file out of what a kill left, and tells its messages; `None` where it was stopped.
///
/// # Errors
/// A file that cannot be read at all, or a disk that refuses.
pub fn recover(folder: &Folder, number: u32, stop: &AtomicBool) -> Result<Option<u64>, RecorderError> {
    let active = folder.layout().active(number);
    let total = finished_from(folder, number, &folder.path(&active), stop)?;
    if total.is_some() {
        folder.remove(&active)?;
    }
    Ok(total)
}

/// The same for a finished file that was cut off or damaged since: it is kept beside, with the ending `.torn`, as what lies
/// behind a damage may be read by other means.
///
/// # Errors
/// As [`recover`]; the file is then where it was.
pub fn salvage(folder: &Folder, number: u32, stop: &AtomicBool) -> Result<Option<u64>, RecorderError> {
    let name = folder.layout().finished(number);
    let (finished, torn) = (folder.path(&name), folder.path(&format!("{name}.torn")));
    let mut head = [0; mcap::MAGIC.len()];
    let begun = input::open(&finished).and_then(|mut file| file.read_exact(&mut head));
    begun.map_err(RecorderError::file("read", &finished))?;
    if head != mcap::MAGIC {
        return Err(RecorderError::mcap("read", &finished)(McapError::BadMagic));
    }
    if torn.exists() {
        // What was kept from an earlier damage is not given up for this one.
        return Err(RecorderError::file("keep", &torn)(std::io::ErrorKind::AlreadyExists.into()));
    }
    std::fs::rename(&finished, &torn).map_err(RecorderError::file("rename", &finished))?;
    let total = finished_from(folder, number, &torn, stop);
    if !matches!(total, Ok(Some(_))) {
        std::fs::rename(&torn, &finished).map_err(RecorderError::file("rename", &torn))?;
    }
    total
}

/// Copies the whole records of `source` into a finished file; `None` where it was stopped.
fn finished_from(
    folder: &Folder,
    number: u32,
    source: &Path,
    stop: &AtomicBool,
) -> Result<Option<u64>, RecorderError> {
    let half_made = folder.layout().recovering(number);
    let target = folder.path(&half_made);
    let mut copy = BagFile::create(&target, Form::Indexed, number, folder.layout().finished(number))?;
    match copy_records(source, &mut copy, stop) {
        Ok(Copied::All) => {
            let contents = copy.finish()?;
            let total = contents.total();
            folder.add(contents)?;
            Ok(Some(total))
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
    let whole = matches!(copied, Ok(Copied::All)) && copy.contents().total() == before;
    if !whole {
        drop(copy);
        folder.remove(&half_made)?;
        return match copied? {
            Copied::Stopped => Ok(false),
            Copied::All => Err(RecorderError::mcap("compact", &source)(McapError::UnexpectedEof)),
        };
    }
    let contents = copy.finish()?;
    folder.add(contents)?;
    Ok(true)
}

/// How a copy ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Copied {
    All,
    Stopped,
}

/// Schemas and channels by their numbers in the file that is read.
#[derive(Default)]
struct Seen {
    schemas: BTreeMap<u16, (String, String)>,
    channels: BTreeMap<u16, (Channel, String)>,
}

/// Copies record by record up to the first that is not whole.
fn copy_records(source: &Path, copy: &mut BagFile, stop: &AtomicBool) -> Result<Copied, RecorderError> {
    let failed = || RecorderError::file("read", source);
    let file = input::open(source).map_err(failed())?;
    let size = usize::try_from(file.metadata().map_err(failed())?.len()).unwrap_or(usize::MAX);
    let mut file = BufReader::new(file);
    let options = LinearReaderOptions::default().with_skip_end_magic(true).with_record_length_limit(size);
    let mut reader = LinearReader::new_with_options(options);
    let mut seen = Seen::default();
    while let Some(event) = reader.next_event() {
        if stop.load(Ordering::Relaxed) {
            return Ok(Copied::Stopped);
        }
        match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let read = file.read(reader.insert(wanted)).map_err(failed())?;
                reader.notify_read(read);
            }
            Ok(LinearReadEvent::Record { data, opcode }) => match mcap::parse_record(opcode, data) {
                Ok(record) => copy_record(record, &mut seen, copy)?,
                Err(error) => {
                    tracing::warn!("{}: ends in a broken record: {error}", source.display());
                    break;
                }
            },
            // The record that was being written when the process was killed.
            Err(error) => {
                tracing::info!("{}: ends in the middle of a record: {error}", source.display());
                break;
            }
        }
    }
    Ok(Copied::All)
}

/// Copies a message or a note, and remembers what messages refer to. The rest of a file is made anew.
fn copy_record(record: Record<'_>, seen: &mut Seen, copy: &mut BagFile) -> Result<(), RecorderError> {
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
            if let Some((channel, schema)) = seen.channels.get(&header.channel_id) {
                let stamp = Stamp {
                    log_ns: header.log_time,
                    publish_ns: header.publish_time,
                    sequence: header.sequence,
                };
                copy.write(channel, schema, stamp, &data)?;
            }
        }
        Record::Metadata(note) => copy.note(&note)?,
        _ => {}
    }
    Ok(())
}

#[cfg(test)]
mod tests;
