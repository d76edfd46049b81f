//! A bag has one clock: nobody can tell later which of its times are of which.

use crate::error::RecorderError;
use crate::file::NOTE;
use crate::folder::Folder;
use crate::layout::Survey;
use crate::record;
use crate::walk::Walk;
use mcap::records::{Record, op};
use std::collections::BTreeMap;
use std::path::Path;

/// Under this key a note names the clock of its file's times.
pub(crate) const CLOCK: &str = "clock";
/// Times of `/clock`.
pub(crate) const SIMULATED: &str = "simulated";
/// Times since the host's start.
pub(crate) const MONOTONIC: &str = "monotonic";

/// Refuses a folder whose newest file has times of another clock than this run's, as its note names it. A file that does
/// not say, or cannot be read, is none of ours to judge.
pub(crate) fn check(
    folder: &Folder,
    survey: &Survey,
    note: &BTreeMap<String, String>,
) -> Result<(), RecorderError> {
    let Some(&number) = survey.finished.iter().chain(&survey.leftover).max() else { return Ok(()) };
    let layout = folder.layout();
    let name =
        if survey.leftover.contains(&number) { layout.active(number) } else { layout.finished(number) };
    let file = folder.path(&name);
    let was = clock_of(&file).unwrap_or_default();
    match (was, note.get(CLOCK)) {
        (Some(was), Some(is)) if was != *is => Err(RecorderError::OtherClock { file, was, is: is.clone() }),
        _ => Ok(()),
    }
}

/// The clock that the first note of a file names.
fn clock_of(path: &Path) -> std::io::Result<Option<String>> {
    let Some(mut walk) = Walk::open(path)? else { return Ok(None) };
    while let Some((opcode, fields)) = walk.next_record()? {
        if opcode == op::MESSAGE {
            break;
        }
        match record::parse(opcode, fields) {
            Ok(Record::Metadata(mut note)) if note.name == NOTE => return Ok(note.metadata.remove(CLOCK)),
            Ok(_) => {}
            Err(_) => walk.reject(),
        }
    }
    Ok(None)
}
