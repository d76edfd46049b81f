//! Reads the records of an MCAP file one by one, up to the first that is not whole. The file is only read.

use anyhow::Context;
use bag_recorder::file::QOS_KEY;
use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// Longest record or chunk that is read `[byte]`: a length in a file may say anything.
const RECORD_MAX: usize = 256 * 1024 * 1024;
/// Read from the file at once `[byte]`.
const BUFFER: usize = 1024 * 1024;

/// Read at once of a file that is longer than it was when it was opened `[byte]`.
const BLOCK: usize = 64 * 1024;
/// What a checksum that does not fit means.
const CHANGED: &str =
    "does not fit the checksum of its data: something in it was changed or damaged after it was written";

/// A message with what its channel says of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Raw<'a> {
    pub(crate) topic: &'a str,
    pub(crate) type_name: &'a str,
    pub(crate) encoding: &'a str,
    /// Quality of service as the channel has it; empty where it says none.
    pub(crate) offered_qos: &'a str,
    /// Log time `[ns]`.
    pub(crate) log_ns: u64,
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
    Whole(Sum),
    /// Without: it was cut, or is being written.
    Torn(String),
    /// It does not begin as a bag does.
    NoBag,
}

/// Whether the checksum of the data was there; one that does not fit ends a file as [`Ended::Torn`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sum {
    Fits,
    Absent,
}

#[derive(Debug, Clone)]
struct Channel {
    topic: String,
    type_name: String,
    encoding: String,
    offered_qos: String,
}

/// Schemas and channels by their numbers in the file.
#[derive(Debug, Default)]
struct Seen {
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    footer: bool,
    /// Records that end the data: a whole file has one.
    ends: u32,
    /// The last of them carries a checksum.
    summed: bool,
}

/// Hands every whole record to `visitor`.
pub(crate) fn scan(path: &Path, visitor: &mut impl Visitor) -> anyhow::Result<Ended> {
    let failed = || path.display().to_string();
    let file = runtime::input::open(path).with_context(failed)?;
    // A length in the file is believed up to what is left of it; a file that grows meanwhile is read on in blocks.
    let mut left = usize::try_from(file.metadata().with_context(failed)?.len()).unwrap_or(usize::MAX);
    let mut file = BufReader::with_capacity(BUFFER, file);
    let head = file.fill_buf().with_context(failed)?;
    if !MAGIC.starts_with(&head[..head.len().min(MAGIC.len())]) {
        return Ok(Ended::NoBag);
    }
    let options = LinearReaderOptions::default()
        .with_skip_end_magic(true)
        .with_validate_data_section_crc(true)
        .with_record_length_limit(RECORD_MAX);
    let mut reader = LinearReader::new_with_options(options);
    let mut seen = Seen::default();
    while let Some(event) = reader.next_event() {
        match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let read = file.read(reader.insert(wanted.min(left.max(BLOCK)))).with_context(failed)?;
                left = left.saturating_sub(read);
                reader.notify_read(read);
            }
            Ok(LinearReadEvent::Record { data, opcode }) => {
                if seen.take(opcode, data, visitor).is_none() {
                    return Ok(Ended::Torn("ends in a broken record".to_owned()));
                }
            }
            Err(McapError::BadDataCrc { .. }) => return Ok(Ended::Torn(CHANGED.to_owned())),
            Err(error) => return Ok(Ended::Torn(format!("ends in the middle of a record: {error}"))),
        }
    }
    Ok(match (seen.footer, seen.ends, seen.summed) {
        (true, 1, true) => Ended::Whole(Sum::Fits),
        (true, 1, false) => Ended::Whole(Sum::Absent),
        // The reader checks the sum at the first end alone, and stops at whatever calls itself the closing record.
        (true, ..) => {
            Ended::Torn("is closed in its middle: a record of it was changed or damaged".to_owned())
        }
        _ => Ended::Torn("ends in a whole record, but was never closed".to_owned()),
    })
}

