//! Lines of a serial encoder: `E:<counts>`, counts since the device's start, signed.

/// Longest line `[bytes]`: what is longer is no reading.
pub const LINE_MAX: usize = 160;

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
        fn written_counts_are_read_back(counts in any::<i64>()) {
            prop_assert_eq!(parse(format!("E:{counts}").as_bytes()), Ok(counts));
        }
    }
}
