//! Messages as the bytes that came over the wire: what a bag stores.

use crate::clock::Clock;
use crate::lifecycle::Gate;
use crate::stats::TopicStats;
use crate::subscription::{Gid, age_of, wall_ns};
use models::units::Seconds;
use ros2_client::MessageInfo;
use rustdds::RepresentationIdentifier;
use rustdds::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SimpleDataReader};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::Arc;

/// A message without its Rust type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Bytes(Vec<u8>);

/// Passes payloads through; the encapsulation header goes back in front, for bags store it.
pub(crate) struct PassThrough;

/// Decoder of [`PassThrough`].
#[derive(Clone)]
pub(crate) struct Header;

/// Plain CDR in both byte orders: what ROS 2 writes.
const ENCODINGS: &[RepresentationIdentifier] =
    &[RepresentationIdentifier::CDR_LE, RepresentationIdentifier::CDR_BE];

impl DeserializerAdapter<Bytes> for PassThrough {
    type Error = Infallible;
    type Decoded = Bytes;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        ENCODINGS
    }

    fn transform_decoded(decoded: Bytes) -> Bytes {
        decoded
    }
}

impl DefaultDecoder<Bytes> for PassThrough {
    type Decoder = Header;
    const DECODER: Header = Header;
}

impl Decode<'_, Bytes> for Header {
    type Error = Infallible;

    fn decode_bytes(self, input: &[u8], encoding: RepresentationIdentifier) -> Result<Bytes, Infallible> {
        let [first, second] = encoding.to_bytes();
        let mut bytes = Vec::with_capacity(input.len() + 4);
        bytes.extend_from_slice(&[first, second, 0, 0]);
        bytes.extend_from_slice(input);
        Ok(Bytes(bytes))
    }
}

/// A message as bytes and where it came from.
#[derive(Debug, Clone, PartialEq)]
pub struct RawMessage {
    /// CDR with its four bytes of encapsulation header.
    pub payload: Vec<u8>,
    /// Time of sending by the publisher's wall clock `[ns]` since 1970; `None` where it sent none.
    pub sent_ns: Option<i64>,
    /// When it arrived, on the node's clock.
    pub received: Seconds,
    /// When it arrived, by the wall clock `[ns]` since 1970: the log time of bags.
    pub received_ns: i64,
    /// Number of the message by its publisher.
    pub sequence: i64,
    /// Who sent it.
    pub publisher: Gid,
}

/// One end of a topic whose messages are not decoded.
pub struct RawSubscription {
    reader: SimpleDataReader<Bytes, PassThrough>,
    topic: String,
    type_name: String,
    clock: Clock,
    stats: Arc<TopicStats>,
    gate: Gate,
    latched: bool,
    /// Newest state of each publisher of those that waited for the node to be activated.
    held: BTreeMap<Gid, RawMessage>,
}

impl std::fmt::Debug for RawSubscription {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RawSubscription").field("stats", &self.stats).finish_non_exhaustive()
    }
}

/// What a raw subscription is called.
pub(crate) struct RawNames {
    pub(crate) topic: String,
    pub(crate) type_name: String,
    /// Its newest message is a state, which holds until the next.
    pub(crate) latched: bool,
}

impl RawSubscription {
    pub(crate) fn new(
        reader: SimpleDataReader<Bytes, PassThrough>,
        names: RawNames,
        clock: Clock,
        stats: Arc<TopicStats>,
        gate: Gate,
    ) -> Self {
        let RawNames { topic, type_name, latched } = names;
        Self { reader, topic, type_name, clock, stats, gate, latched, held: BTreeMap::new() }
    }

    /// Name on the graph, namespace and remapping included.
    #[must_use]
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// Type as bags name it: `package/msg/Name`.
    #[must_use]
    pub fn type_name(&self) -> &str {
        &self.type_name
    }

    /// Waits for the next message. Cancelling loses none.
    pub async fn recv(&mut self) -> RawMessage {
        std::future::poll_fn(|context| {
            if let Some(message) = self.try_recv() {
                return std::task::Poll::Ready(message);
            }
            self.reader.set_waker(Some(context.waker().clone()));
            // What arrived between the look and the waker would wake nobody.
            match self.try_recv() {
                Some(message) => std::task::Poll::Ready(message),
                None => std::task::Poll::Pending,
            }
        })
        .await
    }

    /// The next message that is already here.
    pub fn try_recv(&mut self) -> Option<RawMessage> {
        self.reader.drain_read_notifications();
        loop {
            match self.reader.try_take_one() {
                Ok(Some(sample)) => {
                    let info = MessageInfo::from(&sample);
                    if let Some(message) = self.gated(&info, sample.into_value()) {
                        return Some(message);
                    }
                }
                Ok(None) => return self.held.pop_first().map(|(_, message)| message),
                Err(_) => self.stats.lose(),
            }
        }
    }

    /// Messages received so far.
    #[must_use]
    pub fn received(&self) -> u64 {
        self.stats.passed_count()
    }

    /// Messages in an encoding that is not plain CDR so far.
    #[must_use]
    pub fn undecodable(&self) -> u64 {
        self.stats.lost_count()
    }

    /// Dates a sample and counts it. What waited for the node to be activated does not count; the newest state of a
    /// latched topic does, as of the activation.
    fn gated(&mut self, info: &MessageInfo, bytes: Bytes) -> Option<RawMessage> {
        let arrival = info.received_timestamp();
        let age = age_of(arrival);
        if self.gate.takes(age) {
            let message = self.dated(info, bytes, (age, arrival.map(|time| time.to_nanos())));
            self.held.remove(&message.publisher);
            return Some(message);
        }
        if self.latched {
            let opened = self.gate.open_for().unwrap_or_default();
            let message = self.dated(info, bytes, (opened, None));
            self.held.insert(message.publisher, message);
        }
        None
    }

    fn dated(
        &self,
        info: &MessageInfo,
        bytes: Bytes,
        (age, arrival_ns): (Seconds, Option<i64>),
    ) -> RawMessage {
        let received = self.clock.at_age(age);
        self.stats.received(received);
        RawMessage {
            payload: bytes.0,
            sent_ns: info.source_timestamp().map(|time| time.to_nanos()),
            received,
            received_ns: arrival_ns.unwrap_or_else(wall_ns),
            sequence: info.sequence_number(),
            publisher: Gid(info.publisher_gid().to_bytes16()),
        }
    }
}