impl Seen {
    /// Takes a record in; `None` where its fields reach beyond it.
    fn take(&mut self, opcode: u8, record: &[u8], visitor: &mut impl Visitor) -> Option<()> {
        let mut fields = Fields(record);
        match opcode {
            op::SCHEMA => {
                let (id, name) = (fields.u16()?, fields.text()?);
                self.schemas.insert(id, name.to_owned());
            }
            op::CHANNEL => {
                let (id, schema, topic) = (fields.u16()?, fields.u16()?, fields.text()?.to_owned());
                let type_name = self.schemas.get(&schema).cloned().unwrap_or_default();
                let encoding = fields.text()?.to_owned();
                let offered_qos = fields.pairs()?.remove(QOS_KEY).unwrap_or_default();
                self.channels.insert(id, Channel { topic, type_name, encoding, offered_qos });
            }
            op::MESSAGE => {
                let id = fields.u16()?;
                let (_sequence, log_ns) = (fields.u32()?, fields.u64()?);
                let _publish_ns = fields.u64()?;
                let payload = fields.0;
                if let Some(Channel { topic, type_name, encoding, offered_qos }) = self.channels.get(&id) {
                    visitor.message(&Raw { topic, type_name, encoding, offered_qos, log_ns, payload });
                }
            }
            op::METADATA => {
                let name = fields.text()?;
                visitor.note(name, &fields.pairs()?);
            }
            op::DATA_END => {
                self.ends += 1;
                self.summed = fields.u32()? != 0;
            }
            op::FOOTER => self.footer = true,
            _ => {}
        }
        Some(())
    }
}

/// What is left of a record: fields are taken from its front, never more than there is.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (front, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*front)
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    /// Bytes behind their count.
    fn bytes(&mut self) -> Option<&'a [u8]> {
        let length = usize::try_from(self.u32()?).ok()?;
        let (front, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(front)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Keys and values behind the count of their bytes.
    fn pairs(&mut self) -> Option<BTreeMap<String, String>> {
        let mut pairs = Fields(self.bytes()?);
        let mut values = BTreeMap::new();
        while !pairs.0.is_empty() {
            values.insert(pairs.text()?.to_owned(), pairs.text()?.to_owned());
        }
        Some(values)
    }

    fn text(&mut self) -> Option<&'a str> {
        std::str::from_utf8(self.bytes()?).ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Nobody;

    impl Visitor for Nobody {
        fn message(&mut self, _: &Raw<'_>) {}
        fn note(&mut self, _: &str, _: &BTreeMap<String, String>) {}
    }

    /// A text of 4 GB in a record of 12 bytes: nothing is set aside for it.
    #[test]
    fn a_length_beyond_the_record_breaks_it() {
        let mut seen = Seen::default();
        let huge = [0xff, 0xff, 0xff, 0xff, b'a', b'b'];
        let tails = [[[0; 4].as_slice(), &huge].concat(), [[4, 0, 0, 0].as_slice(), b"note", &huge].concat()];
        for opcode in [op::SCHEMA, op::CHANNEL, op::METADATA] {
            for record in &tails {
                assert_eq!(seen.take(opcode, record, &mut Nobody), None, "{opcode}: {record:?}");
            }
        }
        assert_eq!(seen.take(op::MESSAGE, &[1, 0, 0], &mut Nobody), None);
    }

    #[test]
    fn a_metadata_record_is_read_pair_by_pair() {
        struct Told(Vec<(String, BTreeMap<String, String>)>);
        impl Visitor for Told {
            fn message(&mut self, _: &Raw<'_>) {}
            fn note(&mut self, name: &str, values: &BTreeMap<String, String>) {
                self.0.push((name.to_owned(), values.clone()));
            }
        }
        let text = |text: &[u8]| [&u32::try_from(text.len()).unwrap().to_le_bytes(), text].concat();
        let pairs = [text(b"build"), text(b"1"), text(b"host"), text("ä".as_bytes())].concat();
        let record = [text(b"fdm_loop"), text(&pairs)].concat();
        let mut told = Told(Vec::new());
        assert_eq!(Seen::default().take(op::METADATA, &record, &mut told), Some(()));
        let pair = |(key, value): (&str, &str)| (key.to_owned(), value.to_owned());
        let wanted = [("build", "1"), ("host", "ä")].map(pair).into();
        assert_eq!(told.0, [("fdm_loop".to_owned(), wanted)]);
    }
}
