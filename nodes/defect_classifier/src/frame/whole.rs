//! Whether a JPEG holds its picture to the last row: OpenCV draws what is missing in grey and calls it well.

use super::header::is_progressive;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// The marker that ends a picture.
const END: [u8; 2] = [0xff, 0xd9];

/// What lies before the end marker; none where there is no such marker. Some cameras fill up with zeros behind it.
pub(super) fn before_end(jpeg: &[u8]) -> Option<&[u8]> {
    let filled = jpeg.iter().rev().take_while(|byte| **byte == 0).count();
    jpeg[..jpeg.len() - filled].strip_suffix(&END)
}

/// Grey levels row by row, where the rows of blocks are there to the last. This decoder is strict where the data ends, but
/// believes an end marker: it gets what lies before it.
pub(super) fn luma(before_end: &[u8]) -> Option<Vec<u8>> {
    let options = DecoderOptions::default().set_strict_mode(true).jpeg_set_out_colorspace(ColorSpace::Luma);
    JpegDecoder::new_with_options(ZCursor::new(before_end), options).decode().ok()
}

/// The same for a file of a person: what a phone appends behind the picture is left alone. Of a progressive picture the end
/// marker stays, as its decoder looks for it.
pub(crate) fn is_whole_file(jpeg: &[u8]) -> bool {
    let Some(at) = jpeg.windows(END.len()).rposition(|pair| pair == END) else { return false };
    luma(if is_progressive(jpeg) { &jpeg[..at + END.len()] } else { &jpeg[..at] }).is_some()
}
