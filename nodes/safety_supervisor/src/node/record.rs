//! A record on disk that outlives the process.
//!
//! Written beside, synced, renamed, its folder synced; removed and its folder synced when there is nothing to keep. Once a
//! second it is looked at, and written again where somebody has taken it away. The work is done on a thread of its own,
//! since a disk may take seconds and a permit is due every 20 ms.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use tokio::task::JoinHandle;

/// Calls between two tries on a disk that refuses: a second of permits.
pub(super) const REST: u32 = 50;

/// Keeps a value of the brain and the one on disk the same.
#[derive(Debug)]
pub(super) struct Record<T> {
    path: Option<PathBuf>,
    stored: Option<T>,
    /// Value on its way to the disk.
    job: Option<(Option<T>, JoinHandle<io::Result<()>>)>,
    /// Why the last try failed.
    pub(super) failed: Option<String>,
    /// What a try that failed has left beside the record may still lie there.
    stray: bool,
    /// Calls until a disk that refused is asked again.
    rest: u32,
    /// Calls since the record was looked at.
    unseen: u32,
}

impl<T: Copy + PartialEq + Serialize + Send + 'static> Record<T> {
    /// A record that holds `stored`; without a path nothing is kept. A place where nothing can be written is told at once, not
    /// with the first stop, and asked again: who guards without a record is better than nobody.
    pub(super) fn new(path: Option<PathBuf>, stored: Option<T>) -> Self {
        let failed = path.as_deref().and_then(|path| probe(path).err().map(|error| told(path, &error)));
        if let Some(failed) = &failed {
            tracing::error!("{failed}: a stop would be forgotten with the end of this process");
        }
        let stray = failed.is_some();
        Self { path, stored, job: None, failed, stray, rest: 0, unseen: 0 }
    }

    /// The value on disk.
    pub(super) fn stored(&self) -> Option<T> {
        self.stored
    }

    /// Whether `value` is kept. Starts keeping it where it is not, and takes the end of that in.
    pub(super) async fn keeps(&mut self, value: Option<T>) -> bool {
        let Some(path) = &self.path else { return true };
        if self.job.as_ref().is_some_and(|(_, handle)| handle.is_finished()) {
            self.finish().await;
        } else if self.rest > 0 {
            self.rest -= 1;
        } else if self.job.is_none() && (self.stored != value || self.stray) {
            let path = path.clone();
            let handle = tokio::task::spawn_blocking(move || write(&path, value));
            self.job = Some((value, handle));
        } else if self.job.is_none() && self.stored.is_some() {
            self.look(path.clone());
        }
        self.stored == value && !self.stray
    }

    /// Has the record looked at, and written where it is not as it was kept.
    fn look(&mut self, path: PathBuf) {
        self.unseen += 1;
        if self.unseen >= REST {
            let value = self.stored;
            self.unseen = 0;
            self.job = Some((value, tokio::task::spawn_blocking(move || restore(&path, value))));
        }
    }

    /// Waits for what is being written, and writes `value` where that was another one: the last word of this run.
    pub(super) async fn end(&mut self, value: Option<T>) {
        self.finish().await;
        self.rest = 0;
        if !self.keeps(value).await {
            self.finish().await;
        }
    }

    /// Waits for what is being written.
    pub(super) async fn finish(&mut self) {
        let Some((value, handle)) = self.job.take() else { return };
        match handle.await.unwrap_or_else(|error| Err(io::Error::other(error))) {
            Ok(()) => {
                self.stored = value;
                (self.failed, self.stray) = (None, false);
            }
            Err(error) => {
                self.failed = Some(told(self.path.as_deref().unwrap_or(Path::new("")), &error));
                (self.rest, self.stray) = (REST, true);
            }
        }
    }
}

/// What a former run left behind, `None` where there is no file.
///
/// # Errors
/// Why it cannot be read.
pub(super) fn read<T>(
    path: &Path,
    parse: impl FnOnce(&[u8]) -> Result<T, String>,
) -> Option<Result<T, String>> {
    match fs::read(path) {
        Ok(bytes) => Some(parse(&bytes)),
        Err(error) if error.kind() == ErrorKind::NotFound => None,
        Err(error) => Some(Err(error.to_string())),
    }
}

/// Where a record is written before it takes the place of the former one.
pub(super) fn beside(path: &Path) -> PathBuf {
    path.with_extension("new")
}

fn told(path: &Path, error: &io::Error) -> String {
    format!("{}: {error}", path.display())
}

/// Whether a file can be made beside the record: not where a record is looked for, which an empty one would be.
fn probe(path: &Path) -> io::Result<()> {
    let probe = path.with_extension("probe");
    File::create(&probe)?;
    fs::remove_file(probe)
}

/// Writes a record that is not on disk as it was kept.
fn restore<T: Serialize>(path: &Path, value: Option<T>) -> io::Result<()> {
    let kept = value.as_ref().map(serde_json::to_vec).transpose()?;
    if fs::read(path).ok() == kept {
        return Ok(());
    }
    tracing::warn!("{} is not as it was written: it is written again", path.display());
    write(path, value)
}

fn write<T: Serialize>(path: &Path, value: Option<T>) -> io::Result<()> {
    match value {
        Some(value) => {
            let beside = beside(path);
            let mut file = File::create(&beside)?;
            file.write_all(&serde_json::to_vec(&value)?)?;
            file.sync_all()?;
            fs::rename(beside, path)?;
        }
        None => {
            probe(path)?;
            [path, &beside(path)].into_iter().try_for_each(|place| match fs::remove_file(place) {
                Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
                Ok(()) | Err(_) => Ok(()),
            })?;
        }
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
}
