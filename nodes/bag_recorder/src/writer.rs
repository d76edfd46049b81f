//! The thread that writes, and the one that waits for the disk.

use crate::contents::Channel;
use crate::error::RecorderError;
use crate::file::{BagFile, Form, NOTE, Stamp};
use crate::folder::Folder;
use crate::order::{Order, Place};
use crate::recovery;
use crate::tally::Tally;
use mcap::records::Metadata;
use models::units::Seconds;
use std::collections::BTreeMap;
use std::fs::File;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender, SyncSender, TrySendError};
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

/// What waits for the writer.
pub enum Item {
    /// A message.
    Message(Sample),
    /// Keys and values of a `fdm_loop` record.
    Note(BTreeMap<String, String>),
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

/// What the writer is told at the start.
pub struct Settings {
    pub topics: Vec<Recorded>,
    pub tally: Arc<Tally>,
    pub note: BTreeMap<String, String>,
    pub queue_length: usize,
    pub sync_period: Duration,
    pub late_max: Seconds,
}

/// One end of the bounded queue to the writer; clones share it.
#[derive(Clone)]
pub struct Queue {
    sender: SyncSender<Item>,
    waiting: Arc<AtomicUsize>,
}

impl Queue {
    /// Hands an item to the writer; false where the queue is full, or the writer has ended. Never waits.
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
    pub fn waiting(&self) -> usize {
        self.waiting.load(Ordering::Relaxed)
    }
}

/// The running threads.
pub struct Recorder {
    queue: Queue,
    writer: JoinHandle<Result<(), RecorderError>>,
    syncer: JoinHandle<()>,
    recoverer: JoinHandle<()>,
    stop_recovery: Arc<AtomicBool>,
}

impl Recorder {
    /// Begins the next file of the folder. Leftovers of a kill are recovered beside it: nothing waits for them.
    pub fn start(folder: Folder, settings: Settings) -> Result<Self, RecorderError> {
        let survey = folder.survey()?;
        let tally = Arc::clone(&settings.tally);
        for number in &survey.finished {
            match recovery::read_finished(&folder, *number) {
                Ok(contents) => folder.add(contents)?,
                Err(error) => {
                    tally.unreadable.add(1);
                    tracing::error!("{error}: not listed in metadata.yaml");
                }
            }
        }
        let (sender, items) = mpsc::sync_channel(settings.queue_length);
        let queue = Queue { sender, waiting: Arc::default() };
        let (files, opened) = mpsc::channel();
        let (period, sync_tally) = (settings.sync_period, Arc::clone(&tally));
        let syncer = spawn("sync", move || sync(&opened, period, &sync_tally))?;
        let writer = Writer::begin(folder.clone(), settings, files, survey.next)?;
        let waiting = Arc::clone(&queue.waiting);
        let writer = spawn("writer", move || writer.run(&items, &waiting))?;
        let stop_recovery = Arc::new(AtomicBool::new(false));
        let stop = Arc::clone(&stop_recovery);
        let recoverer =
            spawn("recovery", move || recovery::recover_all(&folder, &survey.leftover, &tally, &stop))?;
        Ok(Self { queue, writer, syncer, recoverer, stop_recovery })
    }

    /// The queue to the writer.
    pub fn queue(&self) -> Queue {
        self.queue.clone()
    }

    /// Whether the writer ended by itself: it failed.
    pub fn has_failed(&self) -> bool {
        self.writer.is_finished()
    }

