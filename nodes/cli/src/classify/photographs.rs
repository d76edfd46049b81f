//! Photographs with labels: read where they lie, never copied.

use super::chance::digest;
use super::figures::STRAND;
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
    /// Rows that name a file or a picture that an earlier row named.
    pub(super) merged: usize,
    /// Files of each label, those left out among them.
    pub(super) labels: BTreeMap<String, usize>,
}

impl Set {
    /// Labels that are neither a class nor one of two classes that look alike, with their files.
    pub(super) fn unknown_labels(&self, classes: &[String]) -> BTreeMap<String, usize> {
        let known = |label: &String| classes.contains(label) || STRAND.contains(&label.as_str());
        self.labels
            .iter()
            .filter(|(label, _)| !known(label))
            .map(|(label, files)| (label.clone(), *files))
            .collect()
    }

    /// Refuses a set of which a network with these classes can say nothing.
    ///
    /// # Errors
    /// The labels that there are beside those that are known.
    pub(super) fn check_labels(&self, classes: &[String]) -> anyhow::Result<()> {
        if self.unknown_labels(classes).len() < self.labels.len() {
            return Ok(());
        }
        let there: Vec<&str> = self.labels.keys().map(String::as_str).collect();
        bail!(
            "no picture has a class of the network: there are {}; it knows {}",
            there.join(", "),
            classes.join(", ")
        )
    }
}

/// A line for people; none where every label is known.
pub(super) fn labels_text(unknown: &BTreeMap<String, usize>) -> String {
    if unknown.is_empty() {
        return String::new();
    }
    let named: Vec<String> = unknown.iter().map(|(label, files)| format!("{label} {files}")).collect();
    format!("labels that the network does not know, by files: {}\n", named.join(", "))
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
        serde_json::from_str(&runtime::input::text(&path).with_context(context)?).with_context(context)?;
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
/// A manifest or a picture that is missing or cannot be read, two labels for one picture, a manifest without rows.
pub(super) fn read(manifest: &Path, hidden: Hidden, seen: &[u64]) -> anyhow::Result<Set> {
    let context = || manifest.display().to_string();
    if !manifest.exists() {
        bail!("{} is absent: the labelled photographs are not part of this repository", context());
    }
    let folder = manifest.parent().unwrap_or(Path::new("."));
    let text = runtime::input::text(manifest).with_context(context)?;
    let mut table = csv::Reader::from_reader(text.as_bytes());
    let mut set = Set::default();
    let mut labels: BTreeMap<String, String> = BTreeMap::new();
    let mut pictures: BTreeMap<u64, (String, String)> = BTreeMap::new();
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
        if let Some((name, label)) = pictures.insert(digest, (file.clone(), class.clone())) {
            if label != class {
                bail!("{}: {name} and {file} are one picture, labelled {label} and {class}", context());
            }
            set.merged += 1;
            continue;
        }
        *set.labels.entry(class.clone()).or_default() += 1;
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
    if labels.is_empty() {
        bail!("{}: there is no row below its head", context());
    }
    Ok(set)
}

#[cfg(test)]
mod tests;
