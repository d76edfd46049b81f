//! T1, T3, T4: a disk that is full or slow, a wall clock that is set.

use super::observer::Seen;
use super::outcome::Observed;
use super::session::Session;
use super::shim::Shim;
use crate::faults::catalogue::{DiskAnswer, Reaction};
use crate::up::fleet::Happening;
use anyhow::Context;
use fdm_loop_msgs::{DiagnosticArray, DiagnosticStatus};
use rustix::io::Errno;
use std::collections::BTreeMap;
use std::path::Path;

/// The node whose disk it is.
pub(super) const RECORDER: &str = "bag_recorder";
/// Longest wait for a recorder that records again `[s]`.
const PATIENCE_S: f64 = 15.0;
/// The printer's states come at 50 Hz; a stall is a gap of so long `[s]`.
const STALL_S: f64 = 0.5;

fn shim(session: &Session) -> anyhow::Result<&Shim> {
    session.graph.shim.as_ref().context("this graph has its disk and clock from the system")
}

/// T1: the recorder's disk refuses for a while. It says so, ends, is started again, and records when there is room.
pub(super) async fn full(
    session: &mut Session,
    (for_s, answer): (f64, DiskAnswer),
) -> anyhow::Result<Observed> {
    let mut watcher = session.watcher();
    shim(session)?.set_error(Some(match answer {
        DiskAnswer::Full => Errno::NOSPC,
        DiskAnswer::IoError => Errno::IO,
        DiskAnswer::ReadOnly => Errno::ROFS,
    }))?;
    let (mut told, mut ended) = (None, false);
    let mut look = |at, seen: &Seen| {
        watcher.take(at, seen);
        ended |= matches!(seen, Seen::Happened(Happening::Ended { name, .. }) if *name == RECORDER);
        if matches!(seen, Seen::Report(report) if says_failed(report)) {
            told.get_or_insert(watcher.since(at));
        }
    };
    session
        .until(for_s, |at, seen| {
            look(at, seen);
            false
        })
        .await?;
    shim(session)?.set_error(None)?;
    let room = session.observer.now();
    let records = |seen: &Seen| matches!(seen, Seen::Report(report) if says_recording(report));
    let again = session
        .until(PATIENCE_S, |at, seen| {
            look(at, seen);
            records(seen)
        })
        .await?;
    let mut observed = Observed::of(&watcher);
    observed.told_s = told;
    if !ended {
        observed.wrong.push(format!("{RECORDER} did not end"));
    }
    observed.recovered_s = again.then(|| (session.observer.now() - room).0);
    Ok(observed)
}

/// Whether the recorder itself says that it records no more, and of what.
fn says_failed(report: &DiagnosticArray) -> bool {
    let failed = |status: &DiagnosticStatus| {
        status.name.ends_with(RECORDER)
            && status.level == DiagnosticStatus::ERROR
            && status.message.starts_with("not recording: ")
    };
    report.status.iter().any(failed)
}

fn says_recording(report: &DiagnosticArray) -> bool {
    report.status.iter().any(|status| status.name.ends_with(RECORDER) && status.message == "recording")
}

/// T4: each write and sync of the recorder takes its time. Pictures are dropped, the rest waits.
pub(super) async fn slow(session: &mut Session, delay_s: f64, for_s: f64) -> anyhow::Result<Observed> {
    let mut watcher = session.watcher();
    let mut dropped: BTreeMap<String, f64> = BTreeMap::new();
    shim(session)?.set_delay(delay_s)?;
    session
        .until(for_s, |at, seen| {
            watcher.take(at, seen);
            note_dropped(&mut dropped, seen);
            false
        })
        .await?;
    shim(session)?.set_delay(0.0)?;
    // What was being written takes its time still, and the next report comes a second later.
    let after_s = delay_s + 2.0;
    session
        .until(after_s, |at, seen| {
            watcher.take(at, seen);
            note_dropped(&mut dropped, seen);
            false
        })
        .await?;
    let (mut pictures, mut others) = (0.0, 0.0);
    for (topic, count) in &dropped {
        *if topic.ends_with("compressed") { &mut pictures } else { &mut others } += count;
    }
    let mut observed = Observed::of(&watcher);
    observed.figures.extend([("pictures_dropped", pictures), ("others_dropped", others)]);
    if pictures < 1.0 || others > 0.0 {
        observed.wrong.push(format!("{pictures} pictures and {others} other messages were dropped"));
    }
    Ok(observed)
}

/// Notes what the recorder says of dropped messages, by topic.
fn note_dropped(dropped: &mut BTreeMap<String, f64>, seen: &Seen) {
    let Seen::Report(report) = seen else { return };
    for status in report.status.iter().filter(|status| status.name.ends_with(RECORDER)) {
        for value in &status.values {
            if let (Some(topic), Ok(count)) = (value.key.strip_suffix(" dropped"), value.value.parse()) {
                dropped.insert(topic.to_owned(), count);
            }
        }
    }
}

/// T3: the wall clock of all nodes is set to one offset after the other, and stays there. Where that may not pass
/// unnoticed, the time until all is whole again counts.
pub(super) async fn step_clock(
    session: &mut Session,
    reaction: Reaction,
    (to_s, each_s): (&[f64], f64),
) -> anyhow::Result<Observed> {
    let mut watcher = session.watcher();
    let begin = session.observer.now();
    for offset_s in to_s {
        shim(session)?.set_wall(*offset_s)?;
        session.watch(&mut watcher, each_s).await?;
    }
    let mut observed = Observed::of(&watcher);
    observed.figures.insert("printer_state_gap_s", watcher.gap_s);
    if watcher.gap_s > STALL_S {
        observed.wrong.push(format!("the printer was not heard for {:.2} s", watcher.gap_s));
    }
    if reaction != Reaction::None {
        session.whole().await?;
        observed.reaction_s = watcher.neutral;
        observed.recovered_s = Some((session.observer.now() - begin).0);
    } else if !watcher.fallen.is_empty() {
        observed.wrong.push(format!("ended or fell silent: {}", watcher.fallen.join(" ")));
    }
    Ok(observed)
}

/// What is wrong with a bag that is complete.
pub(super) fn complaint_of(bag: &Path) -> Option<String> {
    match read_bag(bag) {
        Ok(0) => Some("the bag holds nothing".to_owned()),
        Ok(_) => None,
        Err(error) => Some(format!("the bag: {error:#}")),
    }
}

/// Messages in the bag; its times never fall within a file.
fn read_bag(bag: &Path) -> anyhow::Result<u64> {
    let mut messages = 0;
    for entry in std::fs::read_dir(bag).with_context(|| bag.display().to_string())? {
        let path = entry?.path();
        if path.extension().is_none_or(|extension| extension != "mcap") {
            continue;
        }
        let bytes = std::fs::read(&path)?;
        let mut newest = 0;
        for message in mcap::MessageStream::new(&bytes).with_context(|| path.display().to_string())? {
            let message = message.with_context(|| path.display().to_string())?;
            anyhow::ensure!(message.log_time >= newest, "{}: time falls back", path.display());
            newest = message.log_time;
            messages += 1;
        }
    }
    Ok(messages)
}
