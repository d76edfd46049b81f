//! Parameters of the recorder (`config/bag_recorder.param.yaml`).

use crate::order::nanoseconds;
use models::params::{ParamError, in_range};
use models::units::Seconds;
use std::path::PathBuf;

/// What may change while the node is active: when a file ends, and which are kept. Topics, folder and depths are opened
/// once.
pub const LIVE: [&str; 3] = ["split_s", "split_mib", "keep_severity"];

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
    /// Topics that are recorded, as declared or as resolved; none named: all.
    pub topics: Vec<String>,
    /// Nothing is written until somebody asks for it.
    pub start_paused: bool,
    /// When a file ends and the next begins.
    pub split: Split,
    /// What may be dropped for room.
    pub room: Room,
    /// What is kept in memory while nothing is written.
    pub snapshot: Snapshot,
    /// Real time at the end that may go into compacting the last file.
    pub compact_end: Seconds,
}

/// When a file ends and the next begins; `None`: never.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Split {
    /// Log time that a file spans `[ns]`.
    pub span_ns: Option<u64>,
    /// Size of a file `[byte]`.
    pub bytes: Option<u64>,
}

/// What may be dropped for room.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Room {
    /// Most that the bag's files may take `[byte]`; `None`: what the disk has.
    pub bag_bytes: Option<u64>,
    /// Least that stays free on the disk `[byte]`.
    pub free_bytes: u64,
    /// Files with an event of this severity or a higher one, and the file before it, are never dropped.
    pub keep_severity: u8,
}

/// What is kept in memory while nothing is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Snapshot {
    /// Log time that it reaches back `[ns]`; 0: nothing is kept.
    pub span_ns: u64,
    /// Memory that it may take `[byte]`.
    pub bytes: usize,
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
    /// Topics that are recorded; none named: all.
    pub topics: Vec<String>,
    /// Nothing is written until `~/resume`, `~/record` or `~/snapshot` is called.
    pub start_paused: bool,
    /// Log time that a file spans `[s]`, in `[0, 1e6]`; 0: without limit.
    pub split_s: f64,
    /// Size of a file `[MiB]`, in `[0, 1e6]`; 0: without limit.
    pub split_mib: u32,
    /// Most that the bag's files take `[MiB]`, in `[split_mib, 1e8]`; 0: what the disk has.
    pub bag_mib: u32,
    /// Least that stays free on the disk `[MiB]`, in `[0, 1e8]`.
    pub disk_free_mib: u32,
    /// Files with an event of this severity, or higher, are kept `[-]`, in `[0, 3]`; 3: none is.
    pub keep_severity: u8,
    /// Log time that is kept in memory while nothing is written `[s]`, in `[0, 600]`; 0: none.
    pub snapshot_s: f64,
    /// Memory for it `[MiB]`, in `[1, 1000]`.
    pub snapshot_mib: u32,
    /// Real time at the end for compacting the last file `[s]`, in `[0, 1]`.
    pub compact_end_s: f64,
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

/// Bytes of a mebibyte.
const MIB: u64 = 1 << 20;

/// A limit in bytes; 0 is none.
fn limit(name: &'static str, mib: u32, high: f64) -> Result<Option<u64>, ParamError> {
    in_range(name, f64::from(mib), "MiB", (0.0, high))?;
    Ok((mib > 0).then(|| u64::from(mib) * MIB))
}

/// The part of the parameters that says when a file ends and which may go.
fn files(raw: &RawParams) -> Result<(Split, Room, Snapshot), ParamError> {
    let span_ns = nanoseconds(Seconds(in_range("split_s", raw.split_s, "s", (0.0, 1e6))?));
    in_range("keep_severity", f64::from(raw.keep_severity), "-", (0.0, 3.0))?;
    in_range("snapshot_mib", f64::from(raw.snapshot_mib), "MiB", (1.0, 1000.0))?;
    let split =
        Split { span_ns: (span_ns > 0).then_some(span_ns), bytes: limit("split_mib", raw.split_mib, 1e6)? };
    let bag_bytes = limit("bag_mib", raw.bag_mib, 1e8)?;
    if raw.bag_mib > 0 && raw.bag_mib < raw.split_mib {
        // Not even one file would have room.
        let rule = format!("0, or in [{}, 100000000]: a file takes split_mib = {0} MiB", raw.split_mib);
        let (value, unit) = (f64::from(raw.bag_mib), "MiB");
        return Err(ParamError::OutOfRange { name: "bag_mib", value, unit, rule });
    }
    let room = Room {
        bag_bytes,
        free_bytes: limit("disk_free_mib", raw.disk_free_mib, 1e8)?.unwrap_or(0),
        keep_severity: raw.keep_severity,
    };
    let snapshot = Snapshot {
        span_ns: nanoseconds(Seconds(in_range("snapshot_s", raw.snapshot_s, "s", (0.0, 600.0))?)),
        bytes: size(raw.snapshot_mib).saturating_mul(size(1 << 20)),
    };
    Ok((split, room, snapshot))
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
        let (split, room, snapshot) = files(&raw)?;
        Ok(Self {
            split,
            room,
            snapshot,
            topics: raw.topics,
            start_paused: raw.start_paused,
            compact_end: Seconds(in_range("compact_end_s", raw.compact_end_s, "s", (0.0, 1.0))?),
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
            topics: Vec::new(),
            start_paused: false,
            split_s: 0.0,
            split_mib: 1024,
            bag_mib: 0,
            disk_free_mib: 256,
            keep_severity: 2,
            snapshot_s: 0.0,
            snapshot_mib: 64,
            compact_end_s: 0.5,
        }
    }

    #[test]
    fn a_limit_of_zero_is_none() {
        let params = Params::try_from(raw()).unwrap();
        assert_eq!((params.split.span_ns, params.split.bytes), (None, Some(1 << 30)));
        assert_eq!((params.room.bag_bytes, params.room.free_bytes), (None, 256 << 20));
        let error = Params::try_from(RawParams { keep_severity: 4, ..raw() }).unwrap_err();
        assert_eq!(error.to_string(), "keep_severity = 4 (no unit): must be in [0, 3]");
    }

    /// A bag that has no room for one file would lose every file it closes.
    #[test]
    fn a_bag_has_room_for_a_file() {
        let with = |bag_mib, split_mib| Params::try_from(RawParams { bag_mib, split_mib, ..raw() });
        for (bag_mib, split_mib) in [(1024, 1024), (1, 0), (0, 1024), (1, 1)] {
            assert!(with(bag_mib, split_mib).is_ok(), "{bag_mib} {split_mib}");
        }
        let error = with(1, 1024).unwrap_err().to_string();
        assert_eq!(
            error,
            "bag_mib = 1 MiB: must be 0, or in [1024, 100000000]: a file takes split_mib = 1024 MiB"
        );
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
