//! `fdm recover`: what a kill left becomes a bag that every reader opens.

use crate::output::{self, Json};
use anyhow::{Context, bail};
use bag_recorder::error::RecorderError;
use bag_recorder::folder::Folder;
use bag_recorder::recovery::{self, Finished, Recovered};
use bag_recorder::tally::Tally;
use bag_recorder::walk::{Sum, Walked};
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
    /// Messages that are lost, as far as the files say how many they had.
    lost_messages: u64,
    /// Bytes that could not be read.
    lost_bytes: u64,
    files: Vec<File>,
}

#[derive(Debug, Default, Serialize)]
struct File {
    name: String,
    messages: Option<u64>,
    /// `None` where the file does not say how many it had.
    lost_messages: Option<u64>,
    lost_bytes: u64,
    /// Places before the file's end that could not be read.
    damages: u64,
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
            let File { name, messages, outcome, why, .. } = file;
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
            Ok(file) => File { name, ..file },
            Err(error) => {
                let cause = error.source().map_or_else(String::new, |cause| format!(": {cause}"));
                File { name, outcome: "unreadable", why: format!("{error}{cause}"), ..File::default() }
            }
        };
        figures.lost_messages += file.lost_messages.unwrap_or(0);
        figures.lost_bytes += file.lost_bytes;
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
fn one(folder: &Folder, number: u32, left: bool, go_on: &AtomicBool) -> Result<File, RecorderError> {
    if left {
        let made = recovery::recover(folder, number, go_on)?;
        return Ok(saved(made.as_ref(), |walked| walked.damages > 0));
    }
    // Every record is looked at: a summary knows nothing of what has become of the data since.
    let is_sound = recovery::check(folder, number).is_ok_and(|walked| walked.is_sound());
    let read = recovery::read_finished(folder, number).ok().filter(|_| is_sound);
    let Some(Finished { contents, indexed }) = read else {
        let made = recovery::salvage(folder, number, go_on)?;
        return Ok(saved(made.as_ref(), |_| true));
    };
    let whole = |outcome, messages| File {
        messages: Some(messages),
        lost_messages: Some(0),
        outcome,
        ..File::default()
    };
    let messages = contents.total();
    folder.add(contents)?;
    if indexed {
        return Ok(whole("sound", messages));
    }
    recovery::compact(folder, number, go_on)?;
    Ok(whole("compacted", messages))
}

/// A file that was made anew; `is_kept` says whether the old one is there still.
fn saved(made: Option<&Recovered>, is_kept: impl Fn(&Walked) -> bool) -> File {
    let Some(Recovered { messages, walked }) = made else {
        return File { messages: Some(0), outcome: "recovered", ..File::default() };
    };
    let changed = (walked.damages == 0 && walked.sum == Sum::Differs).then(|| {
        "does not fit the checksum of its data: something in it was changed, which record cannot be told"
            .to_owned()
    });
    let kept = is_kept(walked).then(|| "the original is kept with the ending .torn".to_owned());
    let why: Vec<String> = [walked.damage_in_words(), changed, kept].into_iter().flatten().collect();
    File {
        messages: Some(*messages),
        lost_messages: walked.lost_messages(),
        lost_bytes: walked.lost_bytes,
        damages: walked.damages,
        outcome: "recovered",
        why: why.join("; "),
        ..File::default()
    }
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
