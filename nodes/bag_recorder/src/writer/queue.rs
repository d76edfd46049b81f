//! What waits for the writer.

use crate::params::Split;
use models::units::Seconds;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};

/// What waits for the writer.
pub enum Item {
    /// A message.
    Message(Sample),
    /// Keys and values of a `fdm_loop` record.
    Note(BTreeMap<String, String>),
    /// What somebody asks for.
    Wish(Wish),
}

/// What somebody asks of the writer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// Write nothing.
    Pause,
    /// Write on.
    Resume,
    /// End the file and begin the next.
    Split,
    /// Write what is kept in memory to a file of its own; where everything is written, keep that file.
    Snapshot,
    /// End files by other limits from now on.
    SplitBy(Split),
    /// Keep the file that is being written and the one before it; a snapshot where nothing is written.
    Keep,
}

/// A message to be written.
pub struct Sample {
    /// Number of the topic.
    pub topic: usize,
    /// Time of receipt on the node's clock.
    pub received: Seconds,
    /// Time of sending by the publisher `[ns]`.
    pub publish_ns: Option<u64>,
    /// Number of the message by its publisher.
    pub sequence: u32,
    /// CDR with its encapsulation header.
    pub payload: Vec<u8>,
}

/// One end of the bounded queue to the writer; clones share it.
#[derive(Clone)]
pub struct Queue {
    sender: SyncSender<Item>,
    waiting: Arc<AtomicUsize>,
}

impl Queue {
    /// A queue for so many items, and its other end.
    pub(super) fn new(length: usize) -> (Self, Receiver<Item>) {
        let (sender, items) = mpsc::sync_channel(length);
        (Self { sender, waiting: Arc::default() }, items)
    }

    /// The count of items that wait, for who takes them out.
    pub(super) fn count(&self) -> Arc<AtomicUsize> {
        Arc::clone(&self.waiting)
    }

    /// Hands an item to the writer; false where the queue is full, or the writer has ended. Never waits.
    #[must_use]
    pub fn offer(&self, item: Item) -> bool {
        // Counted before: the writer may have taken it by the next line.
        self.waiting.fetch_add(1, Ordering::Relaxed);
        match self.sender.try_send(item) {
            Ok(()) => true,
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => {
                self.waiting.fetch_sub(1, Ordering::Relaxed);
                false
            }
        }
    }

    /// Items that wait.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.waiting.load(Ordering::Relaxed)
    }
}
