//! Every number of the node, as in `config/camera.param.yaml`.

use models::params::{ParamError, frame_name, in_range, ordered};
use serde::Deserialize;

use crate::url::{Url, UrlError};

/// What may change while the node is active: how many frames are let through. Size and scale tell what a pixel is: who
/// measures in frames has to begin anew with them.
pub const LIVE: [&str; 1] = ["camera.rate_max_hz"];

/// All parameters.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawParams")]
pub struct Params {
    /// Where the frames come from.
    pub driver: Driver,
    /// A folder of pictures, for the driver `folder`.
    pub folder: FolderParams,
    /// A video file, device or stream, for the driver `video`.
    pub video: VideoParams,
    /// An MJPEG stream over HTTP, for the driver `mjpeg`.
    pub mjpeg: MjpegParams,
    /// The camera itself.
    pub camera: CameraParams,
}

/// As [`Params`], as they are written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "as the checked struct")]
pub struct RawParams {
    pub driver: Driver,
    pub folder: FolderParams,
    pub video: VideoParams,
    pub mjpeg: MjpegParams,
    pub camera: CameraParams,
}

impl TryFrom<RawParams> for Params {
    type Error = CameraParamError;

    fn try_from(raw: RawParams) -> Result<Self, CameraParamError> {
        if raw.driver == Driver::Folder && raw.folder.path.is_empty() {
            return Err(CameraParamError::NoFolder);
        }
        let RawParams { driver, folder, video, mjpeg, camera } = raw;
        Ok(Self { driver, folder, video, mjpeg, camera })
    }
}

/// Where the frames come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Driver {
    /// Frames of the printer, over a topic: from a bridge or the simulator.
    Printer,
    /// Picture files of a folder, in the order of their names.
    Folder,
    /// A video file, a V4L2 device or an RTSP stream, through OpenCV.
    Video,
    /// MJPEG over HTTP.
    Mjpeg,
}

/// A folder of pictures.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FolderParams {
    /// The folder.
    pub path: String,
    /// Begin again after the last picture.
    pub repeat: bool,
}

/// A source that OpenCV reads.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawVideoParams")]
pub struct VideoParams {
    /// What is opened.
    pub source: VideoSource,
    /// Begin again after the last frame of a file.
    pub repeat: bool,
    /// First pause after the source was lost `[s]`; it doubles with each try.
    pub retry_min_s: f64,
    /// Longest pause `[s]`.
    pub retry_max_s: f64,
}

/// What OpenCV opens, and with what.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum VideoSource {
    /// A file, with FFmpeg.
    File(String),
    /// A device file, with V4L2.
    Device(String),
    /// A stream, with FFmpeg.
    Rtsp(String),
}

impl VideoSource {
    /// FFmpeg knows many schemes, some of which read or reach what nobody meant: only `rtsp://` and plain paths pass.
    fn parse(text: &str) -> Option<Self> {
        let owned = text.to_owned();
        if text.starts_with("rtsp://") {
            Some(Self::Rtsp(owned))
        } else if text.starts_with("/dev/") {
            Some(Self::Device(owned))
        } else {
            // A path may hold a colon behind a slash: `concat:a` is none, `./concat:a` is.
            let scheme = text.split('/').next().is_some_and(|first| first.contains(':'));
            (!scheme && !text.contains('%')).then_some(Self::File(owned))
        }
    }
}

/// As [`VideoParams`], as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "as the checked struct")]
pub struct RawVideoParams {
    pub source: String,
    pub repeat: bool,
    pub retry_min_s: f64,
    pub retry_max_s: f64,
}

