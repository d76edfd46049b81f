//! Parts of an endless `multipart/x-mixed-replace` body (RFC 2046, 5.1): what MJPEG servers send.
//!
//! Memory is bounded by the limits on header and part. A part whose length is given is handed over when its last
//! byte has come, not when the next one begins: a frame must not be late by a period. What is wrong with one part is
//! told and the reader goes on at the next boundary; where no boundary can be found the stream is given up.

/// Bounds of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Header lines of a part `[byte]`.
    pub header_bytes: usize,
    /// Body of a part `[byte]`.
    pub part_bytes: usize,
}

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part<'a> {
    /// The body of an `image/jpeg` part.
    Picture(&'a [u8]),
    /// A part that is passed over.
    Refused(PartError),
}

/// Why a part is passed over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PartError {
    /// Its content is not `image/jpeg`.
    Content,
    /// Its length is no number.
    Length,
    /// Longer than the limit.
    TooLong,
    /// The next boundary comes before its length says.
    CutOff,
}

/// Why a stream is given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, thiserror::Error)]
pub enum StreamError {
    /// A header beyond its limit.
    #[error("the header of a part is too long")]
    Header,
    /// No boundary within the length of a part.
    #[error("no boundary between parts")]
    Boundary,
    /// The closing boundary.
    #[error("the server has ended the stream")]
    Ended,
}

/// Where the reader stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// Before a boundary; so many bytes were passed over.
    Between { passed: usize },
    /// In the rest of a boundary's line.
    Line,
    /// In the header of a part.
    Header,
    /// In a part of known length.
    Measured(usize),
    /// In a part that lasts until the next boundary; so many bytes hold none.
    Open { searched: usize },
}

/// Finds parts in a stream of bytes.
#[derive(Debug, Clone)]
pub struct Reader {
    delimiter: Vec<u8>,
    limits: Limits,
    buffer: Vec<u8>,
    place: Place,
}

/// One step of the reader.
enum Step {
    /// Bytes are used up to here.
    Go,
    /// More bytes are needed.
    Wait,
}

impl Reader {
    /// A reader of parts between `boundary`, as the content type of the answer has it. Servers differ in whether they
    /// count the leading dashes as part of it.
    #[must_use]
    pub fn new(boundary: &str, limits: Limits) -> Self {
        let delimiter = format!("--{}", boundary.trim_start_matches("--")).into_bytes();
        Self { delimiter, limits, buffer: Vec::new(), place: Place::Between { passed: 0 } }
    }

