//! Files that tell of a machine; tests put a folder in their place.

use std::path::{Path, PathBuf};

/// A machine by its file system.
#[derive(Debug, Clone)]
pub(super) struct Machine {
    root: PathBuf,
}

impl Machine {
    /// The one this runs on.
    pub(super) fn here() -> Self {
        Self { root: PathBuf::from("/") }
    }

    /// A folder that looks like one.
    #[cfg(test)]
    pub(super) fn at(root: &Path) -> Self {
        Self { root: root.to_path_buf() }
    }

    /// Path of a file of the machine, given without the leading slash.
    pub(super) fn path(&self, path: &str) -> PathBuf {
        self.root.join(path)
    }

    /// Text of a file, trimmed; `None` where it is not there.
    pub(super) fn text(&self, path: &str) -> Option<String> {
        std::fs::read_to_string(self.path(path)).ok().map(|text| text.trim().to_owned())
    }

    /// Names in a folder, in order; none where it is not there.
    pub(super) fn names(&self, folder: &str) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.path(folder))
            .into_iter()
            .flatten()
            .flatten()
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

/// The nearest part of a path that exists.
pub(super) fn nearest(path: &Path) -> PathBuf {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    whole.ancestors().find(|part| part.exists()).unwrap_or(Path::new("/")).to_path_buf()
}
