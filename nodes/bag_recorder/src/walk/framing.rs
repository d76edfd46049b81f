//! Where records begin and end: an operation, a length, and fields that have to fit it.

use super::window::Window;
use mcap::MAGIC;
use mcap::records::op;
use std::io;

/// Operation and length in front of a record's fields `[byte]`.
pub(super) const HEAD: u64 = 9;
/// Longest record that is read `[byte]`: a length in a file may say anything.
pub(super) const RECORD_MAX: u64 = 256 * 1024 * 1024;
/// Fields of a footer `[byte]`.
const FOOTER: u64 = 20;
/// Fields of the record that ends the data `[byte]`.
pub(super) const DATA_END: u64 = 4;
/// As much of a record's fields as tells whether they fit its length `[byte]`.
const FRONT: u64 = 64;
/// Longest name of a compression `[byte]`.
const COMPRESSION_MAX: u64 = 16;
/// Operations from here on are free for private use; what they mean is nobody else's business.
const PRIVATE: u8 = 0x80;
/// After so many bytes it is asked again where the file was written `[byte]`.
const STRETCH: u64 = 1024 * 1024;
/// So many records one after the other are no chance.
const ENOUGH: u32 = 3;

/// What stands at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// A record with this operation and as many bytes of fields.
    Record(u8, u64),
    /// The end of the file.
    End,
    /// A chunk that reaches beyond the end: the file was cut off in it.
    Cut,
    /// Neither.
    Nothing,
}

/// What stands at `at`.
pub(super) fn place(window: &mut Window, at: u64) -> io::Result<Place> {
    let size = window.size();
    if at >= size {
        return Ok(Place::End);
    }
    let front = window.bytes(at, HEAD + FRONT)?;
    let Some((head, fields)) = front.split_first_chunk::<9>() else { return Ok(Place::Nothing) };
    let [opcode, length @ ..] = *head;
    let length = u64::from_le_bytes(length);
    let room = size - at - HEAD;
    if length > RECORD_MAX.min(room) {
        // Its lengths agree with each other: none of them is damaged.
        let cut = opcode == op::CHUNK && length <= RECORD_MAX && fits(opcode, length, fields);
        return Ok(if cut { Place::Cut } else { Place::Nothing });
    }
    let sound = match opcode {
        op::HEADER => at == MAGIC.len() as u64,
        op::FOOTER => length == FOOTER && room == FOOTER + MAGIC.len() as u64,
        _ => fits(opcode, length, fields),
    };
    Ok(if sound { Place::Record(opcode, length) } else { Place::Nothing })
}

/// Whether a record may have so many bytes of fields, by the first of them.
fn fits(opcode: u8, length: u64, fields: &[u8]) -> bool {
    let u32_at = |at: usize| fields.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes).map(u64::from);
    let u64_at = |at: usize| fields.get(at..at + 8)?.try_into().ok().map(u64::from_le_bytes);
    match opcode {
        op::SCHEMA => length >= 14,
        op::CHANNEL => length >= 16,
        op::MESSAGE => length >= 22,
        op::CHUNK => u32_at(28).is_some_and(|name| {
            let records = usize::try_from(32 + name).ok().and_then(u64_at);
            name <= COMPRESSION_MAX
                && records.and_then(|records| records.checked_add(40 + name)) == Some(length)
        }),
        op::MESSAGE_INDEX => {
            u32_at(2).is_some_and(|entries| entries + 6 == length && entries.is_multiple_of(16))
        }
        op::CHUNK_INDEX => length >= 56,
        op::ATTACHMENT => length >= 36,
        op::ATTACHMENT_INDEX => length >= 48,
        op::STATISTICS => length >= 46,
        op::METADATA => length >= 8,
        op::METADATA_INDEX => length >= 20,
        op::SUMMARY_OFFSET => length == 17,
        op::DATA_END => length == DATA_END,
        private => private >= PRIVATE,
    }
}

/// The first place from `from` on where records follow each other, or one to the end.
pub(super) fn resume(window: &mut Window, from: u64) -> io::Result<Option<u64>> {
    let (mut at, mut looked) = (from, from);
    while at < window.size() {
        if at >= looked {
            // Gigabytes that were never written are stepped over.
            at = window.written_from(at);
            looked = at + STRETCH;
        }
        let ahead = window.ahead(at)?;
        match ahead.iter().position(|byte| (op::FOOTER..=op::DATA_END).contains(byte)) {
            None if ahead.is_empty() => break,
            // most bytes are no operation: they cost one look
            None => at += ahead.len() as u64,
            Some(before) => {
                at += before as u64;
                if follow(window, at)? {
                    return Ok(Some(at));
                }
                at += 1;
            }
        }
    }
    Ok(None)
}

/// Whether enough records follow each other from `at`, or fewer up to the end.
fn follow(window: &mut Window, mut at: u64) -> io::Result<bool> {
    for _ in 0..ENOUGH {
        match place(window, at)? {
            Place::Record(opcode, length) if opcode < PRIVATE => at += HEAD + length,
            Place::End | Place::Cut => return Ok(true),
            _ => return Ok(false),
        }
        if at + MAGIC.len() as u64 == window.size() {
            // the last record was the footer
            return Ok(true);
        }
    }
    Ok(true)
}
