//! Lines of a serial encoder: `E:<counts>`, counts since the device's start, signed.

/// Longest line `[bytes]`: what is longer is no reading.
const LINE_MAX: usize = 160;

/// Cuts a stream of bytes into lines; a partial line waits for its rest, one that is too long is thrown away.
#[derive(Debug, Clone, Default)]
pub struct LineBuffer {
    line: Vec<u8>,
    skipping: bool,
}

impl LineBuffer {
    /// Takes bytes and hands each complete line, without its end, to `take`; an overlong one as `None`.
    pub fn push(&mut self, bytes: &[u8], mut take: impl FnMut(Option<&[u8]>)) {
        for byte in bytes {
            match byte {
                b'\n' | b'\r' if self.skipping => {
                    self.skipping = false;
                    take(None);
                }
                b'\n' | b'\r' => {
                    if !self.line.is_empty() {
                        take(Some(&self.line));
                    }
                    self.line.clear();
                }
                _ if self.skipping => {}
                _ if self.line.len() >= LINE_MAX => {
                    self.line.clear();
                    self.skipping = true;
                }
                _ => self.line.push(*byte),
            }
        }
    }

    /// Forgets a partial line: the device was connected anew.
    pub fn clear(&mut self) {
        self.line.clear();
        self.skipping = false;
    }
}

/// Why a line is no reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LineError {
    /// No count in it: a greeting or a comment.
    Other,
    /// A count that is no whole number, or bytes that are no text.
    Garbage,
}

/// Reads the counts of one line.
///
/// # Errors
/// [`LineError`]; both kinds are to be counted.
pub fn parse(line: &[u8]) -> Result<i64, LineError> {
    let text = std::str::from_utf8(line).map_err(|_| LineError::Garbage)?;
    let counts = text.trim().strip_prefix("E:").ok_or(LineError::Other)?;
    counts.trim().parse().map_err(|_| LineError::Garbage)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn lines_of_the_device() {
        assert_eq!(parse(b"E:1234"), Ok(1234));
        assert_eq!(parse(b" E: -7 "), Ok(-7));
        assert_eq!(parse(b"# encoder 1.0"), Err(LineError::Other));
        for garbage in [&b"E:"[..], b"E:nan", b"E:1.5", b"E:99999999999999999999", b"\xffE:1"] {
            assert_eq!(parse(garbage), Err(LineError::Garbage));
        }
    }

    proptest! {
        #[test]
        fn any_bytes_in_any_pieces_give_the_same_lines(
            bytes in proptest::collection::vec(any::<u8>(), 0..600), cut in 0usize..600
        ) {
            let lines = |pieces: [&[u8]; 2]| {
                let (mut buffer, mut lines) = (LineBuffer::default(), Vec::new());
                for piece in pieces {
                    buffer.push(piece, |line| lines.push(line.map(parse)));
                }
                lines
            };
            let (first, second) = bytes.split_at(cut.min(bytes.len()));
            prop_assert_eq!(lines([first, second]), lines([&bytes, &[]]));
        }

        #[test]
        fn written_counts_are_read_back(counts in any::<i64>()) {
            prop_assert_eq!(parse(format!("E:{counts}").as_bytes()), Ok(counts));
        }
    }
}