    /// Finishes the file. Every other end of the queue must be gone.
    pub fn finish(self) -> Result<(), RecorderError> {
        self.stop_recovery.store(true, Ordering::Relaxed);
        drop(self.queue);
        _ = self.recoverer.join();
        let written =
            self.writer.join().unwrap_or(Err(RecorderError::Thread("the writer thread ended early")));
        _ = self.syncer.join();
        written
    }
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
            Ok(file) => newest = Some(file),
            Err(RecvTimeoutError::Timeout) => {
                if newest.as_ref().is_some_and(|file| file.sync_data().is_err()) {
                    tally.sync_failed.add(1);
                }
            }
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

/// State of the writing thread.
struct Writer {
    folder: Folder,
    settings: Settings,
    files: Sender<File>,
    file: BagFile,
    next: u32,
    order: Order,
    /// Messages of each topic that the system does not have yet.
    unflushed: Vec<u64>,
}

impl Writer {
    /// Begins file number `next`.
    fn begin(
        folder: Folder,
        settings: Settings,
        files: Sender<File>,
        next: u32,
    ) -> Result<Self, RecorderError> {
        let file = begin_file(&folder, next, &settings.note, &files)?;
        let (order, topics) = (Order::new(settings.late_max), settings.topics.len());
        Ok(Self { folder, settings, files, file, next: next + 1, order, unflushed: vec![0; topics] })
    }

    /// Writes until every other end of the queue is gone.
    fn run(mut self, items: &Receiver<Item>, waiting: &AtomicUsize) -> Result<(), RecorderError> {
        while let Ok(first) = items.recv() {
            let more = items.try_iter().take(self.settings.queue_length);
            for item in std::iter::once(first).chain(more) {
                waiting.fetch_sub(1, Ordering::Relaxed);
                self.take(item)?;
            }
            self.flush()?;
        }
        let contents = self.file.finish()?;
        self.folder.add(contents)?;
        self.folder.set_active(None)
    }

    fn take(&mut self, item: Item) -> Result<(), RecorderError> {
        match item {
            Item::Message(sample) => self.message(&sample),
            Item::Note(note) => {
                self.settings.note.extend(note);
                self.file.note(&record(&self.settings.note))
            }
        }
    }

    fn message(&mut self, sample: &Sample) -> Result<(), RecorderError> {
        let log_ns = match self.order.place(sample.received) {
            Place::InOrder(log_ns) => log_ns,
            Place::Raised(log_ns) => {
                self.settings.tally.raised.add(1);
                log_ns
            }
            Place::NewFile(log_ns) => {
                self.next_file()?;
                log_ns
            }
        };
        let publish_ns = sample.publish_ns.unwrap_or(log_ns);
        let stamp = Stamp { log_ns, publish_ns, sequence: sample.sequence };
        let topic = &self.settings.topics[sample.topic];
        self.file.write(&topic.channel, &topic.schema, stamp, &sample.payload)?;
        self.unflushed[sample.topic] += 1;
        Ok(())
    }

    /// Finishes the file and begins the next.
    fn next_file(&mut self) -> Result<(), RecorderError> {
        self.flush()?;
        let next = begin_file(&self.folder, self.next, &self.settings.note, &self.files)?;
        self.next += 1;
        let contents = std::mem::replace(&mut self.file, next).finish()?;
        self.folder.add(contents)
    }

    /// Hands what was written to the system, and counts it from then on.
    fn flush(&mut self) -> Result<(), RecorderError> {
        self.file.flush()?;
        for (topic, count) in self.settings.tally.topics.iter().zip(&mut self.unflushed) {
            topic.written.add(std::mem::take(count));
        }
        Ok(())
    }
}

/// A `fdm_loop` record.
fn record(note: &BTreeMap<String, String>) -> Metadata {
    Metadata { name: NOTE.to_owned(), metadata: note.clone() }
}

/// Begins a file: named in `metadata.yaml`, with what is known of print, build and configuration at its head.
fn begin_file(
    folder: &Folder,
    number: u32,
    note: &BTreeMap<String, String>,
    files: &Sender<File>,
) -> Result<BagFile, RecorderError> {
    let active = folder.layout().active(number);
    let name = folder.layout().finished(number);
    let mut file = BagFile::create(&folder.path(&active), Form::Plain, number, name)?;
    file.note(&record(note))?;
    file.flush()?;
    // The syncing thread ends with this one; without it only a loss of power costs more.
    _ = files.send(file.handle()?);
    folder.set_active(Some(active))?;
    Ok(file)
}
