//! Lines from a stream, each at most so long, memory flat.

use std::io::{self, BufRead, Read};

/// Reads lines ended by LF (CR LF included); a lone CR stays inside for the caller to split.
pub struct LineReader<R> {
    source: R,
    buffer: Vec<u8>,
    limit: usize,
    line: u64,
}

/// One line without its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawLine<'a> {
    /// Bytes without LF and without the CR before it.
    pub bytes: &'a [u8],
    /// From 1.
    pub line: u64,
    /// Bytes beyond the limit were dropped.
    pub cut: bool,
    /// A line end stands behind it: false where the file ends inside the line.
    pub ended: bool,
}

impl<R: BufRead> LineReader<R> {
    /// Reads at most `limit` bytes of each line.
    pub fn new(source: R, limit: usize) -> Self {
        Self { source, buffer: Vec::new(), limit, line: 0 }
    }

    /// Next line, `None` at the end.
    ///
    /// # Errors
    /// Those of the source.
    pub fn next_line(&mut self) -> io::Result<Option<RawLine<'_>>> {
        self.buffer.clear();
        let limit = self.limit as u64 + 1;
        let mut taken = (&mut self.source).take(limit).read_until(b'\n', &mut self.buffer)?;
        if taken == 0 {
            return Ok(None);
        }
        self.line += 1;
        let cut = taken as u64 == limit && self.buffer.last() != Some(&b'\n');
        let mut ended = self.buffer.last() == Some(&b'\n');
        if cut {
            ended = self.skip_rest()?;
            self.buffer.truncate(self.limit);
            taken = self.limit;
        } else if ended {
            taken -= 1;
            if taken > 0 && self.buffer[taken - 1] == b'\r' {
                taken -= 1;
            }
        }
        Ok(Some(RawLine { bytes: &self.buffer[..taken], line: self.line, cut, ended }))
    }

    /// Drops bytes to the end of the line; false where the file ends first.
    fn skip_rest(&mut self) -> io::Result<bool> {
        loop {
            let available = self.source.fill_buf()?;
            if available.is_empty() {
                return Ok(false);
            }
            let end = available.iter().position(|byte| *byte == b'\n');
            let used = end.map_or(available.len(), |at| at + 1);
            self.source.consume(used);
            if end.is_some() {
                return Ok(true);
            }
        }
    }
}
