//! Pictures that are no JPEG yet become one, by OpenCV on one thread.

use opencv::core::{Mat, Vector, set_num_threads};
use opencv::imgcodecs::{IMREAD_COLOR, IMREAD_GRAYSCALE, IMWRITE_JPEG_QUALITY, imdecode, imencode};
use opencv::prelude::*;

use crate::picture::Header;

/// One thread for each call of OpenCV: a camera must not take the cores of the control path.
pub(crate) fn one_thread() {
    drop(set_num_threads(1));
}

/// A picture of OpenCV as a JPEG file.
pub(crate) fn to_jpeg(picture: &Mat, quality: u8) -> Result<Vec<u8>, String> {
    let mut jpeg = Vector::<u8>::new();
    let quality = Vector::from_slice(&[IMWRITE_JPEG_QUALITY, i32::from(quality)]);
    match imencode(".jpg", picture, &mut jpeg, &quality) {
        Ok(true) => Ok(jpeg.to_vec()),
        Ok(false) => Err("the picture cannot be encoded".into()),
        Err(error) => Err(error.to_string()),
    }
}

/// A file whose header was read, and found bounded, as a JPEG file.
pub(crate) fn decoded_to_jpeg(file: &[u8], header: Header, quality: u8) -> Result<Vec<u8>, String> {
    let mode = if header.components == 1 { IMREAD_GRAYSCALE } else { IMREAD_COLOR };
    let bytes = Mat::from_slice(file).map_err(|error| error.to_string())?;
    let picture = imdecode(&bytes, mode).map_err(|error| error.to_string())?;
    if picture.empty() {
        return Err("the picture cannot be decoded".into());
    }
    to_jpeg(&picture, quality)
}
