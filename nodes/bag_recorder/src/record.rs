//! Records, parsed once the lengths in them are found to lie inside of them.
//!
//! The parser of `mcap` reserves what a length says before it reads, 4 GiB of a damaged one, which no node may have, and cuts
//! an attachment without a look at where it ends.

use mcap::McapError;
use mcap::records::{Record, op};

/// Parses a record.
///
/// # Errors
/// Fields that reach beyond the record, or that are none.
pub fn parse(opcode: u8, fields: &[u8]) -> Result<Record<'_>, McapError> {
    if is_whole(opcode, fields) { mcap::parse_record(opcode, fields) } else { Err(McapError::UnexpectedEof) }
}

/// Whether all lengths in a record's fields lie inside of them.
pub(crate) fn is_whole(opcode: u8, fields: &[u8]) -> bool {
    let mut left = Left(fields);
    let passed = match opcode {
        op::HEADER => left.texts(2),
        op::SCHEMA => left.skip(2).and_then(|()| left.texts(2)),
        op::CHANNEL => left.skip(4).and_then(|()| left.texts(2)).and_then(|()| left.pairs()),
        op::CHUNK => left.skip(28).and_then(|()| left.texts(1)),
        op::CHUNK_INDEX => left.skip(32).and_then(|()| left.offsets()).and_then(|()| left.texts(1)),
        op::ATTACHMENT => left.skip(16).and_then(|()| left.texts(2)).and_then(|()| left.attached()),
        op::ATTACHMENT_INDEX => left.skip(40).and_then(|()| left.texts(2)),
        op::METADATA => left.texts(1).and_then(|()| left.pairs()),
        op::METADATA_INDEX => left.skip(16).and_then(|()| left.texts(1)),
        // What is of one length, or is read number by number.
        _ => Some(()),
    };
    passed.is_some()
}

/// What is left of the fields.
struct Left<'a>(&'a [u8]);

impl<'a> Left<'a> {
    fn take(&mut self, bytes: usize) -> Option<&'a [u8]> {
        let (front, rest) = self.0.split_at_checked(bytes)?;
        self.0 = rest;
        Some(front)
    }

    fn skip(&mut self, bytes: usize) -> Option<()> {
        self.take(bytes).map(drop)
    }

    /// As many bytes as a length in front of them says.
    fn measured(&mut self) -> Option<&'a [u8]> {
        let length = u32::from_le_bytes(self.take(4)?.try_into().ok()?);
        self.take(usize::try_from(length).ok()?)
    }

    fn texts(&mut self, count: usize) -> Option<()> {
        (0..count).try_for_each(|_| self.measured().map(drop))
    }

    fn pairs(&mut self) -> Option<()> {
        let mut inside = Left(self.measured()?);
        while !inside.0.is_empty() {
            inside.texts(2)?;
        }
        Some(())
    }

    /// Channels and where their index lies, ten bytes each, and the length of all indices.
    fn offsets(&mut self) -> Option<()> {
        let offsets = self.measured()?;
        if offsets.len().is_multiple_of(10) { self.skip(8) } else { None }
    }

    /// The bytes of an attachment, and its checksum.
    fn attached(&mut self) -> Option<()> {
        let length = u64::from_le_bytes(self.take(8)?.try_into().ok()?);
        self.skip(usize::try_from(length).ok()?)?;
        self.skip(4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A text with its length in front.
    fn text(text: &str) -> Vec<u8> {
        [&u32::try_from(text.len()).unwrap().to_le_bytes()[..], text.as_bytes()].concat()
    }

    /// Fields of one record of each kind that holds texts.
    fn records() -> Vec<(u8, Vec<u8>)> {
        let pairs = [text("key"), text("value")].concat();
        let map = [&u32::try_from(pairs.len()).unwrap().to_le_bytes()[..], &pairs].concat();
        let offsets = [&10_u32.to_le_bytes()[..], &[0; 10]].concat();
        let attached = [&3_u64.to_le_bytes()[..], b"abc", &[0; 4]].concat();
        vec![
            (op::HEADER, [text("ros2"), text("me")].concat()),
            (op::SCHEMA, [vec![1, 0], text("name"), text("ros2msg"), text("int8 a")].concat()),
            (op::CHANNEL, [vec![1, 0, 1, 0], text("/a"), text("cdr"), map.clone()].concat()),
            (op::CHUNK, [vec![0; 28], text("zstd"), vec![0; 8]].concat()),
            (op::CHUNK_INDEX, [vec![0; 32], offsets, vec![0; 8], text("zstd"), vec![0; 16]].concat()),
            (op::ATTACHMENT, [vec![0; 16], text("a"), text("b"), attached].concat()),
            (op::ATTACHMENT_INDEX, [vec![0; 40], text("a"), text("b")].concat()),
            (op::METADATA, [text("note"), map].concat()),
            (op::METADATA_INDEX, [vec![0; 16], text("note")].concat()),
        ]
    }

    /// A length of 4 GiB anywhere, or an end anywhere: refused or parsed, without a panic and without the memory.
    #[test]
    fn no_length_is_believed_beyond_its_record() {
        for (opcode, fields) in records() {
            assert!(parse(opcode, &fields).is_ok(), "{opcode}");
            for at in 0..fields.len() {
                _ = parse(opcode, &fields[..at]);
                let mut broken = fields.clone();
                broken.iter_mut().skip(at).take(4).for_each(|byte| *byte = 0xff);
                let before = peak();
                _ = parse(opcode, &broken);
                assert!(peak() - before < 1 << 20, "{opcode} at {at}");
            }
        }
    }

    /// Address space of this process at its highest `[KiB]`: what is reserved counts, written or not.
    fn peak() -> u64 {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmPeak:")).unwrap();
        line.trim().trim_end_matches(" kB").parse().unwrap()
    }

    /// An attachment whose name takes the room of its checksum: the parser of `mcap` would panic.
    #[test]
    fn an_attachment_that_ends_too_soon_is_refused() {
        let fields = [vec![0; 16], text("name"), text(""), vec![0; 8]].concat();
        assert!(parse(op::ATTACHMENT, &fields).is_err());
    }
}
