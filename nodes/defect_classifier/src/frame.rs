//! From a JPEG to a grey picture that can be judged, or the reason why not (faults.md, S8 and S9).
//!
//! What the header says is checked before anything is decoded: a short file can announce a huge picture.

mod header;
#[cfg(test)]
mod live_tests;
#[cfg(test)]
pub(crate) mod tests;
pub(crate) mod whole;

pub use header::{JpegSize, jpeg_size};

use crate::camera::Camera;
use models::params::{ParamError, in_range};
use opencv::core::{CV_64F, Mat, MatTraitConst, MatTraitConstManual, Scalar, Size, mean_std_dev_def};
use opencv::imgproc;
use serde::Deserialize;
use std::hash::{DefaultHasher, Hasher};
use whole::{before_end, luma};

/// What may change while the node is active: when the light is good enough to judge a frame. Evidence, confirmation and
/// measurement are chosen together: they decide over a pause, and may change while the node is inactive.
pub const LIVE: [&str; 4] =
    ["checks.black_grey", "checks.saturated_grey", "checks.saturated_share", "checks.sharpness_min"];

/// Bounds of a usable frame. Built only from a valid [`RawChecks`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawChecks")]
pub struct FrameChecks(RawChecks);

/// The `checks` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawChecks {
    /// Largest file `[byte]`.
    pub bytes_max: u32,
    /// Largest picture `[px]`.
    pub pixels_max: u32,
    /// A darker mean is black `[grey]`.
    pub black_grey: f64,
    /// From this level on a pixel counts as saturated `[grey]`.
    pub saturated_grey: f64,
    /// Largest share of saturated pixels `[-]`.
    pub saturated_share: f64,
    /// Standard deviation of the blur before sharpness is measured, so that noise is not taken for it `[px]`.
    pub sharpness_blur_px: f64,
    /// Least variance of the Laplacian over the variance of the picture `[-]`.
    pub sharpness_min: f64,
}

impl TryFrom<RawChecks> for FrameChecks {
    type Error = ParamError;

    fn try_from(raw: RawChecks) -> Result<Self, ParamError> {
        in_range("checks.bytes_max", f64::from(raw.bytes_max), "byte", (1024.0, 4_194_304.0))?;
        in_range("checks.pixels_max", f64::from(raw.pixels_max), "px", (4096.0, 8e6))?;
        in_range("checks.black_grey", raw.black_grey, "grey", (0.0, 255.0))?;
        in_range("checks.saturated_grey", raw.saturated_grey, "grey", (1.0, 255.0))?;
        in_range("checks.saturated_share", raw.saturated_share, "-", (0.0, 1.0))?;
        in_range("checks.sharpness_blur_px", raw.sharpness_blur_px, "px", (0.1, 20.0))?;
        in_range("checks.sharpness_min", raw.sharpness_min, "-", (0.0, 10.0))?;
        Ok(Self(raw))
    }
}

/// Why a frame cannot be judged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Unusable {
    /// No JPEG, or one whose header is cut short.
    #[error("no JPEG with a size in its header")]
    NotJpeg,
    /// More bytes or pixels than allowed.
    #[error("{found} {unit}, more than the {limit} allowed")]
    TooLarge {
        /// What the frame has.
        found: u64,
        /// What it may have.
        limit: u64,
        /// Bytes or pixels.
        unit: &'static str,
    },
    /// Not the size that the calibration is for.
    #[error("{width_px} x {height_px} px, not the size of the calibration")]
    WrongSize {
        /// Width in the header `[px]`.
        width_px: u16,
        /// Height in the header `[px]`.
        height_px: u16,
    },
    /// The decoder gave up.
    #[error("the JPEG cannot be decoded")]
    Corrupt,
    /// Byte for byte the frame before.
    #[error("frozen: the same frame again")]
    Frozen,
    /// Lights off, lens covered.
    #[error("black: mean grey {mean_grey:.1}")]
    Black {
        /// Mean level `[grey]`.
        mean_grey: f64,
    },
    /// Overexposed.
    #[error("saturated: {share:.2} of the pixels")]
    Saturated {
        /// Share of saturated pixels `[-]`.
        share: f64,
    },
    /// Out of focus, or nothing to focus on.
    #[error("out of focus: sharpness {sharpness:.5}")]
    Blurred {
        /// Variance of the Laplacian over that of the picture `[-]`.
        sharpness: f64,
    },
    /// Where the tool was at the exposure is not known.
    #[error("the tool's place at the exposure is not known")]
    NoPlace,
    /// Nothing is being printed.
    #[error("nothing is being printed")]
    NotPrinting,
    /// Exposed before the frame before, or at no time.
    #[error("not later than the frame before")]
    Order,
    /// A picture operation failed.
    #[error("picture operation failed")]
    Failed,
}

