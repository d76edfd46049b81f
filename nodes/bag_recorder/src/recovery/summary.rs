//! The summary at the end of a file.

use crate::record;
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
/// Longest summary that is read `[byte]`: the place of its beginning may say anything.
const SUMMARY_MAX: u64 = 256 * 1024 * 1024;

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

/// Every length in the summary lies inside of its record: the reader would believe it.
fn check(file: &mut File) -> Result<(), McapError> {
    let tail = HEAD + FOOTER + MAGIC.len();
    let size = file.seek(SeekFrom::End(0))?;
    let footer = size.checked_sub(tail as u64).ok_or(McapError::UnexpectedEof)?;
    file.seek(SeekFrom::Start(footer + HEAD as u64))?;
    let mut start = [0; 8];
    file.read_exact(&mut start)?;
    let start = u64::from_le_bytes(start);
    // Without a summary there is nothing to believe.
    if start > 0 {
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
