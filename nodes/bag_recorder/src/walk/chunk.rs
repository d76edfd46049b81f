//! The records of one chunk.

use mcap::McapError;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::ops::Range;

/// Largest chunk that is unpacked `[byte]`: a size in a file may say anything, and a few kB unpack to gigabytes.
pub(super) const CHUNK_MAX: u64 = 256 * 1024 * 1024;
/// Where a chunk's record has the size of what is packed in it, behind its head and two times `[byte]`.
const SIZE_AT: usize = 9 + 16;

/// Records that are still to be handed out.
#[derive(Debug, Default)]
pub(super) struct Chunk {
    /// The records one behind the other, each behind its operation and its length: of an empty one no more is kept than that.
    bytes: Vec<u8>,
    /// Where the next one begins.
    at: usize,
    unknown: Option<String>,
    oversize: Option<u64>,
}

impl Chunk {
    /// Takes a chunk's whole record in; false where it does not fit its checksum or breaks off, or unpacks to more than
    /// [`CHUNK_MAX`]. Without a checksum, what stands before a break counts.
    pub(super) fn fill(&mut self, record: &[u8]) -> bool {
        self.read(record, true)
    }

    /// Takes in what is left of a chunk that was cut off: its checksum is not to be had.
    pub(super) fn fill_front(&mut self, record: &[u8]) {
        self.read(record, false);
    }

    fn read(&mut self, record: &[u8], whole: bool) -> bool {
        // The memory of a large chunk goes with it.
        (self.bytes, self.at) = (Vec::new(), 0);
        let size = record.get(SIZE_AT..).and_then(|from| from.first_chunk().copied()).map(u64::from_le_bytes);
        if let Some(size) = size.filter(|size| *size > CHUNK_MAX) {
            self.oversize.get_or_insert(size);
            return false;
        }
        let limit = usize::try_from(CHUNK_MAX).unwrap_or(usize::MAX);
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(whole)
            .with_record_length_limit(limit);
        let mut reader = LinearReader::new_with_options(options);
        let mut rest = record;
        while let Some(event) = reader.next_event() {
            match event {
                Ok(LinearReadEvent::ReadRequest(wanted)) => {
                    let (front, back) = rest.split_at(wanted.min(rest.len()));
                    reader.insert(front.len()).copy_from_slice(front);
                    reader.notify_read(front.len());
                    rest = back;
                }
                Ok(LinearReadEvent::Record { data, opcode }) => {
                    self.bytes.push(opcode);
                    self.bytes.extend_from_slice(&(data.len() as u64).to_le_bytes());
                    self.bytes.extend_from_slice(data);
                }
                Err(McapError::UnsupportedCompression(name)) => {
                    self.unknown = Some(name);
                    return false;
                }
                Err(_broken) => return false,
            }
        }
        true
    }

    /// Name of a compression that is not known, once one was met.
    pub(super) fn unknown(&self) -> Option<&str> {
        self.unknown.as_deref()
    }

    /// Size that a chunk says to unpack to, once one was met that is not unpacked `[byte]`.
    pub(super) fn oversize(&self) -> Option<u64> {
        self.oversize
    }

    /// The next record: operation and place of its fields.
    pub(super) fn next_record(&mut self) -> Option<(u8, Range<usize>)> {
        let (head, _) = self.bytes.get(self.at..)?.split_first_chunk::<9>()?;
        let [opcode, length @ ..] = *head;
        let start = self.at + head.len();
        let fields = start..start + usize::try_from(u64::from_le_bytes(length)).ok()?;
        self.at = fields.end;
        Some((opcode, fields))
    }

    pub(super) fn fields(&self, range: Range<usize>) -> &[u8] {
        self.bytes.get(range).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes that one block of zstd unpacks to at most, of four.
    const BLOCK: u32 = 128 * 1024;

    /// A chunk of nothing but zeros, which are records without fields, that says to unpack to `size` bytes.
    fn bomb(size: u64, blocks: u32) -> Vec<u8> {
        // A frame with a window of 2 MiB, and blocks of one byte that is repeated.
        let mut packed = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x58];
        for block in 1..=blocks {
            let head = BLOCK << 3 | 1 << 1 | u32::from(block == blocks);
            packed.extend_from_slice(&head.to_le_bytes()[..3]);
            packed.push(0);
        }
        let name = [&4_u32.to_le_bytes()[..], b"zstd"].concat();
        let times = [0; 16];
        let sizes = [&size.to_le_bytes()[..], &[0; 4]].concat();
        let fields =
            [&times[..], &sizes, &name, &(packed.len() as u64).to_le_bytes(), packed.as_slice()].concat();
        [&[mcap::records::op::CHUNK][..], &(fields.len() as u64).to_le_bytes(), &fields].concat()
    }

    /// 50 kB that say to be 1.5 GiB are not unpacked; what they say is known for the one who asks why.
    #[test]
    fn a_chunk_that_unpacks_to_gigabytes_is_left_alone() {
        let mut chunk = Chunk::default();
        assert!(!chunk.fill(&bomb(12_288 * u64::from(BLOCK), 12_288)));
        assert_eq!((chunk.oversize(), chunk.bytes.capacity()), (Some(3 << 29), 0));
        chunk.fill_front(&bomb(CHUNK_MAX + 1, 64)[..100]);
        assert_eq!((chunk.next_record(), chunk.bytes.capacity()), (None, 0));
    }

    /// Where the size is a lie, no more is unpacked than it says, and what is kept of empty records is no more than they were.
    #[test]
    fn a_chunk_takes_the_memory_that_it_says_and_no_more() {
        let mut chunk = Chunk::default();
        let mut read = |size: u64, blocks| {
            chunk.fill(&bomb(size, blocks));
            let mut records = 0;
            while let Some((0, fields)) = chunk.next_record() {
                assert!(fields.is_empty());
                records += 1;
            }
            (records, chunk.bytes.capacity() as u64, chunk.oversize())
        };
        let (records, bytes, oversize) = read(900, 8192);
        assert!(records == 100 && bytes <= 2 * 900 && oversize.is_none(), "{records}, {bytes}");
        let whole = 16 * u64::from(BLOCK);
        let (records, bytes, oversize) = read(whole, 16);
        assert!(records == whole / 9 && bytes <= 2 * whole && oversize.is_none(), "{records}, {bytes}");
    }
}
