//! The list of what was installed, in the form of `sha256sum`.

use anyhow::bail;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

/// Paths below the prefix with the checksum of their contents.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Manifest(BTreeMap<PathBuf, String>);

impl Manifest {
    /// Reads the text of a list.
    ///
    /// # Errors
    /// A line that is none of ours: what it names would be removed some day.
    pub(super) fn parse(text: &str) -> anyhow::Result<Self> {
        let mut listed = BTreeMap::new();
        for (index, line) in text.lines().enumerate() {
            let parts =
                line.split_once("  ").filter(|(sum, path)| is_sum(sum) && stays_below(Path::new(path)));
            match parts {
                Some((sum, path)) => _ = listed.insert(PathBuf::from(path), sum.to_owned()),
                None => {
                    bail!("line {}: expected a checksum and a path below the prefix, not '{line}'", index + 1)
                }
            }
        }
        Ok(Self(listed))
    }

    /// The text of the list.
    pub(super) fn text(&self) -> String {
        self.0.iter().fold(String::new(), |mut text, (path, sum)| {
            _ = writeln!(text, "{sum}  {}", path.display());
            text
        })
    }

    /// Adds a file.
    pub(super) fn insert(&mut self, path: PathBuf, sum: String) {
        self.0.insert(path, sum);
    }

    /// Paths in order.
    pub(super) fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        self.0.keys()
    }

    /// Checksum of a path that is listed.
    pub(super) fn sum(&self, path: &Path) -> Option<&str> {
        self.0.get(path).map(String::as_str)
    }

    /// The list of some of its paths alone.
    pub(super) fn only(&self, paths: &[PathBuf]) -> Self {
        let of = |path: &PathBuf| Some((path.clone(), self.0.get(path)?.clone()));
        Self(paths.iter().filter_map(of).collect())
    }

    /// Whether nothing is listed.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

fn is_sum(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}

fn stays_below(path: &Path) -> bool {
    let mut parts = path.components();
    parts.clone().next().is_some() && parts.all(|part| matches!(part, Component::Normal(_)))
}
