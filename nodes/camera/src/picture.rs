//! Size of a picture from its header, without decoding it: ITU-T T.81 (JPEG) and RFC 2083 (PNG).

/// Largest frame that is passed or decoded `[px]`: faults.md S9, 8 MP as 2^23, so that 3840x2160 passes.
pub const PIXELS_MAX: u64 = 1 << 23;
/// Smallest side of a frame `[px]`.
pub const SIDE_MIN_PX: u32 = 16;

/// What the header of a picture says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// Columns `[px]`.
    pub width_px: u32,
    /// Rows `[px]`.
    pub height_px: u32,
    /// Colour components: 1 or 3.
    pub components: u8,
}

impl Header {
    /// Whether a decoder may be given the picture.
    #[must_use]
    pub fn bounded(&self) -> bool {
        u64::from(self.width_px) * u64::from(self.height_px) <= PIXELS_MAX
            && self.width_px.min(self.height_px) >= SIDE_MIN_PX
    }
}

/// Why a picture is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HeaderError {
    /// Other magic number.
    #[error("not of the named kind by its first bytes")]
    Magic,
    /// Ends before its header, or without its end mark.
    #[error("cut off")]
    CutOff,
    /// Segments that do not follow one another.
    #[error("byte {at} is no marker")]
    Marker {
        /// Where `[byte]`.
        at: usize,
    },
    /// No size, two sizes, or a size of nothing.
    #[error("no one size in its header")]
    Size,
    /// A coding that the decoder does not know: lossless, hierarchical, arithmetic, 12 bits, four components.
    #[error("of a coding that is not read: SOF marker {marker:#04x}, {bits} bits, {components} components")]
    Coding {
        /// Second byte of the start-of-frame marker.
        marker: u8,
        /// Bits of a sample.
        bits: u8,
        /// Components.
        components: u8,
    },
}

/// Reads a JPEG's header up to its first scan; the picture must end with its end mark. Takes time by its segments,
/// of which a picture of 4 MiB has at most 2^20.
///
/// # Errors
/// [`HeaderError`]
pub fn jpeg_header(bytes: &[u8]) -> Result<Header, HeaderError> {
    if !bytes.starts_with(&[0xff, 0xd8, 0xff]) {
        return Err(HeaderError::Magic);
    }
    if !is_ended(bytes) {
        return Err(HeaderError::CutOff);
    }
    let (mut at, mut found) = (2, None);
    loop {
        let (marker, begin) = marker(bytes, at)?;
        match marker {
            // TEM and the restart marks stand alone.
            0x01 | 0xd0..=0xd7 => at = begin,
            0xd8 | 0xd9 => return Err(HeaderError::Size),
            _ => {
                let length = usize::from(word(bytes, begin).ok_or(HeaderError::CutOff)?);
                let body = bytes.get(begin + 2..begin + length).ok_or(HeaderError::CutOff)?;
                if marker == 0xda {
                    return found.ok_or(HeaderError::Size);
                }
                // Start of frame, but DHT, JPG and DAC in between.
                let frame = matches!(marker, 0xc0..=0xcf) && !matches!(marker, 0xc4 | 0xc8 | 0xcc);
                if frame && found.replace(frame_header(marker, body)?).is_some() {
                    return Err(HeaderError::Size);
                }
                at = begin + length;
            }
        }
    }
}

/// Cameras pad frames with zeros, or end them with the line end of the stream.
fn is_ended(bytes: &[u8]) -> bool {
    let padding = bytes.iter().rev().take_while(|byte| matches!(byte, 0 | b'\r' | b'\n')).count();
    bytes[..bytes.len() - padding].ends_with(&[0xff, 0xd9])
}

/// The marker at a position, fill bytes skipped, and where its segment begins.
fn marker(bytes: &[u8], at: usize) -> Result<(u8, usize), HeaderError> {
    let rest = bytes.get(at..).unwrap_or_default();
    let fill = rest.iter().take_while(|byte| **byte == 0xff).count();
    match rest.get(fill) {
        None => Err(HeaderError::CutOff),
        Some(0) => Err(HeaderError::Marker { at }),
        Some(_) if fill == 0 => Err(HeaderError::Marker { at }),
        Some(marker) => Ok((*marker, at + fill + 1)),
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..at + 2).map(|pair| u16::from_be_bytes([pair[0], pair[1]]))
}

/// Start of frame: bits, height, width, components.
fn frame_header(marker: u8, body: &[u8]) -> Result<Header, HeaderError> {
    let [bits, .., components] = *body.get(..6).ok_or(HeaderError::CutOff)? else {
        return Err(HeaderError::CutOff);
    };
    let (height, width) = (word(body, 1), word(body, 3));
    let known = matches!(marker, 0xc0..=0xc2) && bits == 8 && matches!(components, 1 | 3);
    if !known {
        return Err(HeaderError::Coding { marker, bits, components });
    }
    match (width, height) {
        // A height of 0 is told later, by a DNL segment: no camera does that.
        (Some(width @ 1..), Some(height @ 1..)) => {
            Ok(Header { width_px: width.into(), height_px: height.into(), components })
        }
        _ => Err(HeaderError::Size),
    }
}