/// A parameter that was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CameraParamError {
    /// A number.
    #[error(transparent)]
    Number(#[from] ParamError),
    /// An address.
    #[error("url = {0}")]
    Url(#[from] UrlError),
    /// The driver `folder` without its folder.
    #[error("folder.path = '': must name a folder, for driver = folder")]
    NoFolder,
    /// A video source.
    #[error("source = {0}: must be a path, a /dev/video file or rtsp://")]
    Source(String),
}

impl TryFrom<RawVideoParams> for VideoParams {
    type Error = CameraParamError;

    fn try_from(raw: RawVideoParams) -> Result<Self, CameraParamError> {
        let (retry_min_s, retry_max_s) = retry(raw.retry_min_s, raw.retry_max_s)?;
        let source = VideoSource::parse(&raw.source).ok_or(CameraParamError::Source(raw.source))?;
        Ok(Self { source, repeat: raw.repeat, retry_min_s, retry_max_s })
    }
}

/// An MJPEG stream.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawMjpegParams")]
pub struct MjpegParams {
    /// Its address.
    pub url: Url,
    /// Longest time until the head of the answer is complete `[s]`.
    pub answer_max_s: f64,
    /// Longest time from one frame to the next `[s]`, however many bytes come in between.
    pub frame_max_s: f64,
    /// First pause after the stream was lost `[s]`; it doubles with each try.
    pub retry_min_s: f64,
    /// Longest pause `[s]`.
    pub retry_max_s: f64,
}

/// As [`MjpegParams`], as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "as the checked struct")]
pub struct RawMjpegParams {
    pub url: String,
    pub answer_max_s: f64,
    pub frame_max_s: f64,
    pub retry_min_s: f64,
    pub retry_max_s: f64,
}

impl TryFrom<RawMjpegParams> for MjpegParams {
    type Error = CameraParamError;

    fn try_from(raw: RawMjpegParams) -> Result<Self, CameraParamError> {
        let (retry_min_s, retry_max_s) = retry(raw.retry_min_s, raw.retry_max_s)?;
        Ok(Self {
            url: Url::parse(&raw.url)?,
            answer_max_s: in_range("answer_max_s", raw.answer_max_s, "s", (0.1, 60.0))?,
            frame_max_s: in_range("frame_max_s", raw.frame_max_s, "s", (0.1, 600.0))?,
            retry_min_s,
            retry_max_s,
        })
    }
}

fn retry(min_s: f64, max_s: f64) -> Result<(f64, f64), ParamError> {
    ordered(("retry_min_s", min_s), ("retry_max_s", max_s))?;
    let bounded = |name, value, high| in_range(name, value, "s", (0.01, high));
    Ok((bounded("retry_min_s", min_s, 60.0)?, bounded("retry_max_s", max_s, 600.0)?))
}

/// The camera: size, scale, rate, and how stale a frame may be.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawCameraParams")]
pub struct CameraParams {
    /// Optical frame.
    pub frame: String,
    /// Columns of every frame `[px]`.
    pub width_px: u32,
    /// Rows of every frame `[px]`.
    pub height_px: u32,
    /// Length on the bed per pixel `[m]`.
    pub scale_m: f64,
    /// From lens to nozzle tip `[m]`.
    pub working_distance_m: f64,
    /// Frames a second `[Hz]`; the pace at which files are played.
    pub rate_hz: f64,
    /// Frames a second beyond which frames are left out `[Hz]`.
    pub rate_max_hz: f64,
    /// Quality of frames that are no JPEG yet `[1, 100]`.
    pub jpeg_quality: u8,
    /// How far ahead of the clock a stamp may be `[s]`.
    pub stamp_future_max_s: f64,
    /// How old a frame may be `[s]`.
    pub stamp_age_max_s: f64,
    /// Silence after which the camera counts as lost `[s]`.
    pub lost_after_s: f64,
}

/// As [`CameraParams`], as it is written.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "as the checked struct")]
pub struct RawCameraParams {
    pub frame: String,
    pub width_px: u32,
    pub height_px: u32,
    pub scale_m: f64,
    pub working_distance_m: f64,
    pub rate_hz: f64,
    pub rate_max_hz: f64,
    pub jpeg_quality: u8,
    pub stamp_future_max_s: f64,
    pub stamp_age_max_s: f64,
    pub lost_after_s: f64,
}

/// A whole number in a range.
fn whole<T: Copy + Into<f64>>(
    name: &'static str,
    value: T,
    unit: &'static str,
    range: (f64, f64),
) -> Result<T, ParamError> {
    in_range(name, value.into(), unit, range).map(|_| value)
}

impl TryFrom<RawCameraParams> for CameraParams {
    type Error = ParamError;

    fn try_from(raw: RawCameraParams) -> Result<Self, ParamError> {
        let rate_hz = in_range("rate_hz", raw.rate_hz, "Hz", (0.01, 120.0))?;
        Ok(Self {
            frame: frame_name("frame", raw.frame)?,
            width_px: whole("width_px", raw.width_px, "px", (64.0, 4096.0))?,
            height_px: whole("height_px", raw.height_px, "px", (64.0, 4096.0))?,
            scale_m: in_range("scale_m", raw.scale_m, "m", (5e-6, 1e-2))?,
            working_distance_m: in_range("working_distance_m", raw.working_distance_m, "m", (5e-3, 5.0))?,
            rate_hz,
            rate_max_hz: in_range("rate_max_hz", raw.rate_max_hz, "Hz", (rate_hz, 120.0))?,
            jpeg_quality: whole("jpeg_quality", raw.jpeg_quality, "-", (1.0, 100.0))?,
            stamp_future_max_s: in_range("stamp_future_max_s", raw.stamp_future_max_s, "s", (0.0, 10.0))?,
            stamp_age_max_s: in_range("stamp_age_max_s", raw.stamp_age_max_s, "s", (0.01, 60.0))?,
            lost_after_s: in_range("lost_after_s", raw.lost_after_s, "s", (0.05, 600.0))?,
        })
    }
}

impl CameraParams {
    /// Row-major intrinsic matrix of a camera that looks straight down: `fx = fy = working_distance / scale`, the
    /// principal point in the middle, pixel centres being whole `[px]`.
    #[must_use]
    pub fn intrinsics(&self) -> [f64; 9] {
        let focal_px = self.working_distance_m / self.scale_m;
        let middle = |side: u32| (f64::from(side) - 1.0) / 2.0;
        [focal_px, 0.0, middle(self.width_px), 0.0, focal_px, middle(self.height_px), 0.0, 0.0, 1.0]
    }
}

#[cfg(test)]
mod tests;