impl From<opencv::Error> for Unusable {
    fn from(_: opencv::Error) -> Self {
        Self::Failed
    }
}

/// Checks frames one after the other.
#[derive(Debug, Clone)]
pub struct FrameGate {
    checks: FrameChecks,
    size_px: (u16, u16),
    last: Option<u64>,
}

impl FrameGate {
    /// A gate that has seen nothing.
    #[must_use]
    pub fn new(checks: FrameChecks, camera: &Camera) -> Self {
        Self { checks, size_px: (camera.width_px, camera.height_px), last: None }
    }

    /// Other bounds of what can be judged from now on.
    pub fn retune(&mut self, checks: FrameChecks) {
        self.checks = checks;
    }

    /// The grey picture of a frame that can be judged.
    ///
    /// # Errors
    /// The reason why it cannot.
    pub fn open(&mut self, jpeg: &[u8]) -> Result<Mat, Unusable> {
        let checks = self.checks.0;
        let bytes = u64::try_from(jpeg.len()).unwrap_or(u64::MAX);
        if bytes > u64::from(checks.bytes_max) {
            let limit = u64::from(checks.bytes_max);
            return Err(Unusable::TooLarge { found: bytes, limit, unit: "byte" });
        }
        let JpegSize { width_px, height_px } = jpeg_size(jpeg).ok_or(Unusable::NotJpeg)?;
        let pixels = u64::from(width_px) * u64::from(height_px);
        if pixels > u64::from(checks.pixels_max) {
            return Err(Unusable::TooLarge {
                found: pixels,
                limit: u64::from(checks.pixels_max),
                unit: "px",
            });
        }
        if (width_px, height_px) != self.size_px {
            return Err(Unusable::WrongSize { width_px, height_px });
        }
        let before_end = before_end(jpeg).ok_or(Unusable::Corrupt)?;
        let mut hasher = DefaultHasher::new();
        hasher.write(before_end);
        let hash = hasher.finish();
        if self.last.replace(hash) == Some(hash) {
            return Err(Unusable::Frozen);
        }
        let luma = luma(before_end)
            .filter(|luma| u64::try_from(luma.len()) == Ok(pixels))
            .ok_or(Unusable::Corrupt)?;
        let grey = Mat::new_rows_cols_with_data(i32::from(height_px), i32::from(width_px), &luma)?;
        let grey = grey.try_clone()?;
        self.look(&grey)?;
        Ok(grey)
    }

    /// Light and focus.
    fn look(&self, grey: &Mat) -> Result<(), Unusable> {
        let checks = &self.checks.0;
        let (mean_grey, spread_grey) = spread(grey)?;
        if mean_grey < checks.black_grey {
            return Err(Unusable::Black { mean_grey });
        }
        let bytes = grey.data_bytes()?;
        let bright = bytes.iter().filter(|level| f64::from(**level) >= checks.saturated_grey).count();
        #[expect(clippy::cast_precision_loss, reason = "pixels are far below 2^52")]
        let share = bright as f64 / bytes.len() as f64;
        if share > checks.saturated_share {
            return Err(Unusable::Saturated { share });
        }
        let (mut small, mut smooth, mut edges) = (Mat::default(), Mat::default(), Mat::default());
        let half = Size::new(grey.cols() / 2, grey.rows() / 2);
        imgproc::resize(grey, &mut small, half, 0.0, 0.0, imgproc::INTER_AREA)?;
        imgproc::gaussian_blur_def(&small, &mut smooth, Size::default(), checks.sharpness_blur_px / 2.0)?;
        imgproc::laplacian_def(&smooth, &mut edges, CV_64F)?;
        let (_, edge_grey) = spread(&edges)?;
        let sharpness = (edge_grey / spread_grey.max(1.0)).powi(2);
        if sharpness < checks.sharpness_min { Err(Unusable::Blurred { sharpness }) } else { Ok(()) }
    }
}

/// Mean and standard deviation of a picture of one channel.
fn spread(picture: &Mat) -> Result<(f64, f64), opencv::Error> {
    let (mut mean, mut deviation) = (Scalar::default(), Scalar::default());
    mean_std_dev_def(picture, &mut mean, &mut deviation)?;
    Ok((mean[0], deviation[0]))
}