/// Reads a PNG's header.
///
/// # Errors
/// [`HeaderError`]
pub fn png_header(bytes: &[u8]) -> Result<Header, HeaderError> {
    const MAGIC: [u8; 8] = [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n'];
    if !bytes.starts_with(&MAGIC) {
        return Err(HeaderError::Magic);
    }
    if bytes.get(12..16) != Some(b"IHDR") {
        return Err(HeaderError::CutOff);
    }
    let side = |at: usize| {
        let four = bytes.get(at..at + 4).and_then(|four| <[u8; 4]>::try_from(four).ok());
        four.map(u32::from_be_bytes).ok_or(HeaderError::CutOff)
    };
    let (width_px, height_px) = (side(16)?, side(20)?);
    if width_px == 0 || height_px == 0 {
        return Err(HeaderError::Size);
    }
    // Colour type: bit 1 tells colour.
    let components = if bytes.get(25).is_some_and(|kind| kind & 2 != 0) { 3 } else { 1 };
    Ok(Header { width_px, height_px, components })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The least JPEG of a size: an APP0 segment, SOF0, SOS, end.
    pub(crate) fn jpeg(width: u16, height: u16, noise: u8) -> Vec<u8> {
        let mut bytes = vec![0xff, 0xd8, 0xff, 0xe0, 0, 4, 1, noise, 0xff, 0xff, 0xc0, 0, 11, 8];
        bytes.extend(height.to_be_bytes());
        bytes.extend(width.to_be_bytes());
        bytes.extend([1, 1, 0x11, 0, 0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0, 0x55, 0xff, 0xd9]);
        bytes
    }

    #[test]
    fn a_size_is_read_whatever_stands_before_it() {
        let grey = Header { width_px: 640, height_px: 480, components: 1 };
        assert_eq!(jpeg_header(&jpeg(640, 480, 7)), Ok(grey));
        let mut padded = jpeg(640, 480, 7);
        padded.extend([0, 0, b'\r', b'\n']);
        assert_eq!(jpeg_header(&padded), Ok(grey));
    }

    /// S9: corrupt frames and headers of any size are refused before a decoder sees them.
    #[test]
    fn what_is_no_frame_is_refused_by_its_header() {
        type Poison = fn(&mut Vec<u8>);
        let coding = |marker, bits, components| HeaderError::Coding { marker, bits, components };
        let poisons: [(HeaderError, Poison); 10] = [
            (HeaderError::Magic, |bytes| bytes[0] = 0),
            (HeaderError::Magic, Vec::clear),
            (HeaderError::CutOff, |bytes| bytes.truncate(bytes.len() - 1)),
            (HeaderError::CutOff, |bytes| bytes[5] = 200),
            (HeaderError::Marker { at: 8 }, |bytes| bytes[8] = 7),
            (HeaderError::Size, |bytes| bytes[14..16].fill(0)),
            (HeaderError::Size, |bytes| bytes[10] = 0xe1),
            (coding(0xc3, 8, 1), |bytes| bytes[10] = 0xc3),
            (coding(0xc0, 12, 1), |bytes| bytes[13] = 12),
            (coding(0xc0, 8, 4), |bytes| bytes[18] = 4),
        ];
        for (error, poison) in poisons {
            let mut bytes = jpeg(640, 480, 7);
            poison(&mut bytes);
            assert_eq!(jpeg_header(&bytes), Err(error));
        }
    }

    #[test]
    fn eight_megapixels_are_the_bound() {
        assert!(jpeg_header(&jpeg(3840, 2160, 0)).unwrap().bounded());
        assert!(!jpeg_header(&jpeg(10_000, 10_000, 0)).unwrap().bounded());
        assert!(!jpeg_header(&jpeg(65_535, 15, 0)).unwrap().bounded());
        let huge = Header { width_px: u32::MAX, height_px: u32::MAX, components: 3 };
        assert!(!huge.bounded());
    }

    #[test]
    fn a_png_is_read() {
        let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\x02\x80\0\0\x01\xe0\x08\x02".to_vec();
        assert_eq!(png_header(&png), Ok(Header { width_px: 640, height_px: 480, components: 3 }));
        png.truncate(20);
        assert_eq!(png_header(&png), Err(HeaderError::CutOff));
        assert_eq!(png_header(&jpeg(64, 64, 0)), Err(HeaderError::Magic));
    }

    proptest! {
        /// Any bytes, also behind a sound beginning: an answer, no panic, never a size of nothing.
        #[test]
        fn any_bytes_give_a_size_or_an_error(
            mut tail in proptest::collection::vec(prop_oneof![any::<u8>(), Just(0xff)], 0..400),
            begin in 0usize..4,
        ) {
            let sound = jpeg(640, 480, 7);
            let mut bytes = sound[..[0, 3, 10, sound.len() - 5][begin]].to_vec();
            bytes.append(&mut tail);
            bytes.extend([0xff, 0xd9]);
            if let Ok(header) = jpeg_header(&bytes) {
                prop_assert!(header.width_px > 0 && header.height_px > 0);
            }
            let _ = png_header(&bytes);
        }

        #[test]
        fn one_flipped_byte_never_panics(at in 0usize..60, value in any::<u8>()) {
            let mut bytes = jpeg(640, 480, 7);
            let at = at % bytes.len();
            bytes[at] = value;
            let _ = jpeg_header(&bytes);
        }
    }
}
