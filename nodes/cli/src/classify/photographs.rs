//! Photographs with labels: read where they lie, never copied.

use super::chance::digest;
use super::read_picture;
use anyhow::{Context, bail};
use defect_classifier::features::{self, Hidden, Measured};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::{Duration, Instant};

/// Digests of the pictures that the committed network was trained with.
pub(super) const SEEN: &str = "photograph_seen.json";

/// A labelled picture.
#[derive(Debug, Clone)]
pub(super) struct Photograph {
    pub(super) class: String,
    pub(super) group: String,
    pub(super) source: String,
    pub(super) licence: String,
    pub(super) digest: u64,
    pub(super) values: Vec<f64>,
    /// Time that its features took.
    pub(super) took: Duration,
}

/// A labelled set.
#[derive(Debug, Clone, Default)]
pub(super) struct Set {
    pub(super) photographs: Vec<Photograph>,
    /// Files of the manifest that the network had been trained with.
    pub(super) left_out: usize,
    /// Rows that name a file that an earlier row named.
    pub(super) merged: usize,
}

/// A row of a manifest; other columns are left alone.
#[derive(Debug, Deserialize)]
struct Row {
    file: String,
    class: String,
    #[serde(default)]
    group: String,
    #[serde(default)]
    source_repo: String,
    #[serde(default)]
    licence: String,
}

/// Digests of a file like [`SEEN`]; none where it does not exist.
///
/// # Errors
/// A file that is no list of digests.
pub(super) fn seen(folder: &Path) -> anyhow::Result<Vec<u64>> {
    let path = folder.join(SEEN);
    if !path.is_file() {
        return Ok(vec![]);
    }
    let context = || path.display().to_string();
    let listed: Vec<String> =
        serde_json::from_slice(&std::fs::read(&path).with_context(context)?).with_context(context)?;
    listed.iter().map(|text| u64::from_str_radix(text, 16).with_context(context)).collect()
}

/// Writes a file like [`SEEN`].
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write_seen(folder: &Path, digests: BTreeSet<u64>) -> anyhow::Result<()> {
    let listed: Vec<String> = digests.iter().map(|digest| format!("{digest:016x}")).collect();
    let path = folder.join(SEEN);
    std::fs::write(&path, serde_json::to_string_pretty(&listed)? + "\n")
        .with_context(|| path.display().to_string())
}

/// Features of every picture of a manifest but those whose digest is among `seen`.
///
/// # Errors
/// A manifest or a picture that is missing or cannot be read, two labels for one file.
pub(super) fn read(manifest: &Path, hidden: Hidden, seen: &[u64]) -> anyhow::Result<Set> {
    let context = || manifest.display().to_string();
    if !manifest.is_file() {
        bail!("{} is absent: the labelled photographs are not part of this repository", context());
    }
    let folder = manifest.parent().unwrap_or(Path::new("."));
    let mut table = csv::Reader::from_path(manifest).with_context(context)?;
    let mut set = Set::default();
    let mut labels: BTreeMap<String, String> = BTreeMap::new();
    for row in table.deserialize() {
        let Row { file, class, group, source_repo, licence } = row.with_context(context)?;
        if let Some(before) = labels.insert(file.clone(), class.clone()) {
            if before != class {
                bail!("{}: {file} is labelled {before} and {class}", context());
            }
            set.merged += 1;
            continue;
        }
        let bytes = read_picture(&folder.join(&file))?;
        let digest = digest(&bytes);
        if seen.contains(&digest) {
            set.left_out += 1;
            continue;
        }
        let start = Instant::now();
        let values =
            features::extract_encoded(&bytes, hidden, &Measured::default()).with_context(|| file.clone())?;
        set.photographs.push(Photograph {
            class,
            group: if group.is_empty() { file } else { group },
            source: source_repo,
            licence,
            digest,
            values,
            took: start.elapsed(),
        });
    }
    Ok(set)
}

#[cfg(test)]
mod tests;
