//! Parameters of the recorder (`config/bag_recorder.param.yaml`).

use models::params::{ParamError, in_range};
use models::units::Seconds;
use std::path::PathBuf;

/// Checked parameters. Built only from a valid [`RawParams`].
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(try_from = "RawParams")]
pub struct Params {
    /// Folder of the bag; its last component names the files.
    pub bag_dir: PathBuf,
    /// Topics that are not recorded, as declared or as resolved.
    pub leave_out: Vec<String>,
    /// Messages that wait for the writer; more are dropped and counted.
    pub queue_length: usize,
    /// Pictures are dropped where more messages than this wait: the rest gets what is left (T4).
    pub picture_queue: usize,
    /// Real time between two `fdatasync`: what a loss of power costs at most.
    pub sync_period: Seconds,
    /// A message later than this behind the newest begins a new file.
    pub late_max: Seconds,
    /// Longest wait for the first reading of simulated time.
    pub clock_wait: Seconds,
    /// Messages of a topic that wait in the middleware.
    pub reader_depth: usize,
    /// The same of a topic of pictures.
    pub image_depth: usize,
    /// Publishers with a shorter send window are listened to best effort.
    pub window_min: usize,
}

/// The parameters as they are written.
#[derive(Debug, Clone, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawParams {
    /// Folder of the bag.
    pub bag_dir: PathBuf,
    /// Topics that are not recorded.
    pub leave_out: Vec<String>,
    /// Messages that wait for the writer `[-]`, in `[1, 1000000]`.
    pub queue_length: u32,
    /// Messages that wait while pictures are still taken `[-]`, in `[1, queue_length]`.
    pub picture_queue: u32,
    /// Real time between two `fdatasync` `[s]`, in `[0.01, 60]`.
    pub sync_period_s: f64,
    /// Greatest lateness within a file `[s]`, in `[0, 60]`.
    pub late_max_s: f64,
    /// Longest wait for `/clock` `[s]`, in `[0, 60]`.
    pub clock_wait_s: f64,
    /// Messages of a topic that wait in the middleware `[-]`, in `[1, 100000]`.
    pub reader_depth: u32,
    /// The same of a topic of pictures `[-]`, in `[1, 100000]`.
    pub image_depth: u32,
    /// Shortest send window that is listened to reliably `[-]`, in `[1, 100000]`.
    pub window_min: u32,
}

/// Why the parameters of the recorder were refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RecorderParamError {
    /// A number outside of its range.
    #[error(transparent)]
    Param(#[from] ParamError),
    /// The folder has no last component to name the files by.
    #[error("bag_dir = {}: must end in a folder's name", .0.display())]
    NoName(PathBuf),
}

/// A count as the machine's own size.
fn size(count: u32) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX)
}

impl TryFrom<RawParams> for Params {
    type Error = RecorderParamError;

    fn try_from(raw: RawParams) -> Result<Self, RecorderParamError> {
        if raw.bag_dir.file_name().and_then(|name| name.to_str()).is_none() {
            return Err(RecorderParamError::NoName(raw.bag_dir));
        }
        in_range("queue_length", f64::from(raw.queue_length), "-", (1.0, 1e6))?;
        in_range("picture_queue", f64::from(raw.picture_queue), "-", (1.0, f64::from(raw.queue_length)))?;
        in_range("reader_depth", f64::from(raw.reader_depth), "-", (1.0, 1e5))?;
        in_range("image_depth", f64::from(raw.image_depth), "-", (1.0, 1e5))?;
        in_range("window_min", f64::from(raw.window_min), "-", (1.0, 1e5))?;
        Ok(Self {
            bag_dir: raw.bag_dir,
            leave_out: raw.leave_out,
            queue_length: size(raw.queue_length),
            picture_queue: size(raw.picture_queue),
            reader_depth: size(raw.reader_depth),
            image_depth: size(raw.image_depth),
            window_min: size(raw.window_min),
            sync_period: Seconds(in_range("sync_period_s", raw.sync_period_s, "s", (0.01, 60.0))?),
            late_max: Seconds(in_range("late_max_s", raw.late_max_s, "s", (0.0, 60.0))?),
            clock_wait: Seconds(in_range("clock_wait_s", raw.clock_wait_s, "s", (0.0, 60.0))?),
        })
    }
}

impl Params {
    /// Name of the bag: the last component of its folder.
    #[must_use]
    pub fn bag_name(&self) -> &str {
        self.bag_dir.file_name().and_then(|name| name.to_str()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raw() -> RawParams {
        RawParams {
            bag_dir: "bags/print".into(),
            leave_out: Vec::new(),
            queue_length: 8192,
            picture_queue: 4096,
            sync_period_s: 1.0,
            late_max_s: 1.0,
            clock_wait_s: 2.0,
            reader_depth: 1000,
            image_depth: 20,
            window_min: 100,
        }
    }

    #[test]
    fn the_folder_names_the_bag() {
        assert_eq!(Params::try_from(raw()).unwrap().bag_name(), "print");
        let error = Params::try_from(RawParams { bag_dir: "..".into(), ..raw() }).unwrap_err();
        assert_eq!(error.to_string(), "bag_dir = ..: must end in a folder's name");
    }

    #[test]
    fn numbers_outside_of_their_range_are_refused_by_name() {
        let error = Params::try_from(RawParams { sync_period_s: f64::NAN, ..raw() }).unwrap_err();
        assert!(error.to_string().starts_with("sync_period_s = NaN"), "{error}");
        assert!(Params::try_from(RawParams { queue_length: 0, ..raw() }).is_err());
        assert!(Params::try_from(RawParams { picture_queue: 8193, ..raw() }).is_err());
    }
}
