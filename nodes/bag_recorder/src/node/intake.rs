//! Takes what has arrived of all topics, a look at a time, and hands it to the writer in the order of its arrival.
//!
//! A recorder that woke for each message would wake a thousand times a second, and its writer with it: that is most of what
//! it costs. The middleware notes when a message arrived, so that its log time does not tell of the wait.

use crate::convert;
use crate::tally::Tally;
use crate::writer::{Item, Queue, Sample};
use runtime::{Gid, RawMessage, RawSubscription, Shutdown, Work};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;
use tokio::time::{MissedTickBehavior, interval};

/// Real time between two looks: what a kill costs of a message's time, and a fiftieth of what the middleware keeps at 1 kHz.
const LOOK: Duration = Duration::from_millis(20);
/// Messages of a topic that one look takes: one that never runs dry must not keep the others waiting.
const MOST: usize = 1000;

/// Where the messages of one topic go.
pub(super) struct Intake {
    pub(super) topic: usize,
    pub(super) queue: Queue,
    /// Nothing is handed over where so many wait.
    pub(super) most: usize,
    pub(super) tally: Arc<Tally>,
    pub(super) work: Work,
    /// Newest number of each publisher.
    pub(super) newest: BTreeMap<Gid, i64>,
}

impl Intake {
    /// Hands a message to the writer, or drops it where too many wait. Never waits itself.
    fn take(&mut self, message: RawMessage) {
        let counts = &self.tally.topics[self.topic];
        counts.received.add(1);
        if let Some(before) = self.newest.insert(message.publisher, message.sequence) {
            let gap = message.sequence.saturating_sub(before).saturating_sub(1);
            counts.missed.add(u64::try_from(gap).unwrap_or(0));
        }
        let sample = Sample {
            topic: self.topic,
            received: message.received,
            publish_ns: message.sent_ns.and_then(|sent| u64::try_from(sent).ok()),
            sequence: convert::sequence(message.sequence),
            payload: message.payload,
        };
        let has_room = self.queue.waiting() < self.most && !self.tally.full.load(Ordering::Relaxed);
        if has_room && self.queue.offer(Item::Message(sample)) {
            self.work.done();
        } else {
            counts.dropped.add(1);
        }
    }
}

/// Takes the messages of all topics until the end is demanded, and then what is already here.
pub(super) async fn take_all(mut topics: Vec<(RawSubscription, Intake)>, mut shutdown: Shutdown) {
    let mut looks = interval(LOOK);
    looks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    loop {
        tokio::select! {
            _ = looks.tick() => look(&mut topics),
            () = shutdown.wait() => break,
        }
    }
    look(&mut topics);
}

/// Takes what is here.
fn look(topics: &mut [(RawSubscription, Intake)]) {
    let mut arrived = Vec::new();
    for (topic, (subscription, _)) in topics.iter_mut().enumerate() {
        let here = std::iter::from_fn(|| subscription.try_recv()).take(MOST);
        arrived.extend(here.map(|message| (topic, message)));
    }
    arrived.sort_by_key(|(_, message)| message.received_ns);
    for (topic, message) in arrived {
        topics[topic].1.take(message);
    }
}
