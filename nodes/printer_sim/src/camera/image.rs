//! A grey picture, and its JPEG.

use jpeg_encoder::{ColorType, Encoder, EncodingError};

/// A grey picture of eight bits, row by row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Frame {
    /// Width `[px]`.
    pub width_px: usize,
    /// Height `[px]`.
    pub height_px: usize,
    /// Grey levels, `width_px * height_px` of them.
    pub grey: Vec<u8>,
}

/// Why a frame did not become a JPEG.
#[derive(Debug, thiserror::Error)]
#[error("JPEG of {width_px} x {height_px} pixels: {source}")]
pub struct JpegError {
    width_px: usize,
    height_px: usize,
    source: EncodingError,
}

impl Frame {
    /// The frame as baseline JPEG (`mono8`), quality in `[1, 100]`.
    ///
    /// # Errors
    /// [`JpegError`] for a picture that the format cannot hold.
    pub fn jpeg(&self, quality: u8) -> Result<Vec<u8>, JpegError> {
        let side = |pixels: usize| u16::try_from(pixels).unwrap_or(0);
        let mut bytes = Vec::with_capacity(self.grey.len() / 2);
        Encoder::new(&mut bytes, quality)
            .encode(&self.grey, side(self.width_px), side(self.height_px), ColorType::Luma)
            .map_err(|source| JpegError { width_px: self.width_px, height_px: self.height_px, source })?;
        Ok(bytes)
    }
}
