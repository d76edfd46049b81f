//! State of the writing thread.

use super::Settings;
use super::queue::{Item, Sample, Wish};
use crate::error::RecorderError;
use crate::file::{BagFile, Form, NOTE, Stamp};
use crate::folder::Folder;
use crate::order::{Order, Place};
use crate::ring::Ring;
use mcap::records::Metadata;
use std::collections::BTreeMap;
use std::fs::File;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender};

/// A message whose place in time is settled.
struct Placed {
    topic: usize,
    stamp: Stamp,
    payload: Vec<u8>,
}

/// What events ask for while nothing is written: a kept file each would fill the disk with what cannot be dropped.
#[derive(Default)]
struct Events {
    /// Newest message in memory `[ns]`.
    newest_ns: u64,
    /// Newest message of the last snapshot `[ns]`.
    taken_ns: Option<u64>,
    /// An event came since, and has to wait until all that is in memory is new.
    is_owed: bool,
}

/// The one that writes.
pub(super) struct Pen {
    folder: Folder,
    settings: Settings,
    /// To the thread that syncs, and to the one that closes.
    opened: Sender<File>,
    ended: Sender<BagFile>,
    file: BagFile,
    number: u32,
    order: Order,
    /// The last seconds, where nothing is written and some are wanted.
    ring: Option<Ring<Placed>>,
    events: Events,
    /// Messages of each topic that the system does not have yet.
    unflushed: Vec<u64>,
}

impl Pen {
    /// Begins file `number`.
    pub(super) fn begin(
        folder: Folder,
        settings: Settings,
        (opened, ended): (Sender<File>, Sender<BagFile>),
        number: u32,
    ) -> Result<Self, RecorderError> {
        let file = begin_file(&folder, number, &settings.note, &opened)?;
        let (order, topics) = (Order::new(settings.late_max), settings.topics.len());
        let ring = (settings.snapshot.span_ns > 0).then(|| Ring::new(settings.snapshot));
        let (events, unflushed) = (Events::default(), vec![0; topics]);
        Ok(Self { folder, settings, opened, ended, file, number, order, ring, events, unflushed })
    }

    /// Writes until every other end of the queue is gone.
    pub(super) fn run(mut self, items: &Receiver<Item>, waiting: &AtomicUsize) -> Result<(), RecorderError> {
        while let Ok(first) = items.recv() {
            let more = items.try_iter().take(self.settings.queue_length);
            for item in std::iter::once(first).chain(more) {
                waiting.fetch_sub(1, Ordering::Relaxed);
                self.take(item)?;
            }
            self.flush()?;
        }
        self.settle()?;
        // Where the other end is gone the file stays as a kill leaves it: the next start recovers it.
        _ = self.ended.send(self.file);
        Ok(())
    }

    fn take(&mut self, item: Item) -> Result<(), RecorderError> {
        match item {
            Item::Message(sample) => self.message(sample),
            Item::Note(note) => {
                self.settings.note.extend(note);
                self.file.note(&record(&self.settings.note))
            }
            Item::Wish(wish) => self.grant(wish),
        }
    }

    fn is_paused(&self) -> bool {
        self.settings.tally.paused.load(Ordering::Relaxed)
    }

    fn message(&mut self, sample: Sample) -> Result<(), RecorderError> {
        let log_ns = match self.order.place(sample.received) {
            Place::InOrder(log_ns) => log_ns,
            Place::Raised(log_ns) => {
                self.settings.tally.raised.add(1);
                log_ns
            }
            Place::NewFile(log_ns) => {
                // What is in memory is of another time.
                self.settle()?;
                self.events = Events::default();
                self.ring.iter_mut().for_each(|ring| drop(ring.take()));
                self.next_file()?;
                log_ns
            }
        };
        let publish_ns = sample.publish_ns.unwrap_or(log_ns);
        let stamp = Stamp { log_ns, publish_ns, sequence: sample.sequence };
        let placed = Placed { topic: sample.topic, stamp, payload: sample.payload };
        if !self.is_paused() {
            return self.write(&placed);
        }
        self.settings.tally.passed_over.add(1);
        if self.events.is_owed && !self.is_soon(log_ns) {
            self.snapshot()?;
        }
        self.events.newest_ns = log_ns;
        if let Some(ring) = &mut self.ring {
            ring.push(log_ns, placed.payload.len() + std::mem::size_of::<Placed>(), placed);
        }
        Ok(())
    }

