//! Goes through the records of an MCAP file, and on behind what is damaged. The file is only read.
//!
//! A record counts where its fields fit its length and another record, or the end, follows it. Where that breaks, the
//! walk goes on from the next place at which records follow each other. A chunk counts by its checksum, as a whole or
//! not at all. What is left out is told; how many messages it held says the file's own count, where it has one.
//! Schemas and channels of the summary come first: those that stand in a damaged place are known all the same.

mod chunk;
mod framing;
mod walked;
mod window;

use chunk::Chunk;
use framing::{DATA_END, HEAD, Place};
use mcap::MAGIC;
use mcap::records::op;
use std::collections::VecDeque;
use std::io;
use std::ops::Range;
use std::path::Path;
pub use walked::{Ended, Sum, Walked};
use window::Window;

/// Where the record lies that was handed out.
enum Held {
    File(Range<u64>),
    Chunk(Range<usize>),
}

/// A file under way.
pub struct Walk {
    window: Window,
    at: u64,
    /// Records of the summary that come before the data.
    ahead: VecDeque<(u8, Range<u64>)>,
    chunk: Chunk,
    /// Where the data ends, as the summary has it.
    data_end: Option<u64>,
    past_data: bool,
    /// That the summary is damaged was told at the start.
    summary_told: bool,
    /// Of the data so far; `None` once some of it was left out.
    hasher: Option<crc32fast::Hasher>,
    newest: (u8, u64, u64),
    walked: Walked,
}

