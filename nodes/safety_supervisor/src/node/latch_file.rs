//! The latch on disk: a restart of the supervisor must not re-energise a heater.
//!
//! Written beside, synced, renamed, its folder synced; removed and its folder synced when the latch has ended. The
//! work is done on a thread of its own, since a disk may take seconds and a permit is due every 20 ms.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use runtime::{ParamFileError, Parameters};
use tokio::task::JoinHandle;

use crate::cause::Cause;
use crate::modes::Latch;

/// Keeps the latch of the brain and the one on disk the same.
#[derive(Debug)]
pub(super) struct LatchFile {
    path: Option<PathBuf>,
    stored: Option<Latch>,
    /// Latch on its way to the disk.
    job: Option<(Option<Latch>, JoinHandle<io::Result<()>>)>,
    /// Why the last try failed.
    pub(super) failed: Option<String>,
    /// Calls until a disk that refused is asked again.
    rest: u32,
}

/// Calls between two tries on a disk that refuses: a second of permits.
const REST: u32 = 50;

/// Name of the parameter with the file that keeps the latch; empty or not given: none is kept.
pub(super) const LATCH_FILE: &str = "latch_file";

/// The file of that parameter, where a file can be there: whoever opens a pipe to read it waits for a writer.
///
/// # Errors
/// What is there and is no file.
pub(super) fn path_of(parameters: &Parameters) -> Result<Option<PathBuf>, ParamFileError> {
    let path = parameters.optional::<PathBuf>(LATCH_FILE)?.filter(|path| !path.as_os_str().is_empty());
    for path in path.iter().flat_map(|path| [path.clone(), beside(path)]) {
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
        Self { path, stored, job: None, failed: None, rest: 0 }
    }

    /// The latch on disk.
    pub(super) fn stored(&self) -> Option<Latch> {
        self.stored
    }

    /// Whether `latch` is kept. Starts keeping it where it is not, and takes the end of that in.
    pub(super) async fn keeps(&mut self, latch: Option<Latch>) -> bool {
        let Some(path) = &self.path else { return true };
        if self.job.as_ref().is_some_and(|(_, handle)| handle.is_finished()) {
            self.finish().await;
        } else if self.rest > 0 {
            self.rest -= 1;
        } else if self.job.is_none() && self.stored != latch {
            let path = path.clone();
            let handle = tokio::task::spawn_blocking(move || write(&path, latch));
            self.job = Some((latch, handle));
        }
        self.stored == latch
    }

    /// Waits for what is being written, and writes `latch` where that was another one: the last word of this run.
    pub(super) async fn end(&mut self, latch: Option<Latch>) {
        self.finish().await;
        self.rest = 0;
        if !self.keeps(latch).await {
            self.finish().await;
        }
    }

    /// Waits for what is being written.
    pub(super) async fn finish(&mut self) {
        let Some((latch, handle)) = self.job.take() else { return };
        match handle.await.unwrap_or_else(|error| Err(io::Error::other(error))) {
            Ok(()) => {
                self.stored = latch;
                self.failed = None;
            }
            Err(error) => {
                let path = self.path.as_deref().unwrap_or(Path::new(""));
                self.failed = Some(format!("{}: {error}", path.display()));
                self.rest = REST;
            }
        }
    }
}

/// The latch of a former run. What cannot be read tells of one all the same.
fn read(path: &Path) -> Option<Latch> {
    let latch = match fs::read(path) {
        Ok(bytes) => serde_json::from_slice(&bytes).map_err(|error| error.to_string()),
        Err(error) if error.kind() == ErrorKind::NotFound => return None,
        Err(error) => Err(error.to_string()),
    };
    Some(latch.unwrap_or_else(|error| {
        tracing::error!("{}: {error}: taken for a latched SAFE_OFF", path.display());
        Latch { estop: false, cause: Cause::LatchUnreadable }
    }))
}

/// Where a record is written before it takes the place of the former one.
fn beside(path: &Path) -> PathBuf {
    path.with_extension("new")
}

fn write(path: &Path, latch: Option<Latch>) -> io::Result<()> {
    match latch {
        Some(latch) => {
            let beside = beside(path);
            let mut file = File::create(&beside)?;
            file.write_all(&serde_json::to_vec(&latch)?)?;
            file.sync_all()?;
            fs::rename(beside, path)?;
        }
        None => match fs::remove_file(path) {
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            Ok(()) | Err(_) => {}
        },
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
}

#[cfg(test)]
mod tests;
