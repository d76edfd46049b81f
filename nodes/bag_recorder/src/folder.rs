//! The folder of a bag: lock, listing, and the files `metadata.yaml` and `counts.json` that describe it.

use crate::contents::{Contents, FileContents};
use crate::error::RecorderError;
use crate::layout::{Layout, Survey};
use crate::metadata::{counts_json, metadata_yaml};
use crate::retention::Held;
use crate::tally::Tally;
use std::fs::{File, TryLockError};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A bag's folder; clones share it.
#[derive(Debug, Clone)]
pub struct Folder {
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Shared {
    path: PathBuf,
    layout: Layout,
    tally: Arc<Tally>,
    state: Mutex<State>,
    /// Locked while this process lives, so that no second recorder mends a file that is being written.
    lock: File,
}

#[derive(Debug, Default)]
struct State {
    contents: Contents,
    active: Option<String>,
}

impl Folder {
    /// Opens a folder, or makes it, and locks it.
    pub fn open(path: &Path, name: &str, tally: Arc<Tally>) -> Result<Self, RecorderError> {
        Self::open_as(path, Layout::new(name), tally)
    }

    /// As [`Folder::open`] with names that are known.
    pub fn open_as(path: &Path, layout: Layout, tally: Arc<Tally>) -> Result<Self, RecorderError> {
        std::fs::create_dir_all(path).map_err(RecorderError::file("make", path))?;
        let lock = File::open(path).map_err(RecorderError::file("open", path))?;
        lock.try_lock().map_err(|error| match error {
            TryLockError::WouldBlock => RecorderError::InUse(path.to_path_buf()),
            TryLockError::Error(error) => RecorderError::file("lock", path)(error),
        })?;
        let shared = Shared { path: path.to_path_buf(), layout, tally, state: Mutex::default(), lock };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// Names of the files.
    pub fn layout(&self) -> &Layout {
        &self.shared.layout
    }

    /// Path of a file.
    pub fn path(&self, name: &str) -> PathBuf {
        self.shared.path.join(name)
    }

    /// Looks through the folder and removes what a kill left half-made.
    pub fn survey(&self) -> Result<Survey, RecorderError> {
        let failed = || RecorderError::file("list", &self.shared.path);
        let mut names = Vec::new();
        for entry in std::fs::read_dir(&self.shared.path).map_err(failed())? {
            names.extend(entry.map_err(failed())?.file_name().into_string());
        }
        let survey = self.shared.layout.survey(names.iter().map(String::as_str));
        for name in &survey.stale {
            self.remove(name)?;
        }
        Ok(survey)
    }

    /// Removes a file.
    pub fn remove(&self, name: &str) -> Result<(), RecorderError> {
        let path = self.path(name);
        std::fs::remove_file(&path).map_err(RecorderError::file("remove", &path))
    }

    /// The finished files with their sizes, oldest first.
    #[must_use]
    pub fn held(&self) -> Vec<Held> {
        let layout = self.layout();
        let numbers: Vec<u32> = self.state().contents.files().map(|file| file.number).collect();
        let size = |name: &str| std::fs::metadata(self.path(name)).map_or(0, |found| found.len());
        let held = |number| Held {
            number,
            bytes: size(&layout.finished(number)),
            kept: self.path(&layout.keep(number)).exists(),
        };
        numbers.into_iter().map(held).collect()
    }

    /// Marks a file, finished or not, as one that must not be dropped.
    pub fn keep(&self, number: u32) -> Result<(), RecorderError> {
        let path = self.path(&self.layout().keep(number));
        File::create(&path).map(drop).map_err(RecorderError::file("mark", &path))
    }

    /// Drops a finished file: from the description first, so that none names what is not there.
    pub fn forget(&self, number: u32) -> Result<(), RecorderError> {
        {
            let mut state = self.state();
            state.contents.remove(number);
            self.describe(&state)?;
        }
        self.remove(&self.layout().finished(number))
    }

    /// Bytes that the disk has left for this process.
    pub fn free_bytes(&self) -> Result<u64, RecorderError> {
        let failed = |error: rustix::io::Errno| {
            RecorderError::file("ask the disk of", &self.shared.path)(error.into())
        };
        let disk = rustix::fs::fstatvfs(&self.shared.lock).map_err(failed)?;
        Ok(disk.f_bavail.saturating_mul(disk.f_frsize))
    }

    /// Bytes of the file that is being written.
    #[must_use]
    pub fn active_bytes(&self) -> u64 {
        let active = self.state().active.clone();
        active.and_then(|name| std::fs::metadata(self.path(&name)).ok()).map_or(0, |found| found.len())
    }

    /// Takes a finished file in and describes the folder anew.
    pub fn add(&self, file: FileContents) -> Result<(), RecorderError> {
        let mut state = self.state();
        state.contents.add(file);
        self.describe(&state)
    }

    /// Takes a finished file in that need not be described anew.
    pub fn know(&self, file: FileContents) {
        self.state().contents.add(file);
    }

    /// What another program says of the bag keeps its words: `metadata.yaml` where no recorder of ours has counted.
    ///
    /// # Errors
    /// A disk that refuses.
    pub fn keep_description(&self) -> Result<(), RecorderError> {
        let (told, kept) = (self.path("metadata.yaml"), self.path("metadata.yaml.before"));
        if self.path("counts.json").exists() || kept.exists() || !told.exists() {
            return Ok(());
        }
        std::fs::copy(&told, &kept).map(drop).map_err(RecorderError::file("keep", &kept))
    }

    /// Names the file that is being written, or `None` at the end, and describes the folder anew.
    pub fn set_active(&self, active: Option<String>) -> Result<(), RecorderError> {
        let mut state = self.state();
        state.active = active;
        self.describe(&state)
    }

    /// Writes `metadata.yaml` and `counts.json`.
    fn describe(&self, state: &State) -> Result<(), RecorderError> {
        let active = state.active.as_deref();
        self.replace("metadata.yaml", &metadata_yaml(&state.contents, active))?;
        self.replace("counts.json", &counts_json(&state.contents, active, self.shared.tally.run()))?;
        self.shared.lock.sync_all().map_err(RecorderError::file("sync", &self.shared.path))
    }

    /// Replaces a small file as a whole: a kill leaves the old one or the new one.
    fn replace(&self, name: &str, text: &str) -> Result<(), RecorderError> {
        let temporary = self.path(&format!("{name}.tmp"));
        let failed = || RecorderError::file("write", &temporary);
        let mut file = File::create(&temporary).map_err(failed())?;
        file.write_all(text.as_bytes()).map_err(failed())?;
        file.sync_all().map_err(failed())?;
        std::fs::rename(&temporary, self.path(name)).map_err(failed())
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.shared.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