    /// Takes bytes and hands every part that is complete to `take`.
    ///
    /// # Errors
    /// [`StreamError`]; the reader is of no use afterwards.
    pub fn push(&mut self, bytes: &[u8], mut take: impl FnMut(Part<'_>)) -> Result<(), StreamError> {
        self.buffer.extend_from_slice(bytes);
        while matches!(self.step(&mut take)?, Step::Go) {}
        Ok(())
    }

    fn step(&mut self, take: &mut impl FnMut(Part<'_>)) -> Result<Step, StreamError> {
        match self.place {
            Place::Between { passed } => self.between(passed),
            Place::Line => self.line(),
            Place::Header => self.header(take),
            Place::Measured(length) => Ok(self.measured(length, take)),
            Place::Open { searched } => Ok(self.open(searched, take)),
        }
    }

    fn between(&mut self, passed: usize) -> Result<Step, StreamError> {
        let found = find(&self.buffer, &self.delimiter);
        if let Some(at) = found.filter(|at| passed + at <= self.limits.part_bytes) {
            self.go(at + self.delimiter.len(), Place::Line);
            return Ok(Step::Go);
        }
        if found.is_some() {
            return Err(StreamError::Boundary);
        }
        let junk = self.buffer.len().saturating_sub(self.delimiter.len());
        let passed = passed + junk;
        if passed > self.limits.part_bytes {
            return Err(StreamError::Boundary);
        }
        self.go(junk, Place::Between { passed });
        Ok(Step::Wait)
    }

    /// The rest of a boundary's line: two dashes close the stream.
    fn line(&mut self) -> Result<Step, StreamError> {
        if self.buffer.starts_with(b"--") {
            return Err(StreamError::Ended);
        }
        let seen = self.buffer.iter().take(self.limits.header_bytes);
        match seen.enumerate().find(|(_, byte)| **byte == b'\n') {
            Some((at, _)) => {
                self.go(at + 1, Place::Header);
                Ok(Step::Go)
            }
            None if self.buffer.len() >= self.limits.header_bytes => Err(StreamError::Header),
            None => Ok(Step::Wait),
        }
    }

    fn header(&mut self, take: &mut impl FnMut(Part<'_>)) -> Result<Step, StreamError> {
        let seen = &self.buffer[..self.buffer.len().min(self.limits.header_bytes)];
        let Some(end) = header_end(seen) else {
            let full = seen.len() == self.limits.header_bytes;
            return if full { Err(StreamError::Header) } else { Ok(Step::Wait) };
        };
        let place = match body(&seen[..end]) {
            Ok(Some(length)) if length > self.limits.part_bytes => Err(PartError::TooLong),
            Ok(Some(length)) => Ok(Place::Measured(length)),
            Ok(None) => Ok(Place::Open { searched: 0 }),
            Err(error) => Err(error),
        };
        let place = place.unwrap_or_else(|error| {
            take(Part::Refused(error));
            Place::Between { passed: 0 }
        });
        self.go(end, place);
        Ok(Step::Go)
    }

    fn measured(&mut self, length: usize, take: &mut impl FnMut(Part<'_>)) -> Step {
        if self.buffer.len() < length {
            return Step::Wait;
        }
        let end = match find(&self.buffer[..length], &self.delimiter) {
            Some(at) => {
                take(Part::Refused(PartError::CutOff));
                at
            }
            None => {
                take(Part::Picture(&self.buffer[..length]));
                length
            }
        };
        self.go(end, Place::Between { passed: 0 });
        Step::Go
    }

    fn open(&mut self, searched: usize, take: &mut impl FnMut(Part<'_>)) -> Step {
        let found = find(&self.buffer[searched..], &self.delimiter).map(|at| searched + at);
        if let Some(end) = found.filter(|end| *end <= self.limits.part_bytes) {
            take(Part::Picture(without_line_end(&self.buffer[..end])));
            self.go(end, Place::Between { passed: 0 });
            return Step::Go;
        }
        if self.buffer.len() > self.limits.part_bytes + self.delimiter.len() {
            take(Part::Refused(PartError::TooLong));
            let rest = found.unwrap_or(self.limits.part_bytes);
            self.go(rest, Place::Between { passed: 0 });
            return Step::Go;
        }
        // A boundary may have begun in the last bytes.
        let searched = self.buffer.len().saturating_sub(self.delimiter.len()).max(searched);
        self.place = Place::Open { searched };
        Step::Wait
    }

    fn go(&mut self, used: usize, place: Place) {
        self.buffer.drain(..used);
        self.place = place;
    }
}

/// Where the empty line after a header ends.
fn header_end(bytes: &[u8]) -> Option<usize> {
    let mut begin = 0;
    while let Some(length) = bytes[begin..].iter().position(|byte| *byte == b'\n') {
        let line = &bytes[begin..begin + length];
        begin += length + 1;
        if line.is_empty() || line == b"\r" {
            return Some(begin);
        }
    }
    None
}

/// What a header says of its body: the length, where it is given.
fn body(header: &[u8]) -> Result<Option<usize>, PartError> {
    let (mut picture, mut length) = (false, None);
    for line in header.split(|byte| *byte == b'\n') {
        let line = String::from_utf8_lossy(line);
        let Some((name, value)) = line.split_once(':') else { continue };
        let (name, value) = (name.trim(), value.trim());
        if name.eq_ignore_ascii_case("content-type") {
            let kind = value.split(';').next().unwrap_or_default().trim();
            picture = kind.eq_ignore_ascii_case("image/jpeg") || kind.eq_ignore_ascii_case("image/jpg");
        } else if name.eq_ignore_ascii_case("content-length") {
            length = Some(value.parse().map_err(|_| PartError::Length)?);
        }
    }
    if picture { Ok(length) } else { Err(PartError::Content) }
}

/// The boundary in the content type of an answer; `None` where it is no multipart stream.
#[must_use]
pub fn boundary(content_type: &str) -> Option<&str> {
    let (kind, rest) = content_type.split_once(';')?;
    if !kind.trim().eq_ignore_ascii_case("multipart/x-mixed-replace") {
        return None;
    }
    let named = rest.split(';').filter_map(|parameter| parameter.split_once('='));
    let mut named = named.filter(|(name, _)| name.trim().eq_ignore_ascii_case("boundary"));
    let value = named.next()?.1.trim().trim_matches('"');
    let sound = !value.trim_start_matches("--").is_empty() && value.len() <= BOUNDARY_MAX;
    sound.then_some(value)
}

/// Longest boundary `[byte]`: RFC 2046.
const BOUNDARY_MAX: usize = 72;

fn without_line_end(bytes: &[u8]) -> &[u8] {
    let bytes = bytes.strip_suffix(b"\n").unwrap_or(bytes);
    bytes.strip_suffix(b"\r").unwrap_or(bytes)
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    let first = wanted.first()?;
    let mut begin = 0;
    while let Some(at) = bytes.get(begin..)?.iter().position(|byte| byte == first) {
        if bytes[begin + at..].starts_with(wanted) {
            return Some(begin + at);
        }
        begin += at + 1;
    }
    None
}

#[cfg(test)]
mod tests;
