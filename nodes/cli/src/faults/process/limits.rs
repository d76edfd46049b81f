//! L3, L4: a process gets no more memory, no more files.

use super::calls;
use super::observer::Seen;
use super::outcome::Observed;
use super::session::Session;
use crate::up::fleet::Happening;
use rustix::process::{Resource, Signal};

/// Memory and files that a process may have from now on: less than it has, so nothing more.
const NOTHING: u64 = 1;
/// Standard input, output and error: no further number is given out.
const STANDARD_FILES: u64 = 3;
/// Longest wait for a node's next run `[s]`.
const PATIENCE_S: f64 = 12.0;

/// L3: a node gets no more memory. It ends and is started again, or goes on with what it has.
pub(super) async fn memory(session: &mut Session, node: &str, for_s: f64) -> anyhow::Result<Observed> {
    let run = session.run_of(node);
    let mut watcher = session.watcher();
    for resource in [Resource::As, Resource::Data] {
        session.graph.limit(node, resource, NOTHING)?;
    }
    let ended = |seen: &Seen| matches!(seen, Seen::Happened(Happening::Ended { name, .. }) if *name == node);
    let mut told = None;
    let mut look = |at, seen: &Seen| {
        watcher.take(at, seen);
        if ended(seen) {
            told.get_or_insert(watcher.since(at));
        }
        ended(seen)
    };
    let died = session.until(for_s, &mut look).await?;
    if !died {
        // Its limit cannot be taken back: the next run has none.
        session.graph.signal(node, Signal::KILL)?;
    }
    let mut beats = false;
    session
        .until(PATIENCE_S, |at, seen| {
            look(at, seen);
            beats |= matches!(seen, Seen::Heart(name, next) if name == node && Some(*next) != run);
            beats
        })
        .await?;
    let begin = session.observer.now();
    session.whole().await?;
    let mut observed = Observed::of(&watcher);
    observed.told_s = told.filter(|_| died);
    observed.recovered_s = Some((session.observer.now() - begin).0);
    observed.figures.insert("died", f64::from(u8::from(died)));
    if !beats {
        observed.wrong.push(format!("{node} is not started again"));
    }
    Ok(observed)
}

/// L4: no node opens a file or socket any more. Control goes on; an emergency stop that cannot be written down stops.
pub(super) async fn files(session: &mut Session, for_s: f64) -> anyhow::Result<Observed> {
    for node in session.graph.pids().into_keys() {
        session.graph.limit(node, Resource::Nofile, STANDARD_FILES)?;
    }
    let mut watcher = session.watcher();
    session.watch(&mut watcher, for_s).await?;
    let before = watcher.affected();
    let mut observed = calls::stop_once(session).await?;
    if let Some(what) = before {
        observed.wrong.push(format!("control was affected before the stop: {what}"));
    }
    Ok(observed)
}
