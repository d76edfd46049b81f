//! The threads of a recorder: one writes, one waits for the disk, one closes files, compacts them and keeps room, and at
//! the start one recovers what a kill left.

mod closer;
mod pen;
mod queue;

pub use queue::{Item, Queue, Sample, Wish};

use crate::clock;
use crate::contents::Channel;
use crate::error::RecorderError;
use crate::folder::Folder;
use crate::params::{Room, Snapshot, Split};
use crate::recovery;
use crate::tally::Tally;
use closer::Closer;
use models::units::Seconds;
use pen::Pen;
use std::collections::BTreeMap;
use std::fs::File;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread::JoinHandle;
use std::time::Duration;

/// A topic that is recorded.
#[derive(Debug, Clone)]
pub struct Recorded {
    /// How the bag names it.
    pub channel: Channel,
    /// Schema text.
    pub schema: String,
}

/// What the writer is told at the start.
#[derive(Debug)]
pub struct Settings {
    /// The topics, by the numbers of the samples.
    pub topics: Vec<Recorded>,
    /// Where it counts.
    pub tally: Arc<Tally>,
    /// What each file says of recorder and print.
    pub note: BTreeMap<String, String>,
    /// Messages that may wait.
    pub queue_length: usize,
    /// Between two syncs.
    pub sync_period: Duration,
    /// A message later than this behind the newest begins a new file.
    pub late_max: Seconds,
    /// When a file ends.
    pub split: Split,
    /// What may be dropped for room.
    pub room: Room,
    /// What is kept while nothing is written.
    pub snapshot: Snapshot,
    /// Time at the end for compacting.
    pub compact_end: Duration,
}

/// The running threads.
pub struct Recorder {
    folder: Folder,
    queue: Queue,
    writer: JoinHandle<Result<(), RecorderError>>,
    syncer: JoinHandle<()>,
    recoverer: JoinHandle<()>,
    stop_recovery: Arc<AtomicBool>,
    closer: JoinHandle<()>,
    closed: Receiver<()>,
    stop_closer: Arc<AtomicBool>,
    compact_end: Duration,
}

impl Recorder {
    /// Begins the next file of the folder. Leftovers of a kill are recovered beside it: nothing waits for them.
    ///
    /// # Errors
    /// A folder that cannot be listed or written to, or has times of another clock.
    pub fn start(folder: Folder, settings: Settings) -> Result<Self, RecorderError> {
        let survey = folder.survey()?;
        clock::check(&folder, &survey, &settings.note)?;
        let tally = Arc::clone(&settings.tally);
        let plain = take_in(&folder, &survey.finished, &tally)?;
        let (queue, items) = Queue::new(settings.queue_length);
        let (files, opened) = mpsc::channel();
        let (period, sync_tally) = (settings.sync_period, Arc::clone(&tally));
        let syncer = spawn("sync", move || sync(&opened, period, &sync_tally))?;
        let (ended, to_close) = mpsc::channel();
        let (done, closed) = mpsc::channel();
        let (compact_end, stop_closer) = (settings.compact_end, Arc::new(AtomicBool::new(false)));
        let closer = Closer {
            folder: folder.clone(),
            tally: Arc::clone(&tally),
            room: settings.room,
            stop: Arc::clone(&stop_closer),
            plain,
        };
        let pen = Pen::begin(folder.clone(), settings, (files, ended), survey.next)?;
        let waiting = queue.count();
        let writer = spawn("writer", move || pen.run(&items, &waiting))?;
        let closer = spawn("closer", move || closer.run(&to_close, &done))?;
        let stop_recovery = Arc::new(AtomicBool::new(false));
        let (stop, recovering) = (Arc::clone(&stop_recovery), folder.clone());
        let recoverer = spawn("recovery", move || {
            recovery::recover_all(&recovering, &survey.leftover, &tally, &stop);
        })?;
        Ok(Self {
            folder,
            queue,
            writer,
            syncer,
            recoverer,
            stop_recovery,
            closer,
            closed,
            stop_closer,
            compact_end,
        })
    }

    /// The queue to the writer.
    #[must_use]
    pub fn queue(&self) -> Queue {
        self.queue.clone()
    }

    /// Whether the writer ended by itself: it failed.
    #[must_use]
    pub fn has_failed(&self) -> bool {
        self.writer.is_finished()
    }

    /// Finishes the file, and compacts it as far as there is time. Every other end of the queue must be gone.
    ///
    /// # Errors
    /// What the writer failed of.
    pub fn finish(self) -> Result<(), RecorderError> {
        self.stop_recovery.store(true, Ordering::Relaxed);
        drop(self.queue);
        _ = self.recoverer.join();
        let written =
            self.writer.join().unwrap_or(Err(RecorderError::Thread("the writer thread ended early")));
        // The last file is closed by now, or will be; what is not compacted then stays plain until the next start.
        _ = self.closed.recv_timeout(self.compact_end);
        self.stop_closer.store(true, Ordering::Relaxed);
        _ = self.closer.join();
        _ = self.syncer.join();
        written.and_then(|()| self.folder.set_active(None))
    }
}

/// Lists what earlier runs finished; returns the numbers of files that are not compacted yet.
fn take_in(folder: &Folder, finished: &[u32], tally: &Tally) -> Result<Vec<u32>, RecorderError> {
    let mut plain = Vec::new();
    for number in finished {
        match recovery::read_finished(folder, *number) {
            Ok(read) => {
                if !read.indexed {
                    plain.push(*number);
                }
                folder.add(read.contents)?;
            }
            Err(error) => {
                tally.unreadable.add(1);
                tracing::error!("{error}: not listed in metadata.yaml");
            }
        }
    }
    Ok(plain)
}

/// Starts a thread.
fn spawn<T: Send + 'static>(
    name: &str,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<JoinHandle<T>, RecorderError> {
    std::thread::Builder::new()
        .name(name.to_owned())
        .spawn(work)
        .map_err(|_| RecorderError::Thread("cannot start a thread"))
}

/// Waits for the disk once a period, apart from the thread that writes: a sync takes up to 30 ms.
fn sync(opened: &Receiver<File>, period: Duration, tally: &Tally) {
    let mut newest: Option<File> = None;
    loop {
        match opened.recv_timeout(period) {
            Ok(file) => {
                // Of a file that has ended everything is on disk from here on, whoever closes it and when.
                if newest.replace(file).is_some_and(|ended| ended.sync_data().is_err()) {
                    tally.sync_failed.add(1);
                }
                tally.synced_bytes.store(0, Ordering::Relaxed);
            }
            Err(RecvTimeoutError::Timeout) => {
                let Some(file) = &newest else { continue };
                // What is written by now is on disk when the sync returns.
                let bytes = file.metadata().map_or(0, |found| found.len());
                match file.sync_data() {
                    Ok(()) => tally.synced_bytes.store(bytes, Ordering::Relaxed),
                    Err(_) => tally.sync_failed.add(1),
                }
            }
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

#[cfg(test)]
mod tests;
