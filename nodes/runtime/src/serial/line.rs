//! Lines out of a stream of bytes.

/// Cuts a stream of bytes into lines; a partial line waits for its rest, one that is too long is thrown away.
#[derive(Debug, Clone)]
pub struct LineBuffer {
    line: Vec<u8>,
    longest: usize,
    skipping: bool,
}

impl LineBuffer {
    /// Empty; lines have at most `longest` bytes.
    #[must_use]
    pub fn new(longest: usize) -> Self {
        Self { line: Vec::new(), longest, skipping: false }
    }

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
                _ if self.line.len() >= self.longest => {
                    self.line.clear();
                    self.skipping = true;
                }
                _ => self.line.push(*byte),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Lines of bytes that come in pieces.
    fn lines(pieces: &[&[u8]]) -> Vec<Option<Vec<u8>>> {
        let (mut buffer, mut lines) = (LineBuffer::new(8), Vec::new());
        for piece in pieces {
            buffer.push(piece, |line| lines.push(line.map(<[u8]>::to_vec)));
        }
        lines
    }

    #[test]
    fn every_line_end_ends_a_line_and_an_empty_line_is_none() {
        let expected: Vec<_> = [b"ab", b"cd", b"ef"].iter().map(|line| Some(line.to_vec())).collect();
        assert_eq!(lines(&[b"ab\n\ncd\r\nef\rgh"]), expected);
    }

    #[test]
    fn a_line_of_the_longest_length_passes_and_one_byte_more_does_not() {
        assert_eq!(
            lines(&[b"12345678\n123456789\n1\n"]),
            [Some(b"12345678".to_vec()), None, Some(b"1".to_vec())]
        );
    }

    proptest! {
        #[test]
        fn any_bytes_in_any_pieces_give_the_same_lines(
            bytes in proptest::collection::vec(prop_oneof![any::<u8>(), Just(b'\n')], 0..200), cut in 0usize..200
        ) {
            let (first, second) = bytes.split_at(cut.min(bytes.len()));
            prop_assert_eq!(lines(&[first, second]), lines(&[&bytes]));
        }
    }
}
