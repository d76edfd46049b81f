//! All records of a file, one by one into another: those of a bag that another program wrote among them.

use super::channel_of;
use crate::contents::Channel;
use crate::error::RecorderError;
use crate::file::{BagFile, Described, LIBRARY, MESSAGE_ENCODING, NOTE, Stamp};
use crate::record;
use crate::walk::{Walk, Walked};
use mcap::records::Record;
use mcap::{Attachment, McapError};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// How a copy ended.
pub(super) enum Copied {
    All(Walked),
    Stopped,
}

/// A channel, and its number in the copy once it has a message there.
struct Known {
    key: Channel,
    described: Described,
    copied: Option<u16>,
}

/// Schemas and channels by their numbers in the file that is read.
#[derive(Default)]
struct Seen {
    schemas: BTreeMap<u16, (String, String, Vec<u8>)>,
    channels: BTreeMap<u16, Known>,
}

impl Seen {
    /// Remembers what a channel says, with its schema; a channel without one has an empty one.
    fn channel(&mut self, channel: mcap::records::Channel) {
        let schema = self.schemas.get(&channel.schema_id).cloned();
        let type_name = schema.as_ref().map(|(name, ..)| name.clone()).unwrap_or_default();
        let key = channel_of(&channel.topic, type_name, &channel.metadata);
        let described = Described { schema, encoding: channel.message_encoding, metadata: channel.metadata };
        self.channels.insert(channel.id, Known { key, described, copied: None });
    }
}

/// Opens a file for a walk through its records.
fn open(path: &Path) -> Result<Walk, RecorderError> {
    let walk = Walk::open(path).map_err(RecorderError::file("read", path))?;
    walk.ok_or(McapError::BadMagic).map_err(RecorderError::mcap("read", path))
}

/// Goes through every record of a file. What a copy would not take counts as damage.
///
/// # Errors
/// A file that cannot be read, or is none of a bag; one that holds what could not be copied: [`RecorderError::Foreign`].
/// A recorder of ours writes no records of private use: in its files they are damaged ones.
pub fn look(path: &Path) -> Result<Walked, RecorderError> {
    let mut walk = open(path)?;
    let foreign =
        |what: String| RecorderError::Foreign { path: path.to_path_buf(), what: in_one_line(&what) };
    let (mut channels, mut private, mut is_ours) = (BTreeSet::new(), None, false);
    loop {
        let unsound = match walk.next_record().map_err(RecorderError::file("read", path))? {
            None => break,
            Some((opcode, fields)) => match record::parse(opcode, fields) {
                Ok(Record::Channel(channel)) if channel.message_encoding != MESSAGE_ENCODING => {
                    let (topic, encoding) = (channel.topic, channel.message_encoding);
                    return Err(foreign(format!("messages of {topic} of encoding '{encoding}'")));
                }
                Ok(Record::Channel(channel)) => {
                    channels.insert(channel.id);
                    false
                }
                Ok(Record::Message { header, .. }) => !channels.contains(&header.channel_id),
                Ok(Record::Unknown { opcode, .. }) => {
                    private.get_or_insert(opcode);
                    true
                }
                Ok(record) => {
                    is_ours |= is_of_ours(&record);
                    false
                }
                Err(_broken) => true,
            },
        };
        if unsound {
            walk.reject();
        }
    }
    if let Some(opcode) = private.filter(|_| !is_ours) {
        return Err(foreign(format!("records of private use, with operation {opcode:#04x}")));
    }
    let walked = walk.finish();
    match &walked.compression {
        Some(name) => Err(foreign(format!("chunks compressed by '{name}'"))),
        None => Ok(walked),
    }
}

/// Longest text out of a file that is said again `[character]`.
const SAID: usize = 200;

/// A text out of a file, as a line of a log may hold it.
fn in_one_line(text: &str) -> String {
    text.chars().take(SAID).map(|letter| if letter.is_control() { '?' } else { letter }).collect()
}

/// Whether a record tells that a recorder of ours wrote the file: its head, or the note behind it.
fn is_of_ours(record: &Record<'_>) -> bool {
    match record {
        Record::Header(header) => header.library.starts_with(LIBRARY),
        Record::Metadata(note) => note.name == NOTE,
        _ => false,
    }
}

/// Copies every record that can be read.
pub(super) fn copy_records(
    source: &Path,
    copy: &mut BagFile,
    stop: &AtomicBool,
) -> Result<Copied, RecorderError> {
    let mut walk = open(source)?;
    let mut seen = Seen::default();
    loop {
        if stop.load(Ordering::Relaxed) {
            return Ok(Copied::Stopped);
        }
        let taken = match walk.next_record().map_err(RecorderError::file("read", source))? {
            None => return Ok(Copied::All(walk.finish())),
            Some((opcode, fields)) => match record::parse(opcode, fields) {
                Ok(record) => copy_record(record, &mut seen, copy)?,
                Err(_broken) => false,
            },
        };
        if !taken {
            walk.reject();
        }
    }
}

/// Copies what is in a file, and remembers what messages refer to. Indices and counts are made anew. False for a message
/// of which nothing says what it is.
fn copy_record(record: Record<'_>, seen: &mut Seen, copy: &mut BagFile) -> Result<bool, RecorderError> {
    match record {
        Record::Schema { header, data } => {
            seen.schemas.insert(header.id, (header.name, header.encoding, data.into_owned()));
        }
        Record::Channel(channel) => seen.channel(channel),
        Record::Message { header, data } => {
            let Some(Known { key, described, copied }) = seen.channels.get_mut(&header.channel_id) else {
                return Ok(false);
            };
            let id = match copied {
                Some(id) => *id,
                None => *copied.insert(copy.describe(key, described)?),
            };
            let stamp =
                Stamp { log_ns: header.log_time, publish_ns: header.publish_time, sequence: header.sequence };
            copy.append(id, key, stamp, &data)?;
        }
        Record::Metadata(note) => copy.note(&note)?,
        Record::Attachment { header, data, .. } => copy.attach(&Attachment {
            log_time: header.log_time,
            create_time: header.create_time,
            name: header.name,
            media_type: header.media_type,
            data,
        })?,
        // One of ours that was damaged: a file with others is not copied.
        Record::Unknown { .. } => return Ok(false),
        _ => {}
    }
    Ok(true)
}

#[cfg(test)]
mod tests;
