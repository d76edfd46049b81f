//! The thread that closes files, compacts them and keeps room: all that may wait for a disk, away from the one that
//! writes.

use crate::error::RecorderError;
use crate::file::BagFile;
use crate::folder::Folder;
use crate::params::Room;
use crate::recovery;
use crate::retention::{Verdict, judge};
use crate::tally::Tally;
use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::Duration;

/// Real time between two looks at the room that is left.
const LOOK: Duration = Duration::from_millis(500);
/// How much the thread gives way to all others (`nice`): compacting has time.
const GIVES_WAY: i32 = 10;

/// What the closing thread has.
pub(super) struct Closer {
    pub(super) folder: Folder,
    pub(super) tally: Arc<Tally>,
    pub(super) room: Room,
    pub(super) stop: Arc<AtomicBool>,
    /// Files that are not compacted yet.
    pub(super) plain: Vec<u32>,
}

impl Closer {
    /// Works until the writer has gone and everything is compacted, or until it is stopped.
    pub(super) fn run(mut self, to_close: &Receiver<BagFile>, done: &Sender<()>) {
        // A host that does not allow it loses nothing but a little peace.
        _ = rustix::process::setpriority_process(None, GIVES_WAY);
        loop {
            match to_close.recv_timeout(if self.plain.is_empty() { LOOK } else { Duration::ZERO }) {
                Ok(file) => self.close(file),
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => self.compact_next(),
            }
            self.keep_room();
        }
        while !self.plain.is_empty() && !self.stop.load(Ordering::Relaxed) {
            self.compact_next();
        }
        // Who waits may have given up.
        _ = done.send(());
    }

    fn close(&mut self, file: BagFile) {
        let number = file.contents().number;
        let closed = file.finish().and_then(|contents| self.folder.add(contents));
        match closed {
            Ok(()) => self.plain.push(number),
            Err(error) => self.fail(&error),
        }
    }

    fn compact_next(&mut self) {
        if self.plain.is_empty() {
            return;
        }
        let number = self.plain.remove(0);
        match recovery::compact(&self.folder, number, &self.stop) {
            Ok(true) => self.tally.compacted.add(1),
            Ok(false) => {}
            Err(error) => self.fail(&error),
        }
    }

    /// Drops the oldest files until there is room, or nothing may go.
    fn keep_room(&mut self) {
        loop {
            let Ok(free_bytes) = self.folder.free_bytes() else { return };
            let verdict = judge(&self.room, &self.folder.held(), self.folder.active_bytes(), free_bytes);
            self.tally.full.store(verdict == Verdict::Full, Ordering::Relaxed);
            let Verdict::Drop(number) = verdict else { return };
            self.plain.retain(|plain| *plain != number);
            match self.folder.forget(number) {
                Ok(()) => {
                    self.tally.forgotten.add(1);
                    tracing::warn!("{}: dropped for room", self.folder.layout().finished(number));
                }
                Err(error) => return self.fail(&error),
            }
        }
    }

    fn fail(&self, error: &RecorderError) {
        self.tally.unreadable.add(1);
        let cause = error.source().map(ToString::to_string).unwrap_or_default();
        tracing::error!("{error}: {cause}");
    }
}