impl Walk {
    /// Opens a file; `None` where it does not begin as an MCAP file does. One of a few bytes may have been cut off in its
    /// very beginning.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn open(path: &Path) -> io::Result<Option<Self>> {
        let mut window = Window::new(runtime::input::open(path)?)?;
        let start = window.bytes(0, MAGIC.len() as u64)?;
        if !MAGIC.starts_with(start) {
            return Ok(None);
        }
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(start);
        let ended = if start.len() < MAGIC.len() { Ended::Cut } else { Ended::Open };
        let mut walk = Self {
            at: start.len() as u64,
            window,
            ahead: VecDeque::new(),
            chunk: Chunk::default(),
            data_end: None,
            past_data: false,
            summary_told: false,
            hasher: Some(hasher),
            newest: (0, 0, 0),
            walked: Walked::begun(ended),
        };
        walk.look_at_summary()?;
        Ok(Some(walk))
    }

    /// The next record: operation and fields; `None` at the end.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn next_record(&mut self) -> io::Result<Option<(u8, &[u8])>> {
        let Some((opcode, held)) = self.advance()? else { return Ok(None) };
        self.walked.messages += u64::from(opcode == op::MESSAGE);
        Ok(Some(match held {
            Held::Chunk(range) => {
                self.newest = (opcode, self.newest.1, range.len() as u64);
                (opcode, self.chunk.fields(range))
            }
            Held::File(range) => {
                self.newest = (opcode, range.start, range.end - range.start);
                (opcode, self.window.bytes(range.start, range.end - range.start)?)
            }
        }))
    }

    /// The newest record is none: its fields do not make sense, or nothing says what they mean.
    pub fn reject(&mut self) {
        let (opcode, at, bytes) = self.newest;
        self.walked.messages -= u64::from(opcode == op::MESSAGE);
        self.damaged(at, bytes);
    }

    /// What was found, once there is no next record.
    #[must_use]
    pub fn finish(self) -> Walked {
        let (compression, oversize) = (self.chunk.unknown().map(str::to_owned), self.chunk.oversize());
        Walked { compression, oversize, ..self.walked }
    }

    fn advance(&mut self) -> io::Result<Option<(u8, Held)>> {
        loop {
            if let Some((opcode, range)) = self.ahead.pop_front() {
                return Ok(Some((opcode, Held::File(range))));
            }
            if let Some((opcode, range)) = self.chunk.next_record() {
                return Ok(Some((opcode, Held::Chunk(range))));
            }
            let (opcode, length) = match framing::place(&mut self.window, self.at)? {
                Place::Record(opcode, length) => (opcode, length),
                Place::End => return Ok(None),
                Place::Cut => {
                    self.end_cut()?;
                    continue;
                }
                Place::Nothing => match framing::resume(&mut self.window, self.at + 1)? {
                    Some(place) => {
                        self.leave_out(place);
                        continue;
                    }
                    None => {
                        self.end_cut()?;
                        continue;
                    }
                },
            };
            let next = self.at + HEAD + length;
            if let Some(place) = self.sooner(opcode, next)? {
                // The length is damaged: it reaches over records.
                self.leave_out(place);
                continue;
            }
            let fields = self.at + HEAD..next;
            if let Some(held) = self.take(opcode, fields)? {
                return Ok(Some((opcode, held)));
            }
            if opcode == op::FOOTER {
                self.at = self.window.size();
                return Ok(None);
            }
        }
    }

    /// No record begins any more; what was the beginning of a chunk may still hold some.
    fn end_cut(&mut self) -> io::Result<()> {
        let (start, left) = (self.at, self.window.size() - self.at);
        self.walked.lost_bytes += left;
        self.walked.ended = Ended::Cut;
        self.at = self.window.size();
        if !self.past_data && self.window.bytes(start, 1)? == [op::CHUNK] {
            self.newest = (op::CHUNK, start, 0);
            self.chunk.fill_front(self.window.bytes(start, left.min(framing::RECORD_MAX))?);
        }
        Ok(())
    }

    /// Where nothing follows a record that ends at `next`: the place inside of it from which records do.
    fn sooner(&mut self, opcode: u8, next: u64) -> io::Result<Option<u64>> {
        if opcode == op::FOOTER || framing::place(&mut self.window, next)? != Place::Nothing {
            return Ok(None);
        }
        // The records of a chunk without compression would be found in it.
        if opcode == op::CHUNK && self.chunk.fill(self.window.bytes(self.at, next - self.at)?) {
            return Ok(None);
        }
        Ok(framing::resume(&mut self.window, self.at + 1)?.filter(|place| *place < next))
    }

    /// Steps over a record; yields it where it is the reader's.
    fn take(&mut self, opcode: u8, fields: Range<u64>) -> io::Result<Option<Held>> {
        let before = self.at;
        if opcode == op::DATA_END && self.data_end.is_none_or(|end| end == before) {
            self.end_data(fields.clone())?;
            self.at = fields.end;
            return Ok(None);
        }
        if let Some(hasher) = &mut self.hasher {
            hasher.update(self.window.bytes(before, fields.end - before)?);
        }
        self.at = fields.end;
        match opcode {
            op::FOOTER => self.walked.ended = Ended::Closed,
            op::DATA_END => self.damaged(before, fields.end - before),
            _ if self.past_data => {}
            op::CHUNK => {
                let record = self.window.bytes(before, fields.end - before)?;
                let whole = self.chunk.fill(record);
                self.newest = (opcode, before, 0);
                if !whole {
                    self.damaged(before, fields.end - before);
                }
            }
            _ => return Ok(Some(Held::File(fields))),
        }
        Ok(None)
    }

    /// The data is over: its checksum counts.
    fn end_data(&mut self, fields: Range<u64>) -> io::Result<()> {
        self.past_data = true;
        let stated =
            self.window.bytes(fields.start, DATA_END)?.first_chunk().copied().map(u32::from_le_bytes);
        let computed = self.hasher.take().map(crc32fast::Hasher::finalize);
        self.walked.sum = match stated {
            None | Some(0) => Sum::Absent,
            stated if stated == computed => Sum::Fits,
            _ => Sum::Differs,
        };
        Ok(())
    }

    /// Nothing is read up to `place`.
    fn leave_out(&mut self, place: u64) {
        self.damaged(self.at, place - self.at);
        self.at = place;
        self.hasher = None;
    }

    fn damaged(&mut self, at: u64, bytes: u64) {
        if !(self.past_data && self.summary_told) {
            self.walked.damaged(at, bytes);
        }
    }

    /// Takes schemas, channels and the count of messages from the summary, where it is whole.
    fn look_at_summary(&mut self) -> io::Result<()> {
        const FOOTER: u64 = HEAD + 20;
        let end = self.window.size().saturating_sub(MAGIC.len() as u64);
        let Some(footer) = end.checked_sub(FOOTER).filter(|footer| *footer >= self.at) else { return Ok(()) };
        if self.window.bytes(end, MAGIC.len() as u64)? != MAGIC
            || !matches!(framing::place(&mut self.window, footer)?, Place::Record(op::FOOTER, _))
        {
            return Ok(());
        }
        let fields = self.window.bytes(footer + HEAD, 20)?;
        let start = fields.first_chunk().copied().map_or(0, u64::from_le_bytes);
        let sum = fields.last_chunk().copied().map_or(0, u32::from_le_bytes);
        let start = if start == 0 { footer } else { start };
        // A summary of gigabytes is none: something stands between its beginning and its end.
        let is_one = start <= footer && footer - start <= framing::RECORD_MAX;
        let Some(data_end) = start.checked_sub(HEAD + DATA_END).filter(|_| is_one) else { return Ok(()) };
        let summary = self.window.bytes(start, footer + HEAD + 16 - start)?;
        if sum != 0 && sum != crc32fast::hash(summary) {
            self.damaged(start, footer - start);
            self.summary_told = true;
            return Ok(());
        }
        if framing::place(&mut self.window, data_end)? != Place::Record(op::DATA_END, DATA_END) {
            return Ok(());
        }
        self.data_end = Some(data_end);
        let mut at = start;
        while let Place::Record(opcode, length) = framing::place(&mut self.window, at)? {
            let fields = at + HEAD..at + HEAD + length;
            match opcode {
                op::SCHEMA | op::CHANNEL => self.ahead.push_back((opcode, fields.clone())),
                op::STATISTICS => {
                    let count = self.window.bytes(fields.start, 8)?.first_chunk().copied();
                    self.walked.stated = count.map(u64::from_le_bytes);
                }
                _ => {}
            }
            at = fields.end;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
