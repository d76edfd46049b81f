//! `fdm recover`: what a kill left becomes a bag that every reader opens.

use crate::output::{self, Json};
use anyhow::{Context, bail};
use bag_recorder::folder::Folder;
use bag_recorder::recovery;
use bag_recorder::tally::Tally;
use clap::Args;
use serde::Serialize;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Mends a bag after a crash: whole records of what was being written become a closed file, all files are indexed.
#[derive(Debug, Args)]
pub struct RecoverArgs {
    /// Folder of the bag.
    bag: PathBuf,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// What became of a bag.
#[derive(Debug, Default, Serialize)]
struct Figures {
    bag: String,
    messages: u64,
    files: Vec<File>,
}

#[derive(Debug, Serialize)]
struct File {
    name: String,
    messages: Option<u64>,
    /// `recovered`, `compacted`, `sound` or `unreadable`.
    outcome: &'static str,
    why: String,
}

/// A file could not be read: exit code 1.
#[derive(Debug)]
pub struct Unreadable(String);

impl std::fmt::Display for Unreadable {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl Error for Unreadable {}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &RecoverArgs) -> anyhow::Result<()> {
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let figures = recover(&args.bag)?;
    if !json.is_stdout() {
        let line = |file: &File| {
            let File { name, messages, outcome, why } = file;
            let messages = messages.map_or_else(String::new, |count| format!("{count} messages"));
            format!("  {name:<40} {messages:>20}  {outcome} {why}").trim_end().to_owned()
        };
        let files: Vec<String> = figures.files.iter().map(line).collect();
        output::line(&format!("{}: {} messages\n{}", figures.bag, figures.messages, files.join("\n")))?;
    }
    json.write(&figures)?;
    match figures.files.iter().find(|file| file.outcome == "unreadable") {
        Some(file) => Err(Unreadable(format!("{}: {} {}", figures.bag, file.name, file.why)).into()),
        None => Ok(()),
    }
}

/// Recovers a bag; returns its messages.
pub(crate) fn messages(bag: &Path) -> anyhow::Result<u64> {
    let figures = recover(bag)?;
    match figures.files.iter().find(|file| file.outcome == "unreadable") {
        Some(file) => bail!("{}: {} {}", figures.bag, file.name, file.why),
        None => Ok(figures.messages),
    }
}

fn recover(bag: &Path) -> anyhow::Result<Figures> {
    let failed = || bag.display().to_string();
    if !std::fs::metadata(bag).with_context(failed)?.is_dir() {
        bail!("{}: must be the folder of a bag", bag.display());
    }
    let folder = Folder::open(bag, &name_of(bag)?, Arc::new(Tally::new(0)))?;
    let survey = folder.survey()?;
    let mut figures = Figures { bag: bag.display().to_string(), ..Figures::default() };
    let go_on = AtomicBool::new(false);
    let mut numbers: Vec<(u32, bool)> = survey.finished.iter().map(|number| (*number, false)).collect();
    numbers.extend(survey.leftover.iter().map(|number| (*number, true)));
    numbers.sort_unstable();
    for (number, left) in numbers {
        let name = folder.layout().finished(number);
        let file = match one(&folder, number, left, &go_on) {
            Ok((messages, outcome)) => File { name, messages: Some(messages), outcome, why: String::new() },
            Err(error) => {
                let cause = error.source().map_or_else(String::new, |cause| format!(": {cause}"));
                File { name, messages: None, outcome: "unreadable", why: format!("{error}{cause}") }
            }
        };
        figures.messages += file.messages.unwrap_or(0);
        figures.files.push(file);
    }
    // What the bag says of a file that could not be read stands.
    if figures.files.iter().all(|file| file.outcome != "unreadable") {
        folder.set_active(None)?;
    }
    Ok(figures)
}

/// Mends one file.
fn one(
    folder: &Folder,
    number: u32,
    left: bool,
    go_on: &AtomicBool,
) -> Result<(u64, &'static str), bag_recorder::error::RecorderError> {
    if left {
        let messages = recovery::recover(folder, number, go_on)?;
        return Ok((messages.unwrap_or(0), "recovered"));
    }
    let read = match recovery::read_finished(folder, number) {
        Ok(read) => read,
        Err(_) => {
            let salvaged = recovery::salvage(folder, number, go_on)?;
            return Ok((salvaged.unwrap_or(0), "recovered"));
        }
    };
    let messages = read.contents.total();
    folder.add(read.contents)?;
    if read.indexed {
        return Ok((messages, "sound"));
    }
    recovery::compact(folder, number, go_on)?;
    Ok((messages, "compacted"))
}

/// What the files of a bag begin with; the folder may have been renamed.
fn name_of(bag: &Path) -> anyhow::Result<String> {
    for entry in std::fs::read_dir(bag).with_context(|| bag.display().to_string())? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        let stem = name.strip_suffix(".active").unwrap_or(&name).strip_suffix(".mcap");
        let parts = stem.and_then(|stem| stem.rsplit_once('_'));
        if let Some((bag, number)) = parts
            && number.parse::<u32>().is_ok()
        {
            return Ok(bag.to_owned());
        }
    }
    bail!("{}: no .mcap file of a recorder in this folder", bag.display())
}
