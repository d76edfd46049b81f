//! `fdm recover`: what a kill left becomes a bag that every reader opens.

use crate::output::{self, Failed, Json};
use crate::report::stated::Stated;
use anyhow::{Context, bail};
use bag_recorder::error::RecorderError;
use bag_recorder::folder::Folder;
use bag_recorder::metadata::RunCounts;
use bag_recorder::recovery::{self, Finished, Recovered};
use bag_recorder::tally::Tally;
use bag_recorder::walk::{Sum, Walked};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

mod file;
mod names;

use file::{File, failed_of};

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
    match figures.files.iter().find(|file| !file.is_mended()) {
        Some(file) => Err(Failed(format!("{}: {} {}", figures.bag, file.name, file.why)).into()),
        None => Ok(()),
    }
}

/// Recovers a bag; returns its messages.
pub(crate) fn messages(bag: &Path) -> anyhow::Result<u64> {
    let figures = recover(bag)?;
    match figures.files.iter().find(|file| !file.is_mended()) {
        Some(file) => bail!("{}: {} {}", figures.bag, file.name, file.why),
        None => Ok(figures.messages),
    }
}

/// Recovers a bag in which a kill left a file that is not closed; `None` where there is none.
pub(crate) fn leftover(bag: &Path) -> anyhow::Result<Option<u64>> {
    let Ok(mut entries) = std::fs::read_dir(bag) else { return Ok(None) };
    let is_open =
        |entry: &std::fs::DirEntry| entry.path().extension().is_some_and(|ending| ending == "active");
    if entries.any(|entry| entry.is_ok_and(|entry| is_open(&entry))) {
        messages(bag).map(Some)
    } else {
        Ok(None)
    }
}

fn recover(bag: &Path) -> anyhow::Result<Figures> {
    let failed = || bag.display().to_string();
    if !std::fs::metadata(bag).with_context(failed)?.is_dir() {
        bail!("{}: must be the folder of a bag", bag.display());
    }
    let stated = Stated::of(bag);
    let run = stated.counts.as_ref().map_or_else(RunCounts::default, |counts| counts.run.clone().into());
    let folder = Folder::open_as(bag, names::of(bag)?, Arc::new(Tally::after(run)))?;
    let survey = folder.survey()?;
    let mut numbers: Vec<(u32, bool)> = survey.finished.iter().map(|number| (*number, false)).collect();
    numbers.extend(survey.leftover.iter().map(|number| (*number, true)));
    numbers.sort_unstable();
    // Everything is looked at before anything is changed.
    let found: Vec<Found> = numbers.into_iter().map(|(number, left)| look(&folder, number, left)).collect();
    let mut figures = Figures { bag: bag.display().to_string(), ..Figures::default() };
    let changes = found.iter().any(|found| !matches!(found.state, State::Sound(_) | State::Foreign(_)));
    if changes {
        folder.keep_description()?;
    }
    for Found { number, state } in found {
        let layout = folder.layout();
        let name = layout.finished(number);
        let file = match mend(&folder, number, state) {
            Ok(file) => file.beside(stated.of_file(&name)),
            Err(error) => {
                failed_of(&error, &folder, &[folder.path(&name), folder.path(&layout.active(number))])
            }
        };
        figures.lost_messages += file.lost_messages.unwrap_or(0);
        figures.lost_bytes += file.lost_bytes;
        figures.messages += file.messages.unwrap_or(0);
        figures.files.push(File { name, ..file });
    }
    // What the bag says of a file that could not be read stands, and what another program says of a sound one.
    let read = figures.files.iter().all(File::is_mended);
    if read && (changes || !folder.path("metadata.yaml").exists() || folder.path("counts.json").exists()) {
        folder.set_active(None)?;
    }
    Ok(figures)
}

/// A file of a bag as it is found.
struct Found {
    number: u32,
    state: State,
}

enum State {
    /// Whole, with an index: its messages.
    Sound(u64),
    /// Whole, without an index: its messages.
    Plain(u64),
    /// Finished, and cut off or changed since.
    Unsound,
    /// What a kill left.
    Leftover,
    /// It holds what mending would lose: it stays as it is.
    Foreign(RecorderError),
}

/// Looks at every record of a file: a summary knows nothing of what has become of the data since.
fn look(folder: &Folder, number: u32, left: bool) -> Found {
    let layout = folder.layout();
    let path = folder.path(&if left { layout.active(number) } else { layout.finished(number) });
    let is_sound = match recovery::look(&path) {
        Err(foreign @ RecorderError::Foreign { .. }) => {
            // The bag is described with it.
            recovery::read_finished(folder, number).into_iter().for_each(|read| folder.know(read.contents));
            return Found { number, state: State::Foreign(foreign) };
        }
        looked => looked.is_ok_and(|walked| walked.is_sound()),
    };
    if left {
        return Found { number, state: State::Leftover };
    }
    let read = recovery::read_finished(folder, number).ok().filter(|_| is_sound);
    let Some(Finished { contents, indexed }) = read else {
        return Found { number, state: State::Unsound };
    };
    let messages = contents.total();
    folder.know(contents);
    Found { number, state: if indexed { State::Sound(messages) } else { State::Plain(messages) } }
}

/// Mends one file.
fn mend(folder: &Folder, number: u32, state: State) -> Result<File, RecorderError> {
    let go_on = AtomicBool::new(false);
    let whole = |outcome, messages| File {
        messages: Some(messages),
        lost_messages: Some(0),
        outcome,
        ..File::default()
    };
    match state {
        State::Leftover => {
            let made = recovery::recover(folder, number, &go_on)?;
            Ok(saved(made.as_ref(), Walked::is_damaged))
        }
        State::Unsound => Ok(saved(recovery::salvage(folder, number, &go_on)?.as_ref(), |_| true)),
        State::Foreign(error) => Err(error),
        State::Sound(messages) => Ok(whole("sound", messages)),
        State::Plain(messages) => {
            recovery::compact(folder, number, &go_on)?;
            Ok(whole("compacted", messages))
        }
    }
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

#[cfg(test)]
mod tests;
