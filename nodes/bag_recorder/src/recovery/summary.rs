//! The summary at the end of a file.

use crate::record;
use mcap::records::op;
use mcap::sans_io::{SummaryReadEvent, SummaryReader};
use mcap::{MAGIC, McapError, Summary};
use runtime::input;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// Operation and length in front of a record's fields `[byte]`.
const HEAD: usize = 9;
/// Fields of a footer `[byte]`.
const FOOTER: usize = 20;
/// Longest summary that is read `[byte]`, a quarter of a node's memory: the place of its beginning may say anything.
const SUMMARY_MAX: u64 = 64 * 1024 * 1024;

/// Reads a file's summary.
pub(super) fn read(path: &Path) -> Result<Summary, McapError> {
    let mut file = input::open(path)?;
    check(&mut file)?;
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

/// Every length in the summary lies inside of its record: the reader would believe it. What else may be wrong with the end
/// of a file the reader says itself, before it comes to a record.
fn check(file: &mut File) -> Result<(), McapError> {
    if let Some((start, footer)) = place(file)? {
        let length = footer.checked_sub(start).filter(|length| *length <= SUMMARY_MAX);
        let length = length.ok_or(McapError::UnexpectedEof)?;
        file.seek(SeekFrom::Start(start))?;
        let mut records = Vec::new();
        file.take(length).read_to_end(&mut records)?;
        if !are_whole(&records) {
            return Err(McapError::UnexpectedEof);
        }
    }
    file.seek(SeekFrom::Start(0))?;
    Ok(())
}

/// Where the summary begins, and where the footer behind it; `None` of a file without either.
fn place(file: &mut File) -> Result<Option<(u64, u64)>, McapError> {
    let mut tail = [0; HEAD + FOOTER + MAGIC.len()];
    let size = file.seek(SeekFrom::End(0))?;
    let Some(footer) = size.checked_sub(tail.len() as u64) else { return Ok(None) };
    file.seek(SeekFrom::Start(footer))?;
    file.read_exact(&mut tail)?;
    let start = tail[HEAD..].first_chunk().copied().map_or(0, u64::from_le_bytes);
    let is_one = tail[0] == op::FOOTER && tail.ends_with(MAGIC) && start > 0;
    Ok(is_one.then_some((start, footer)))
}

/// Records follow each other to the end, each whole.
fn are_whole(mut records: &[u8]) -> bool {
    while let Some((head, rest)) = records.split_first_chunk::<HEAD>() {
        let [opcode, length @ ..] = *head;
        let length = usize::try_from(u64::from_le_bytes(length)).ok();
        let Some((fields, behind)) = length.and_then(|length| rest.split_at_checked(length)) else {
            return false;
        };
        if !record::is_whole(opcode, fields) {
            return false;
        }
        records = behind;
    }
    records.is_empty()
}
