//! What somebody may ask of a recorder, as of `ros2 bag record`.

use crate::tally::Tally;
use crate::writer::{Item, Queue, Wish};
use fdm_loop_msgs::{Trigger, TriggerResponse};
use runtime::{Asked, Node, RuntimeError, Server, topics};
use std::sync::atomic::Ordering;

/// Every service.
pub(super) struct Services {
    record: Server<Trigger>,
    pause: Server<Trigger>,
    resume: Server<Trigger>,
    snapshot: Server<Trigger>,
    split: Server<Trigger>,
    /// Something is kept in memory while nothing is written.
    remembers: bool,
}

/// A request that waits for its answer.
pub(super) enum Request {
    Record(Asked<Trigger>),
    Pause(Asked<Trigger>),
    Resume(Asked<Trigger>),
    Snapshot(Asked<Trigger>),
    Split(Asked<Trigger>),
}

impl Services {
    pub(super) fn serve(node: &mut Node, remembers: bool) -> Result<Self, RuntimeError> {
        Ok(Self {
            record: node.serve(&topics::RECORDER_RECORD)?,
            pause: node.serve(&topics::RECORDER_PAUSE)?,
            resume: node.serve(&topics::RECORDER_RESUME)?,
            snapshot: node.serve(&topics::RECORDER_SNAPSHOT)?,
            split: node.serve(&topics::RECORDER_SPLIT)?,
            remembers,
        })
    }

    /// The next request. Cancelling loses none.
    pub(super) async fn next(&mut self) -> Request {
        tokio::select! {
            asked = self.record.next() => Request::Record(asked),
            asked = self.pause.next() => Request::Pause(asked),
            asked = self.resume.next() => Request::Resume(asked),
            asked = self.snapshot.next() => Request::Snapshot(asked),
            asked = self.split.next() => Request::Split(asked),
        }
    }

    /// Hands a request to the writer, and answers it.
    pub(super) fn grant(&self, request: &Request, queue: &Queue, tally: &Tally) {
        let paused = tally.paused.load(Ordering::Relaxed);
        let offer = |wishes: &[Wish]| wishes.iter().all(|wish| queue.offer(Item::Wish(*wish)));
        let busy = "the queue to the writer is full: ask again";
        let granted = |said: &str, wishes: &[Wish]| {
            let success = offer(wishes);
            TriggerResponse { success, message: if success { said } else { busy }.to_owned() }
        };
        let refused = |said: &str| TriggerResponse { success: false, message: said.to_owned() };
        match request {
            Request::Record(asked) => {
                self.record.answer(asked, granted("recording to a new file", &[Wish::Resume, Wish::Split]))
            }
            Request::Pause(asked) => self.pause.answer(asked, granted("paused", &[Wish::Pause])),
            Request::Resume(asked) if paused => {
                self.resume.answer(asked, granted("recording", &[Wish::Resume]))
            }
            Request::Resume(asked) => self.resume.answer(asked, granted("recording already", &[])),
            Request::Snapshot(asked) => self.snapshot.answer(
                asked,
                match (paused, self.remembers) {
                    (true, false) => refused("nothing is in memory: snapshot_s is 0"),
                    (true, true) => {
                        granted("the last seconds are written to a file of their own", &[Wish::Snapshot])
                    }
                    (false, _) => granted("everything is recorded: this file is kept", &[Wish::Snapshot]),
                },
            ),
            Request::Split(asked) => self.split.answer(asked, granted("a new file begins", &[Wish::Split])),
        };
    }
}
