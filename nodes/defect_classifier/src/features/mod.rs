//! What a network looks at: numbers taken from a grey picture, and what is known of the frame from elsewhere.
//!
//! The picture is cut to 4:3 around its middle and reduced to a fixed size, so that a feature means the same whatever
//! the camera's resolution. Energies are relative to the picture's own variance and angles to its own main direction:
//! exposure and the way the roads run should not matter.

mod brightness;
mod edges;
mod gradient;
pub(crate) mod picture;
mod spectrum;
mod strands;
#[cfg(test)]
mod tests;
mod texture;

use crate::frame::whole::is_whole_file;
use opencv::core::{Mat, MatTraitConst};
use opencv::imgcodecs;
use picture::Picture;

/// Features of the picture.
const PICTURE: usize = brightness::NAMES.len()
    + gradient::NAMES.len()
    + edges::NAMES.len()
    + texture::NAMES.len()
    + spectrum::NAMES.len()
    + strands::NAMES.len();
/// Features of [`Measured`].
const MEASURED: [&str; 4] = ["width_known", "width_error", "offset_known", "offset_mm"];
/// Number of all features.
pub const COUNT: usize = PICTURE + MEASURED.len();

/// What was measured in the frame apart from the features; all unknown by default.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measured {
    /// Road width over the wanted one less one `[-]`, corrections of the flow taken out.
    pub width_error_rel: Option<f64>,
    /// What widths together lie above the wanted or usual one, below 0 below it, beyond a slack `[-]`.
    pub width_drift_rel: Option<f64>,
    /// Offset of the layers below, bed x and y `[m]`.
    pub offset_m: Option<[f64; 2]>,
    /// Share of the strong edges in the picture that no commanded road explains `[0, 1]`.
    pub unexplained: Option<f64>,
    /// How far readings of seams together keep darker than usual, in standard deviations `[-]`, 0 or more.
    pub seam_drift_sigmas: Option<f64>,
}

/// Radius of the disc around the middle that shows the head, as share of the picture's height `[0, 0.5]`; 0 for none.
/// What it hides is made even before anything is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Hidden(pub f64);

impl Measured {
    /// Every known value is a number.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let offset = self.offset_m.is_none_or(|offset| offset.iter().all(|value| value.is_finite()));
        offset
            && [self.width_error_rel, self.width_drift_rel, self.unexplained, self.seam_drift_sigmas]
                .iter()
                .flatten()
                .all(|value| value.is_finite())
    }
}

/// Why a picture has no features.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FeatureError {
    /// Not 8 bits in one channel, or smaller than a thumbnail.
    #[error(
        "picture of {width} x {height} pixels, OpenCV type {kind}: needs 8 bit grey of {least} x {least} or more"
    )]
    Picture {
        /// Width `[px]`.
        width: i32,
        /// Height `[px]`.
        height: i32,
        /// OpenCV's type number.
        kind: i32,
        /// Least side `[px]`.
        least: i32,
    },
    /// A measured value is not finite.
    #[error("measured {0} is not finite")]
    Measured(&'static str),
    /// Bytes that are no picture.
    #[error("{0} bytes that OpenCV cannot decode as a picture")]
    Encoded(usize),
    /// A JPEG that was cut off or damaged.
    #[error(
        "{0} bytes of a JPEG that ends before its picture does, is damaged, or is coded in a way that is not read"
    )]
    Cut(usize),
    /// OpenCV refused.
    #[error("OpenCV: {0}")]
    OpenCv(#[from] opencv::Error),
}

/// Names of the features in their order.
#[must_use]
pub fn names() -> Vec<&'static str> {
    let blocks: [&[&'static str]; 7] = [
        &brightness::NAMES,
        &gradient::NAMES,
        &edges::NAMES,
        &texture::NAMES,
        &spectrum::NAMES,
        &strands::NAMES,
        &MEASURED,
    ];
    blocks.concat()
}

/// Features of a picture, [`COUNT`] finite numbers in the order of [`names`].
///
/// # Errors
/// [`FeatureError`] for a picture that is not 8 bit grey or too small, and for measured values that are not finite.
pub fn extract(grey: &Mat, hidden: Hidden, measured: &Measured) -> Result<Vec<f64>, FeatureError> {
    let picture = Picture::of(grey, hidden)?;
    let mut values = Vec::with_capacity(COUNT);
    values.extend(brightness::of(&picture));
    values.extend(gradient::of(&picture));
    values.extend(edges::of(&picture)?);
    values.extend(texture::of(&picture));
    values.extend(spectrum::of(&picture)?);
    values.extend(strands::of(&picture)?);
    values.extend(known(measured)?);
    Ok(values)
}

/// Features of an encoded picture (JPEG, PNG), reduced to grey. For files of a trusted person: a camera's frames are
/// checked for size before they are decoded.
///
/// # Errors
/// As [`extract`], and bytes that are no picture, or a part of one.
pub fn extract_encoded(bytes: &[u8], hidden: Hidden, measured: &Measured) -> Result<Vec<f64>, FeatureError> {
    extract(&decode(bytes)?, hidden, measured)
}

/// An encoded picture (JPEG, PNG), reduced to grey.
///
/// # Errors
/// Bytes that are no picture, or a part of one.
pub fn decode(bytes: &[u8]) -> Result<Mat, FeatureError> {
    if bytes.starts_with(&[0xff, 0xd8]) && !is_whole_file(bytes) {
        return Err(FeatureError::Cut(bytes.len()));
    }
    let grey = imgcodecs::imdecode(&Mat::from_slice(bytes)?, imgcodecs::IMREAD_GRAYSCALE)?;
    if grey.empty() {
        return Err(FeatureError::Encoded(bytes.len()));
    }
    Ok(grey)
}

/// Each value after a flag that says whether it is known.
fn known(measured: &Measured) -> Result<[f64; 4], FeatureError> {
    let finite = |name: &'static str, value: f64| {
        if value.is_finite() { Ok(value) } else { Err(FeatureError::Measured(name)) }
    };
    let mut values = [0.0; 4];
    if let Some(width_error_rel) = measured.width_error_rel {
        values[..2].copy_from_slice(&[1.0, finite("width_error_rel", width_error_rel)?]);
    }
    if let Some([x_m, y_m]) = measured.offset_m {
        values[2..].copy_from_slice(&[1.0, 1e3 * finite("offset_m", x_m.hypot(y_m))?]);
    }
    Ok(values)
}
