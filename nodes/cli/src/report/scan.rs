//! Reads the records of an MCAP file one by one, and on behind what is damaged. The file is only read.

use crate::output;
use anyhow::{Context, bail};
use bag_recorder::file::QOS_KEY;
pub(crate) use bag_recorder::walk::Sum;
use bag_recorder::walk::{self, Walk, Walked};
use mcap::records::op;
use std::collections::BTreeMap;
use std::path::Path;

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
    /// With its closing record, and nothing is missing; the checksum fits, or there is none.
    Whole(Sum),
    /// It was cut, changed or damaged, or is being written.
    Torn(Torn),
    /// It does not begin as a bag does.
    NoBag,
}

/// What is wrong with a file that is not whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Torn {
    /// In words that follow the file's name.
    pub(crate) how: String,
    /// Places before its end that could not be read.
    pub(crate) damages: u64,
    /// Bytes that could not be read.
    pub(crate) lost_bytes: u64,
    /// Messages that could not be read; `None` where the file does not say how many it has.
    pub(crate) lost_messages: Option<u64>,
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
}

/// Hands every whole record to `visitor`.
pub(crate) fn scan(path: &Path, visitor: &mut impl Visitor) -> anyhow::Result<Ended> {
    let failed = || path.display().to_string();
    let Some(mut walk) = Walk::open(path).with_context(failed)? else { return Ok(Ended::NoBag) };
    let mut seen = Seen::default();
    while let Some((opcode, fields)) = walk.next_record().with_context(failed)? {
        if seen.take(opcode, fields, visitor).is_none() {
            walk.reject();
        }
    }
    let walked = walk.finish();
    if walked.is_sound() {
        return Ok(Ended::Whole(walked.sum));
    }
    Ok(Ended::Torn(Torn {
        how: words(&walked),
        damages: walked.damages,
        lost_bytes: walked.lost_bytes,
        lost_messages: walked.lost_messages(),
    }))
}

/// The same for who needs a bag and can do without a part of it: what is missing goes to standard error.
///
/// # Errors
/// A file that cannot be read, or is none of a bag.
pub(crate) fn scan_what_is_there(path: &Path, visitor: &mut impl Visitor) -> anyhow::Result<()> {
    match scan(path, visitor)? {
        Ended::Whole(_) => {}
        Ended::Torn(torn) => output::note(&format!("{} {}", path.display(), torn.how)),
        Ended::NoBag => bail!("{}: no MCAP file", path.display()),
    }
    Ok(())
}

/// What is wrong with a file, behind its name.
fn words(walked: &Walked) -> String {
    let ended = match walked.ended {
        walk::Ended::Cut => Some("ends in the middle of a record".to_owned()),
        walk::Ended::Open => Some("ends in a whole record, but was never closed".to_owned()),
        walk::Ended::Closed => None,
    };
    let damaged = walked.damage_in_words();
    let changed = (damaged.is_none() && walked.sum == Sum::Differs).then(|| CHANGED.to_owned());
    let all: Vec<String> = [damaged, changed, ended].into_iter().flatten().collect();
    all.join("; it ")
}

impl Seen {
    /// Takes a record in; `None` where its fields reach beyond it, or nothing says what it means.
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
                let Channel { topic, type_name, encoding, offered_qos } = self.channels.get(&id)?;
                visitor.message(&Raw { topic, type_name, encoding, offered_qos, log_ns, payload });
            }
            op::METADATA => {
                let name = fields.text()?;
                visitor.note(name, &fields.pairs()?);
            }
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
