//! The records of one chunk.

use mcap::McapError;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::VecDeque;
use std::ops::Range;

/// Largest chunk in memory `[byte]`: a size in a file may say anything.
const CHUNK_MAX: usize = 256 * 1024 * 1024;

/// Records that are still to be handed out.
#[derive(Debug, Default)]
pub(super) struct Chunk {
    bytes: Vec<u8>,
    records: VecDeque<(u8, Range<usize>)>,
    unknown: Option<String>,
}

impl Chunk {
    /// Takes a chunk's whole record in; false where it does not fit its checksum or breaks off. Without a checksum, what
    /// stands before a break counts.
    pub(super) fn fill(&mut self, record: &[u8]) -> bool {
        self.read(record, true)
    }

    /// Takes in what is left of a chunk that was cut off: its checksum is not to be had.
    pub(super) fn fill_front(&mut self, record: &[u8]) {
        self.read(record, false);
    }

    fn read(&mut self, record: &[u8], whole: bool) -> bool {
        self.bytes.clear();
        self.records.clear();
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(whole)
            .with_record_length_limit(CHUNK_MAX);
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
                    let start = self.bytes.len();
                    self.bytes.extend_from_slice(data);
                    self.records.push_back((opcode, start..self.bytes.len()));
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

    /// The next record: operation and place of its fields.
    pub(super) fn next_record(&mut self) -> Option<(u8, Range<usize>)> {
        self.records.pop_front()
    }

    pub(super) fn fields(&self, range: Range<usize>) -> &[u8] {
        self.bytes.get(range).unwrap_or_default()
    }
}
