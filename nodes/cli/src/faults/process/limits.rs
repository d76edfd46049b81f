//! L3, L4: a process gets no more memory, no more files.

use super::observer::Seen;
use super::outcome::Observed;
use super::session::Session;
use super::stops;
use crate::up::fleet::Happening;
use rustix::process::{Resource, Signal};

/// Memory and files that a process may have from now on: less than it has, so nothing more.
const NOTHING: u64 = 1;
/// Standard input, output and error: no further number is given out.
const STANDARD_FILES: u64 = 3;
/// Longest wait for a node's next run `[s]`.
const PATIENCE_S: f64 = 12.0;

/// A node that lives on without memory beats at least so often `[s]`: ten of its beats.
const BEATS_S: f64 = 1.0;

/// L3: a node gets no more memory. Either the limit ends it, and it is started again; or it stays below the limit and works
/// on with what it has. One that grows all the same, or neither ends nor works, is a miss.
pub(super) async fn memory(session: &mut Session, node: &str, for_s: f64) -> anyhow::Result<Observed> {
    let run = session.run_of(node);
    let mut watcher = session.watcher();
    for resource in [Resource::As, Resource::Data] {
        session.graph.limit(node, resource, NOTHING)?;
    }
    let held_mib = session.graph.virtual_mib(node);
    let ended = |seen: &Seen| matches!(seen, Seen::Happened(Happening::Ended { name, .. }) if *name == node);
    let (mut told, mut newest) = (None, 0.0);
    let mut look = |at, seen: &Seen| {
        watcher.take(at, seen);
        if ended(seen) {
            told.get_or_insert(watcher.since(at));
        }
        if matches!(seen, Seen::Heart(name, beaten) if name == node && Some(*beaten) == run) {
            newest = watcher.since(at);
        }
        ended(seen)
    };
    let died = session.until(for_s, &mut look).await?;
    let grown_mib =
        session.graph.virtual_mib(node).zip(held_mib).map(|(now_mib, held_mib)| now_mib - held_mib);
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
    if !died {
        observed.figures.insert("grown_mib", grown_mib.unwrap_or(f64::INFINITY));
        observed.wrong.extend(unbounded(node, grown_mib, for_s - newest));
    }
    if !beats {
        observed.wrong.push(format!("{node} is not started again"));
    }
    Ok(observed)
}

/// What is wrong with a node that its limit did not end: by how much it has grown since `[MiB]`, and for how long its heart
/// had stood still at the end `[s]`.
fn unbounded(node: &str, grown_mib: Option<f64>, silent_s: f64) -> Option<String> {
    match grown_mib {
        None => Some(format!("{node} neither ended by its limit of memory nor is there to be looked at")),
        Some(grown_mib) if grown_mib > 0.0 => {
            Some(format!("{node} grew by {grown_mib:.1} MiB beyond its limit of memory"))
        }
        Some(_) if silent_s > BEATS_S => {
            Some(format!("{node} neither ended by its limit of memory nor worked on below it"))
        }
        Some(_) => None,
    }
}

/// L4: no node opens a file or socket any more. Control goes on; an emergency stop that cannot be written down stops.
pub(super) async fn files(session: &mut Session, for_s: f64) -> anyhow::Result<Observed> {
    for node in session.graph.pids().into_keys() {
        session.graph.limit(node, Resource::Nofile, STANDARD_FILES)?;
    }
    let mut watcher = session.watcher();
    session.watch(&mut watcher, for_s).await?;
    let before = watcher.affected();
    let mut observed = stops::stop_once(session).await?;
    if let Some(what) = before {
        observed.wrong.push(format!("control was affected before the stop: {what}"));
    }
    Ok(observed)
}

#[cfg(test)]
mod tests {
    use super::unbounded;

    /// L3: the trial is lost by a node that its limit neither ends nor bounds.
    #[test]
    fn a_node_that_outlives_its_memory_has_to_stay_below_it_and_work() {
        assert_eq!(unbounded("camera", Some(0.0), 0.3), None);
        assert_eq!(unbounded("camera", Some(-4.0), 0.3), None, "it gave some back");
        let told = |grown_mib, silent_s| unbounded("camera", grown_mib, silent_s).unwrap();
        assert_eq!(told(Some(1.5), 0.3), "camera grew by 1.5 MiB beyond its limit of memory");
        assert!(told(Some(0.0), 1.2).ends_with("nor worked on below it"));
        assert!(told(None, 0.3).contains("nor is there"));
    }
}
