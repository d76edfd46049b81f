//! Video files (FFmpeg), devices (V4L2) and RTSP streams (FFmpeg), read by OpenCV.
//!
//! `VideoCapture` answers `Ok` for what it could not open: `is_opened` is what counts. RTSP and V4L2 take the same
//! path as files, but no test reads them: there is neither a server nor a device to read from.

use std::path::Path;

use opencv::core::{CV_8UC1, Mat, Vector};
use opencv::prelude::*;
use opencv::videoio::{
    CAP_FFMPEG, CAP_PROP_CONVERT_RGB, CAP_PROP_FOURCC, CAP_PROP_FPS, CAP_PROP_FRAME_HEIGHT,
    CAP_PROP_FRAME_WIDTH, CAP_PROP_OPEN_TIMEOUT_MSEC, CAP_PROP_READ_TIMEOUT_MSEC, CAP_V4L2, VideoCapture,
    VideoWriter,
};

use super::driver::{BackOff, DriverEvent};
use super::encode::{one_thread, to_jpeg};
use crate::params::{CameraParams, VideoParams, VideoSource};
use crate::picture::Header;

/// Longest wait for an RTSP server, to open and to read `[ms]`.
const RTSP_WAIT_MS: i32 = 5000;

/// Reads a video.
pub struct Video {
    params: VideoParams,
    camera: CameraParams,
    back_off: BackOff,
    capture: Option<VideoCapture>,
    frames: u64,
}

impl std::fmt::Debug for Video {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Video")
            .field("params", &self.params)
            .field("frames", &self.frames)
            .finish_non_exhaustive()
    }
}

impl Video {
    /// Nothing is opened before the first [`Video::next_event`].
    #[must_use]
    pub fn new(params: VideoParams, camera: CameraParams) -> Self {
        one_thread();
        let back_off = BackOff::new(params.retry_min_s, params.retry_max_s);
        Self { params, camera, back_off, capture: None, frames: 0 }
    }

    /// The next event. Waits for a device or a server.
    pub fn next_event(&mut self) -> DriverEvent {
        let Some(capture) = &mut self.capture else {
            return match open(&self.params.source, &self.camera) {
                Ok((capture, text)) => {
                    (self.capture, self.frames) = (Some(capture), 0);
                    DriverEvent::Found { text }
                }
                Err(reason) => self.back_off.lost(reason),
            };
        };
        let mut picture = Mat::default();
        match capture.read(&mut picture) {
            Ok(true) if !picture.empty() => self.frame(&picture),
            Ok(_) => self.end(),
            Err(error) => self.lose(error.to_string()),
        }
    }

    fn frame(&mut self, picture: &Mat) -> DriverEvent {
        self.frames += 1;
        self.back_off.reset();
        if let Some(jpeg) = compressed(picture) {
            return DriverEvent::Frame(jpeg);
        }
        match to_jpeg(picture, self.camera.jpeg_quality) {
            Ok(jpeg) => DriverEvent::Frame(jpeg),
            Err(reason) => self.lose(reason),
        }
    }

    fn end(&mut self) -> DriverEvent {
        match &self.params.source {
            VideoSource::File(path) if self.frames == 0 => {
                let reason = format!("{path}: no frame can be read");
                self.lose(reason)
            }
            VideoSource::File(_) if self.params.repeat => {
                self.capture = None;
                self.next_event()
            }
            VideoSource::File(_) => DriverEvent::Ended,
            VideoSource::Device(name) | VideoSource::Rtsp(name) => {
                let reason = format!("{name} gives no more frames");
                self.lose(reason)
            }
        }
    }

    fn lose(&mut self, reason: String) -> DriverEvent {
        self.capture = None;
        self.back_off.lost(reason)
    }
}

/// A device that is not asked to convert gives the camera's own JPEG file as one row of bytes.
fn compressed(picture: &Mat) -> Option<Vec<u8>> {
    let bytes = (picture.rows() == 1 && picture.typ() == CV_8UC1).then(|| picture.data_bytes().ok())??;
    bytes.starts_with(&[0xff, 0xd8, 0xff]).then(|| bytes.to_vec())
}

fn open(source: &VideoSource, camera: &CameraParams) -> Result<(VideoCapture, String), String> {
    let (name, backend, properties) = match source {
        VideoSource::File(path) => {
            if !Path::new(path).is_file() {
                return Err(format!("{path} is no file"));
            }
            (path, CAP_FFMPEG, vec![])
        }
        VideoSource::Rtsp(url) => (
            url,
            CAP_FFMPEG,
            vec![CAP_PROP_OPEN_TIMEOUT_MSEC, RTSP_WAIT_MS, CAP_PROP_READ_TIMEOUT_MSEC, RTSP_WAIT_MS],
        ),
        VideoSource::Device(path) => (path, CAP_V4L2, device_properties(camera)?),
    };
    let capture = VideoCapture::from_file_with_params(name, backend, &Vector::from_slice(&properties))
        .map_err(|error| error.to_string())?;
    if !capture.is_opened().map_err(|error| error.to_string())? {
        return Err(format!("{name} cannot be opened as a video"));
    }
    let figure = |property| capture.get(property).unwrap_or(0.0);
    let (width, height) = (figure(CAP_PROP_FRAME_WIDTH), figure(CAP_PROP_FRAME_HEIGHT));
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates: is bounded or not"
    )]
    let header = Header { width_px: width as u32, height_px: height as u32, components: 3 };
    if !header.bounded() {
        return Err(format!("{name}: frames of {width}x{height} px are not read"));
    }
    let text = format!("{name}: {width}x{height} px, {:.1} frames a second", figure(CAP_PROP_FPS));
    Ok((capture, text))
}

/// The camera's own JPEG files, of the configured size and rate.
fn device_properties(camera: &CameraParams) -> Result<Vec<i32>, String> {
    let motion_jpeg = VideoWriter::fourcc('M', 'J', 'P', 'G').map_err(|error| error.to_string())?;
    #[allow(clippy::cast_possible_wrap, clippy::cast_possible_truncation, reason = "at most 4096 and 120")]
    let (width, height, rate) =
        (camera.width_px as i32, camera.height_px as i32, camera.rate_hz.ceil() as i32);
    Ok(vec![
        CAP_PROP_FOURCC,
        motion_jpeg,
        CAP_PROP_FRAME_WIDTH,
        width,
        CAP_PROP_FRAME_HEIGHT,
        height,
        CAP_PROP_FPS,
        rate,
        CAP_PROP_CONVERT_RGB,
        0,
    ])
}
