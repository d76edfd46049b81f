//! Subscribing: messages with the time of receipt on the node's clock and the publisher's identity.

use crate::clock::Clock;
use crate::lifecycle::Gate;
use crate::stats::TopicStats;
use fdm_loop_msgs::RosType;
use futures::{Stream, stream};
use models::units::Seconds;
use std::sync::Arc;

/// Identity of a publisher on the graph: another one tells a second publisher or a restart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Gid(pub [u8; 16]);

/// Length of what all publishers of a process share in their identity: RTPS 2.5, 9.3.1, the GUID's prefix.
const PREFIX: usize = 12;

impl Gid {
    /// What all publishers of its process share.
    #[must_use]
    pub fn process(&self) -> &[u8] {
        &self.0[..PREFIX]
    }

    /// The leading and trailing bytes mixed into a number, for checks that want one (`models::command::Gate`).
    #[must_use]
    pub fn number(&self) -> u64 {
        self.0.chunks(8).fold(0, |mixed, part| {
            part.iter().fold(0_u64, |number, byte| (number << 8) | u64::from(*byte)) ^ mixed
        })
    }
}

/// A message and where it came from.
#[derive(Debug, Clone, PartialEq)]
pub struct Received<T> {
    /// The message.
    pub message: T,
    /// When it arrived, on the node's clock: deadlines run on it.
    pub received: Seconds,
    /// Who sent it.
    pub publisher: Gid,
}

/// Nanoseconds in a second.
const NANOS_PER_S: f64 = 1e9;

/// Wall time now `[ns]` since 1970.
pub(crate) fn wall_ns() -> i64 {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}

/// Age of a sample `[s]` by the middleware's time of arrival. That is wall time: a clock that was set back in between
/// counts as no age.
pub(crate) fn age_of(arrival: Option<ros2_client::ROSTime>) -> Seconds {
    let Some(arrival) = arrival else { return Seconds(0.0) };
    let nanos = wall_ns().saturating_sub(arrival.to_nanos());
    #[allow(clippy::cast_precision_loss)] // an age, not a date
    Seconds((nanos.max(0) as f64) / NANOS_PER_S)
}

/// One end of a topic that this node listens to.
pub struct Subscription<T: RosType> {
    reader: ros2_client::Subscription<T>,
    clock: Clock,
    stats: Arc<TopicStats>,
    gate: Gate,
}

impl<T: RosType> std::fmt::Debug for Subscription<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Subscription").field("stats", &self.stats).finish_non_exhaustive()
    }
}

impl<T: RosType> Subscription<T> {
    pub(crate) fn new(
        reader: ros2_client::Subscription<T>,
        clock: Clock,
        stats: Arc<TopicStats>,
        gate: Gate,
    ) -> Self {
        Self { reader, clock, stats, gate }
    }

    /// Its counters.
    pub(crate) fn stats(&self) -> Arc<TopicStats> {
        Arc::clone(&self.stats)
    }

    /// Waits for the next message. What cannot be decoded is counted and skipped. Cancelling loses no message.
    pub async fn recv(&mut self) -> Received<T> {
        loop {
            if let Some(received) = self.dated(self.reader.async_take().await) {
                return received;
            }
        }
    }

    /// The next message that is already here.
    pub fn try_recv(&mut self) -> Option<Received<T>> {
        loop {
            match self.reader.take() {
                Ok(None) => return None,
                taken => {
                    if let Some(received) = taken.transpose().and_then(|taken| self.dated(taken)) {
                        return Some(received);
                    }
                }
            }
        }
    }

    /// Everything that is already here is taken, the newest is kept: a latched topic replays old samples, oldest
    /// first, and a control loop wants the last.
    pub fn drain_newest(&mut self) -> Option<Received<T>> {
        let mut newest = None;
        while let Some(received) = self.try_recv() {
            newest = Some(received);
        }
        newest
    }

    /// Waits for a message, then drains to the newest.
    pub async fn recv_newest(&mut self) -> Received<T> {
        let first = self.recv().await;
        self.drain_newest().unwrap_or(first)
    }

    /// All messages to come.
    pub fn stream(&mut self) -> impl Stream<Item = Received<T>> + '_ {
        stream::unfold(self, |subscription| async {
            let received = subscription.recv().await;
            Some((received, subscription))
        })
    }

    /// Age of the newest message on the node's clock; `None` before the first.
    #[must_use]
    pub fn age(&self) -> Option<Seconds> {
        self.stats.age(self.clock.now())
    }

    /// Demands a message at least every `oldest`: silence shows in `/diagnostics` within 0.1 s.
    pub fn expect_every(&self, oldest: Seconds) {
        self.stats.watch(oldest, self.clock.now());
    }

    /// Messages received so far.
    #[must_use]
    pub fn received(&self) -> u64 {
        self.stats.passed_count()
    }

    /// Messages that could not be decoded so far.
    #[must_use]
    pub fn undecodable(&self) -> u64 {
        self.stats.lost_count()
    }

    /// Dates a sample and counts it; what waited for the node to be activated does not count.
    fn dated(&self, taken: ros2_client::ReadResult<(T, ros2_client::MessageInfo)>) -> Option<Received<T>> {
        let Ok((message, info)) = taken else {
            self.stats.lose();
            return None;
        };
        let age = age_of(info.received_timestamp());
        if !self.gate.takes(age) {
            return None;
        }
        let received = self.clock.at_age(age);
        self.stats.received(received);
        Some(Received { message, received, publisher: Gid(info.publisher_gid().to_bytes16()) })
    }
}