    fn write(&mut self, placed: &Placed) -> Result<(), RecorderError> {
        if self.is_full(placed.stamp.log_ns) {
            self.next_file()?;
        }
        let topic = &self.settings.topics[placed.topic];
        self.file.write(&topic.channel, &topic.schema, placed.stamp, &placed.payload)?;
        self.unflushed[placed.topic] += 1;
        Ok(())
    }

    /// Whether a message with this log time belongs to the next file.
    fn is_full(&self, log_ns: u64) -> bool {
        let Some((first_ns, _)) = self.file.contents().span_ns else { return false };
        let split = &self.settings.split;
        split.span_ns.is_some_and(|span_ns| log_ns.saturating_sub(first_ns) >= span_ns)
            || split.bytes.is_some_and(|bytes| self.file.bytes() >= bytes)
    }

    fn grant(&mut self, wish: Wish) -> Result<(), RecorderError> {
        match wish {
            Wish::Pause => self.settings.tally.paused.store(true, Ordering::Relaxed),
            Wish::Resume => {
                self.settle()?;
                // What else came before was not asked for.
                self.ring.iter_mut().for_each(|ring| drop(ring.take()));
                self.settings.tally.paused.store(false, Ordering::Relaxed);
            }
            Wish::Split => self.split()?,
            Wish::SplitBy(split) => self.settings.split = split,
            Wish::Keep if self.is_paused() && self.is_soon(self.events.newest_ns) => {
                self.events.is_owed = true;
            }
            Wish::Snapshot | Wish::Keep if self.is_paused() => self.snapshot()?,
            Wish::Snapshot => {
                self.keep(self.number)?;
                self.split()?;
            }
            Wish::Keep => {
                self.keep(self.number)?;
                if let Some(before) = self.number.checked_sub(1) {
                    self.keep_finished(before)?;
                }
            }
        }
        Ok(())
    }

    /// Whether the last snapshot is so new that one at this time would hold nothing that the next one does not.
    fn is_soon(&self, now_ns: u64) -> bool {
        let span_ns = self.settings.snapshot.span_ns;
        self.events.taken_ns.is_some_and(|taken_ns| now_ns.saturating_sub(taken_ns) <= span_ns)
    }

    /// Writes what an event has asked for and nobody could wait for any longer.
    fn settle(&mut self) -> Result<(), RecorderError> {
        if self.events.is_owed { self.snapshot() } else { Ok(()) }
    }

    /// Writes what is in memory to a file of its own, which is kept.
    fn snapshot(&mut self) -> Result<(), RecorderError> {
        let Some(ring) = &mut self.ring else { return Ok(()) };
        let placed: Vec<Placed> = ring.take().collect();
        self.events.is_owed = false;
        if placed.is_empty() {
            return Ok(());
        }
        self.events.taken_ns = Some(self.events.newest_ns);
        self.split()?;
        let first = self.number;
        for placed in &placed {
            self.write(placed)?;
        }
        (first..=self.number).try_for_each(|number| self.keep(number))?;
        self.split()
    }

    /// Ends the file, where there is anything in it.
    fn split(&mut self) -> Result<(), RecorderError> {
        if self.file.contents().span_ns.is_some() { self.next_file() } else { Ok(()) }
    }

    fn keep(&self, number: u32) -> Result<(), RecorderError> {
        self.settings.tally.kept.add(1);
        self.folder.keep(number)
    }

    /// Keeps an earlier file, where it is still there.
    fn keep_finished(&self, number: u32) -> Result<(), RecorderError> {
        let layout = self.folder.layout();
        let there = [layout.finished(number), layout.active(number)];
        if there.iter().any(|name| self.folder.path(name).exists()) { self.keep(number) } else { Ok(()) }
    }

    /// Ends the file and begins the next.
    fn next_file(&mut self) -> Result<(), RecorderError> {
        self.flush()?;
        let next = begin_file(&self.folder, self.number + 1, &self.settings.note, &self.opened)?;
        self.number += 1;
        // As at the end: where nobody closes it, the next start does.
        _ = self.ended.send(std::mem::replace(&mut self.file, next));
        Ok(())
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
    opened: &Sender<File>,
) -> Result<BagFile, RecorderError> {
    let active = folder.layout().active(number);
    let name = folder.layout().finished(number);
    let mut file = BagFile::create(&folder.path(&active), Form::Plain, number, name)?;
    file.note(&record(note))?;
    file.flush()?;
    // The syncing thread ends with this one; without it only a loss of power costs more.
    _ = opened.send(file.handle()?);
    folder.set_active(Some(active))?;
    Ok(file)
}
