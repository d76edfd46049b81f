//! The latch on disk: a restart of the supervisor must not re-energise a heater.

use std::fs;
use std::path::{Path, PathBuf};

use runtime::{ParamFileError, Parameters};
use serde::{Deserialize, Serialize};

use super::record::{self, Record};
use super::standing_file;
use crate::cause::Cause;
use crate::event::Evidence;
use crate::modes::Latch;

/// Keeps the latch of the brain and the one on disk the same.
pub(super) type LatchFile = Record<Latched>;

/// The record as it is written, with what its cause rested on; a record without that is an older one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Latched {
    estop: bool,
    cause: Cause,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    value: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    limit: Option<f64>,
}

impl Latched {
    pub(super) fn new(Latch { estop, cause }: Latch, evidence: Option<Evidence>) -> Self {
        let (value, limit) = (evidence.map(|number| number.value), evidence.and_then(|number| number.limit));
        Self { estop, cause, value, limit }
    }

    pub(super) fn latch(self) -> Latch {
        Latch { estop: self.estop, cause: self.cause }
    }

    /// What its cause rested on; `None` where the record does not tell.
    pub(super) fn evidence(self) -> Option<Evidence> {
        Evidence::of(self.cause, self.value?, self.limit)
    }
}

/// Name of the parameter with the file that keeps the latch; empty or not given: none is kept.
pub(super) const LATCH_FILE: &str = "latch_file";

/// The file of that parameter, where a file can be there, and the one of mode and pause beside it: whoever opens a pipe
/// to read it waits for a writer. Its folder is made: a stop that finds none on the day would be forgotten.
///
/// # Errors
/// What is there and is no file; a folder that cannot be made.
pub(super) fn path_of(parameters: &Parameters) -> Result<Option<PathBuf>, ParamFileError> {
    let path = parameters.optional::<PathBuf>(LATCH_FILE)?.filter(|path| !path.as_os_str().is_empty());
    let records = path.iter().flat_map(|path| [path.clone(), standing_file::path_of(path)]);
    for path in records.flat_map(|path| [record::beside(&path), path]) {
        let found = fs::metadata(&path).ok().map(|found| found.file_type());
        if let Some(kind) = found.filter(|kind| !kind.is_file()) {
            let kind = if kind.is_dir() { "a folder" } else { "a pipe, socket or device" };
            let message = format!("{} is {kind}: must be a file, or not there yet", path.display());
            return Err(ParamFileError::Refused { at: LATCH_FILE.to_owned(), message });
        }
    }
    if let Some(folder) =
        path.as_deref().and_then(Path::parent).filter(|folder| !folder.as_os_str().is_empty())
    {
        fs::create_dir_all(folder).map_err(|error| {
            let message = format!("no folder {} for it: {error}", folder.display());
            ParamFileError::Refused { at: LATCH_FILE.to_owned(), message }
        })?;
    }
    Ok(path)
}

impl LatchFile {
    /// Reads what a former run left behind; without a path nothing is kept. What cannot be read tells of a latch all the
    /// same, and the reason is told: so does a record that was begun beside and came no further, on a full disk or with
    /// the end of the process. Of two records the stricter one counts.
    pub(super) fn open(path: Option<PathBuf>) -> (Self, Option<String>) {
        let places = path.iter().flat_map(|path| [path.clone(), record::beside(path)]);
        let (mut stored, mut refused) = (None::<Latched>, None);
        for (found, place) in places.filter_map(|place| Some((record::read(&place, parse)?, place))) {
            let latched = found.unwrap_or_else(|error| {
                let told = format!("{}: {error}: taken for a latched SAFE_OFF", place.display());
                tracing::error!("{told}");
                refused.get_or_insert(told);
                Latched::new(Latch { estop: false, cause: Cause::LatchUnreadable }, None)
            });
            if stored.is_none_or(|before| latched.estop && !before.estop) {
                stored = Some(latched);
            }
        }
        (Self::new(path, stored), refused)
    }
}

fn parse(bytes: &[u8]) -> Result<Latched, String> {
    serde_json::from_slice(bytes).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests;
