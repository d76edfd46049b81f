//! The files of a bag.

use super::decode::short;
use super::stated::Stated;
use anyhow::{Context, bail};
use bag_recorder::metadata::RunCounts;
use runtime::input;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Endings of the files of a bag; the longer one is that of a file being written.
const ENDINGS: [&str; 2] = [".mcap", ".mcap.active"];

/// Namespaces that are named at most.
const NAMED: usize = 10;

/// Where a bag lies.
#[derive(Debug, Clone)]
pub(crate) struct Bag {
    /// Name for people.
    pub(crate) name: String,
    /// Its files in the order of their numbers.
    pub(crate) files: Vec<PathBuf>,
    /// What the recorder counted, where it left `counts.json`.
    pub(crate) counts: Option<Counts>,
    /// Messages by `metadata.yaml`.
    pub(crate) stated: Option<u64>,
    /// What describes the bag and cannot be read.
    pub(crate) broken: Vec<String>,
}

/// The recorder's own counts.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(default)]
pub(crate) struct Counts {
    /// `closed` or `recording`.
    pub(crate) state: String,
    /// Messages in the finished files.
    pub(crate) messages: u64,
    /// Messages by topic in the finished files.
    pub(crate) topics: BTreeMap<String, u64>,
    /// Messages of each finished file.
    pub(crate) files: BTreeMap<String, u64>,
    /// Of the run that wrote last.
    pub(crate) run: Run,
}

/// Counts of one run of the recorder.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Deserialize)]
#[serde(default)]
pub(crate) struct Run {
    pub(crate) received: u64,
    pub(crate) dropped: u64,
    pub(crate) missed: u64,
    pub(crate) log_time_raised: u64,
}

impl From<Run> for RunCounts {
    fn from(run: Run) -> Self {
        let Run { received, dropped, missed, log_time_raised: raised } = run;
        Self { received, dropped, missed, raised }
    }
}

impl Bag {
    /// Finds the files of a folder, or takes the one file.
    pub(crate) fn find(path: &Path) -> anyhow::Result<Self> {
        if matches!(path.try_exists(), Ok(false)) {
            bail!(
                "{}: no such bag: `fdm up` names the bag of a print at its end, below bags/ of its folder",
                path.display()
            );
        }
        let found = std::fs::metadata(path).with_context(|| path.display().to_string())?;
        let named = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
        if !found.is_dir() {
            input::open(path).with_context(|| path.display().to_string())?;
            let name = named(path).unwrap_or_default();
            let files = vec![path.to_path_buf()];
            return Ok(Self { name, files, counts: None, stated: None, broken: Vec::new() });
        }
        let mut files = Vec::new();
        for entry in std::fs::read_dir(path).with_context(|| path.display().to_string())? {
            let file = entry?.path();
            if let Some(place) = named(&file).as_deref().and_then(place) {
                files.push((place, file));
            }
        }
        files.sort();
        // A finished file is whole: its active twin holds nothing more.
        files.dedup_by(|later, earlier| later.0.0 == earlier.0.0 && later.0.1 == earlier.0.1);
        if files.is_empty() {
            bail!("{}: no .mcap file in this folder", path.display());
        }
        let whole = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let Stated { counts, messages: stated, broken, .. } = Stated::of(path);
        let files = files.into_iter().map(|(_, file)| file).collect();
        Ok(Self { name: named(&whole).unwrap_or_default(), files, counts, stated, broken })
    }

    /// Bytes of all files.
    pub(crate) fn bytes(&self) -> u64 {
        self.files.iter().filter_map(|file| std::fs::metadata(file).ok()).map(|file| file.len()).sum()
    }
}

/// The printers that a bag holds beside the one that was asked for, for the end of a sentence.
pub(crate) fn there_are(namespaces: &BTreeSet<String>) -> String {
    let names: Vec<String> = namespaces
        .iter()
        .take(NAMED)
        .map(|name| short(if name.is_empty() { "/" } else { name }, 80))
        .collect();
    if names.is_empty() { String::new() } else { format!("; there are {}", names.join(", ")) }
}

/// Where a file stands among the others: number, name without ending, finished before active.
fn place(name: &str) -> Option<(u32, String, usize)> {
    let (order, ending) = ENDINGS.iter().enumerate().find(|(_, ending)| name.ends_with(*ending))?;
    let stem = name.strip_suffix(ending)?;
    let number = stem.rsplit_once('_').and_then(|(_, digits)| digits.parse().ok()).unwrap_or(0);
    Some((number, stem.to_owned(), order))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_stand_by_number_and_a_finished_one_before_its_twin() {
        let mut places: Vec<_> =
            ["p_10.mcap", "p_2.mcap.active", "p_2.mcap", "metadata.yaml", "p_0.mcap"].map(place).into();
        places.sort();
        let numbers: Vec<_> =
            places.into_iter().flatten().map(|(number, _, order)| (number, order)).collect();
        assert_eq!(numbers, [(0, 0), (2, 0), (2, 1), (10, 0)]);
    }
}
