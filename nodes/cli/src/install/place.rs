//! The folder that is installed to.

use super::layout::{Contents, Layout};
use super::manifest::Manifest;
use super::{MANIFEST, PACKAGE};
use anyhow::{Context, bail};
use runtime::params::sha256_hex;
use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// What a folder must hold one of to count as a prefix.
const OF_A_PREFIX: [&str; 3] = ["bin", "lib", "share"];
/// Modes, whatever the umask: who runs a node is somebody else.
const PROGRAM: u32 = 0o755;
const TEXT: u32 = 0o644;

/// Where the prefix lies while files are written.
#[derive(Debug)]
pub(super) struct Target(PathBuf);

impl Target {
    /// The prefix itself, or below `root`.
    pub(super) fn new(root: Option<&Path>, prefix: &Path) -> Self {
        let below = |root: &Path| root.join(prefix.strip_prefix("/").unwrap_or(prefix));
        Self(root.map_or_else(|| prefix.to_path_buf(), below))
    }

    /// Where a path below the prefix lies.
    pub(super) fn at(&self, path: &Path) -> PathBuf {
        self.0.join(path)
    }

    /// What was installed before; empty where nothing was.
    ///
    /// # Errors
    /// A list that cannot be read.
    pub(super) fn manifest(&self) -> anyhow::Result<Manifest> {
        let path = self.at(Path::new(MANIFEST));
        match std::fs::read_to_string(&path) {
            Ok(text) => Manifest::parse(&text).with_context(|| path.display().to_string()),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Manifest::default()),
            Err(error) => Err(error).with_context(|| path.display().to_string()),
        }
    }

    /// Refuses a folder that is no prefix, and files that somebody else has put there.
    ///
    /// # Errors
    /// The folder, or the first such file.
    pub(super) fn refuse_foreign(&self, layout: &Layout, before: &Manifest) -> anyhow::Result<()> {
        let there = self.0.symlink_metadata().is_ok();
        if there && !self.0.is_dir() {
            bail!("--prefix {}: is no folder", self.0.display());
        }
        let used = there
            && std::fs::read_dir(&self.0).with_context(|| self.0.display().to_string())?.next().is_some();
        if used && !OF_A_PREFIX.iter().any(|name| self.at(Path::new(name)).is_dir()) {
            bail!(
                "--prefix {}: holds other files and none of bin/, lib/, share/: name a new folder",
                self.0.display()
            );
        }
        let foreign: Vec<&PathBuf> = layout
            .files()
            .iter()
            .map(|file| &file.path)
            .filter(|path| before.sum(path).is_none() && self.at(path).symlink_metadata().is_ok())
            .collect();
        match foreign.first() {
            None => Ok(()),
            Some(first) => bail!(
                "{} was not installed by fdm install, nor were {} more: move them away, or choose another --prefix",
                self.at(first).display(),
                foreign.len() - 1
            ),
        }
    }

    /// Files of a list that are there with other contents.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(super) fn changed(&self, before: &Manifest) -> anyhow::Result<Vec<PathBuf>> {
        let mut changed = Vec::new();
        for path in before.paths() {
            let at = self.at(path);
            if at.symlink_metadata().is_err() {
                continue;
            }
            // A link counts as changed where it leads nowhere.
            let sum = std::fs::read(&at).ok().map(|bytes| sha256_hex(&bytes));
            if sum.as_deref() != before.sum(path) {
                changed.push(path.clone());
            }
        }
        Ok(changed)
    }

    /// Writes all files and their list; returns their size.
    ///
    /// # Errors
    /// The first file that cannot be written.
    pub(super) fn write(&self, layout: &Layout) -> anyhow::Result<u64> {
        let mut list = Manifest::default();
        let mut size = 0;
        for file in layout.files() {
            let contents = file.bytes()?;
            size += if matches!(file.contents, Contents::Link { .. }) { 0 } else { contents.len() as u64 };
            list.insert(file.path.clone(), sha256_hex(&contents));
        }
        // The list first: what was half written is known as ours by the next start.
        self.list(&list)?;
        for file in layout.files() {
            match &file.contents {
                Contents::Link { to, .. } => self.link(&file.path, to)?,
                Contents::Copy { program: true, .. } => self.put(&file.path, &file.bytes()?, PROGRAM)?,
                _ => self.put(&file.path, &file.bytes()?, TEXT)?,
            }
        }
        Ok(size)
    }

    /// Writes down what is installed.
    ///
    /// # Errors
    /// A list that cannot be written.
    pub(super) fn list(&self, list: &Manifest) -> anyhow::Result<()> {
        self.put(Path::new(MANIFEST), list.text().as_bytes(), TEXT)
    }

    /// Removes files, and folders that are empty then.
    ///
    /// # Errors
    /// The first file that cannot be removed.
    pub(super) fn remove(&self, paths: &[PathBuf]) -> anyhow::Result<()> {
        for path in paths {
            let at = self.at(path);
            match std::fs::remove_file(&at) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    return Err(error).with_context(|| at.display().to_string());
                }
                _ => {}
            }
            // Stops at the first folder that holds something else.
            let mut folders = path.ancestors().skip(1).take_while(|folder| *folder != Path::new(""));
            while folders.next().is_some_and(|folder| std::fs::remove_dir(self.at(folder)).is_ok()) {}
        }
        Ok(())
    }

    /// A file under its name at once, as a whole: a running program keeps the old one.
    fn put(&self, path: &Path, contents: &[u8], mode: u32) -> anyhow::Result<()> {
        let (at, beside) = self.places(path)?;
        let write = || {
            std::fs::write(&beside, contents)?;
            std::fs::set_permissions(&beside, Permissions::from_mode(mode))?;
            std::fs::rename(&beside, &at)
        };
        write().with_context(|| at.display().to_string())
    }

    fn link(&self, path: &Path, to: &Path) -> anyhow::Result<()> {
        let (at, beside) = self.places(path)?;
        _ = std::fs::remove_file(&beside);
        let link = || std::os::unix::fs::symlink(to, &beside).and_then(|()| std::fs::rename(&beside, &at));
        link().with_context(|| at.display().to_string())
    }

    /// Where a file lies and where it is written first; makes its folders, which everybody may enter.
    fn places(&self, path: &Path) -> anyhow::Result<(PathBuf, PathBuf)> {
        let at = self.at(path);
        let folder = at.parent().unwrap_or(&self.0);
        let missing: Vec<&Path> = folder.ancestors().take_while(|folder| !folder.exists()).collect();
        for made in missing.into_iter().rev() {
            std::fs::create_dir(made)
                .and_then(|()| std::fs::set_permissions(made, Permissions::from_mode(PROGRAM)))
                .with_context(|| made.display().to_string())?;
        }
        let name = at.file_name().unwrap_or_default().to_string_lossy();
        let beside = folder.join(format!(".{name}.{PACKAGE}"));
        Ok((at, beside))
    }
}
