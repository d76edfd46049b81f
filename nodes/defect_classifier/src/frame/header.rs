//! Size of a picture from a JPEG's header (ITU-T T.81, annex B), without decoding.

/// Size that a JPEG announces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct JpegSize {
    /// Width `[px]`, above 0.
    pub width_px: u16,
    /// Height `[px]`, above 0.
    pub height_px: u16,
}

/// Size in the frame header; `None` for what is no JPEG, has none, or has one of zero.
///
/// Walks the marker segments, each of which says its own length, up to the first frame header (SOF).
#[must_use]
pub fn jpeg_size(bytes: &[u8]) -> Option<JpegSize> {
    frame_header(bytes).map(|(_, size)| size)
}

/// Whether the rows come in several scans, each of which makes the picture finer.
pub(super) fn is_progressive(bytes: &[u8]) -> bool {
    frame_header(bytes).is_some_and(|(marker, _)| marker == 0xc2)
}

/// Marker and size of the frame header.
fn frame_header(bytes: &[u8]) -> Option<(u8, JpegSize)> {
    if !bytes.starts_with(&[0xff, 0xd8, 0xff]) {
        return None;
    }
    let mut at = 2;
    loop {
        // Markers may be padded with any number of 0xff.
        while bytes.get(at)? == &0xff && bytes.get(at + 1)? == &0xff {
            at += 1;
        }
        if bytes.get(at)? != &0xff {
            return None;
        }
        let marker = *bytes.get(at + 1)?;
        let length = usize::from(word(bytes, at + 2)?);
        match marker {
            // Start of frame; 0xc4, 0xc8 and 0xcc are tables.
            0xc0..=0xcf if !matches!(marker, 0xc4 | 0xc8 | 0xcc) => {
                let (height_px, width_px) = (word(bytes, at + 5)?, word(bytes, at + 7)?);
                return (height_px > 0 && width_px > 0).then_some((marker, JpegSize { width_px, height_px }));
            }
            // The picture's data, or its end, without a frame header.
            0xda | 0xd9 => return None,
            _ if length < 2 => return None,
            _ => at += 2 + length,
        }
    }
}

fn word(bytes: &[u8], at: usize) -> Option<u16> {
    Some(u16::from_be_bytes([*bytes.get(at)?, *bytes.get(at + 1)?]))
}
