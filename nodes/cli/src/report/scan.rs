//! Reads the records of an MCAP file one by one, up to the first that is not whole. The file is only read.

use anyhow::Context;
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Longest record or chunk that is read `[byte]`: a length in a file may say anything.
const RECORD_MAX: usize = 256 * 1024 * 1024;
/// Read from the file at once `[byte]`.
const BUFFER: usize = 1024 * 1024;

/// A message with what its channel says of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Raw<'a> {
    pub(crate) topic: &'a str,
    pub(crate) type_name: &'a str,
    pub(crate) encoding: &'a str,
    pub(crate) payload: &'a [u8],
}

/// Who takes the records.
pub(crate) trait Visitor {
    /// A message.
    fn message(&mut self, raw: &Raw<'_>);
    /// A metadata record.
    fn note(&mut self, name: &str, values: &BTreeMap<String, String>);
}

/// How a file ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Ended {
    /// With its closing record.
    Whole,
    /// Without: it was cut, or is being written.
    Torn(String),
}

#[derive(Debug, Clone)]
struct Channel {
    topic: String,
    type_name: String,
    encoding: String,
}

/// Schemas and channels by their numbers in the file.
#[derive(Debug, Default)]
struct Seen {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    footer: bool,
}

/// Hands every whole record to `visitor`.
pub(crate) fn scan(path: &Path, visitor: &mut impl Visitor) -> anyhow::Result<Ended> {
    let failed = || path.display().to_string();
    let mut file = BufReader::with_capacity(BUFFER, File::open(path).with_context(failed)?);
    let options =
        LinearReaderOptions::default().with_skip_end_magic(true).with_record_length_limit(RECORD_MAX);
    let mut reader = LinearReader::new_with_options(options);
    let mut seen = Seen::default();
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let read = file.read(reader.insert(wanted)).with_context(failed)?;
                reader.notify_read(read);
            }
            Ok(LinearReadEvent::Record { data, opcode }) => match mcap::parse_record(opcode, data) {
                Ok(record) => seen.take(record, visitor),
                Err(error) => return Ok(Ended::Torn(format!("a broken record: {error}"))),
            },
            Err(error) => return Ok(Ended::Torn(format!("the middle of a record: {error}"))),
        }
    }
    Ok(if seen.footer {
        Ended::Whole
    } else {
        Ended::Torn("a whole record, but was never closed".to_owned())
    })
}

impl Seen {
    fn take(&mut self, record: Record<'_>, visitor: &mut impl Visitor) {
        match record {
            Record::Schema { header, .. } => _ = self.schemas.insert(header.id, header.name),
            Record::Channel(channel) => {
                let type_name = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                let known = Channel { topic: channel.topic, type_name, encoding: channel.message_encoding };
                self.channels.insert(channel.id, known);
            }
            Record::Message { header, data } => {
                if let Some(Channel { topic, type_name, encoding }) = self.channels.get(&header.channel_id) {
                    visitor.message(&Raw { topic, type_name, encoding, payload: &data });
                }
            }
            Record::Metadata(note) => visitor.note(&note.name, &note.metadata),
            Record::Footer(_) => self.footer = true,
            _ => {}
        }
    }
}
