//! The latch on disk: a restart of the supervisor must not re-energise a heater.

use std::fs;
use std::path::{Path, PathBuf};

use runtime::{ParamFileError, Parameters};

use super::record::{self, Record};
use super::standing_file;
use crate::cause::Cause;
use crate::modes::Latch;

/// Keeps the latch of the brain and the one on disk the same.
pub(super) type LatchFile = Record<Latch>;

/// Name of the parameter with the file that keeps the latch; empty or not given: none is kept.
pub(super) const LATCH_FILE: &str = "latch_file";

/// The file of that parameter, where a file can be there, and the one of mode and pause beside it: whoever opens a pipe
/// to read it waits for a writer.
///
/// # Errors
/// What is there and is no file.
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
    Ok(path)
}

impl LatchFile {
    /// Reads what a former run left behind; without a path nothing is kept.
    pub(super) fn open(path: Option<PathBuf>) -> Self {
        let stored = path.as_deref().and_then(read);
        Self::new(path, stored)
    }
}

/// The latch of a former run. What cannot be read tells of one all the same.
fn read(path: &Path) -> Option<Latch> {
    let latch = record::read(path, |bytes| serde_json::from_slice(bytes).map_err(|error| error.to_string()))?;
    Some(latch.unwrap_or_else(|error| {
        tracing::error!("{}: {error}: taken for a latched SAFE_OFF", path.display());
        Latch { estop: false, cause: Cause::LatchUnreadable }
    }))
}

#[cfg(test)]
mod tests;
