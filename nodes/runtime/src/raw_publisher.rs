//! Publishing bytes as a bag stores them.

use crate::error::RuntimeError;
use crate::node::Node;
use crate::qos::End;
use crate::stats::TopicStats;
use rustdds::no_key::DataWriter;
use serde::ser::{Serialize, SerializeTuple, Serializer};
use std::sync::Arc;

/// Bytes of the encapsulation header in front of the data.
const ENCAPSULATION: usize = 4;
/// What the writer says its bytes are: plain CDR, least significant byte first.
const LITTLE_ENDIAN: [u8; 2] = [0, 1];

/// A message that is serialized already.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Serialized(Vec<u8>);

impl Serialize for Serialized {
    /// A tuple of bytes is those bytes in CDR, without a length.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        for byte in &self.0 {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

/// One end of a topic whose messages are serialized already.
pub struct RawPublisher {
    writer: DataWriter<Serialized>,
    stats: Arc<TopicStats>,
}

impl std::fmt::Debug for RawPublisher {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RawPublisher").field("stats", &self.stats).finish_non_exhaustive()
    }
}

impl RawPublisher {
    pub(crate) fn new(writer: DataWriter<Serialized>, stats: Arc<TopicStats>) -> Self {
        Self { writer, stats }
    }

    /// Sends CDR with its encapsulation header; false where it was dropped, as [`crate::Publisher::send`], or is not of
    /// little-endian CDR. Never waits.
    pub fn send(&self, payload: &[u8]) -> bool {
        let sent = payload.starts_with(&LITTLE_ENDIAN)
            && payload
                .get(ENCAPSULATION..)
                .is_some_and(|body| self.writer.write(Serialized(body.to_vec()), None).is_ok());
        if sent {
            self.stats.sent();
        } else {
            self.stats.lose();
        }
        sent
    }

    /// Messages sent so far.
    #[must_use]
    pub fn sent(&self) -> u64 {
        self.stats.passed_count()
    }

    /// Messages dropped so far.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.stats.lost_count()
    }
}

impl Node {
    /// Publishes bytes of any type (`package/msg/Name`) on a topic. (It does not show in `ros2 node info`: the client
    /// cannot announce it.)
    ///
    /// # Errors
    /// [`RuntimeError::Create`] or [`RuntimeError::Name`]
    pub fn publish_raw(
        &mut self,
        topic: &str,
        type_name: &str,
        offered: End,
    ) -> Result<RawPublisher, RuntimeError> {
        let writer = self.raw_writer(topic, type_name, offered)?;
        let stats = Arc::new(TopicStats::publisher(topic));
        self.diagnostics().watch(Arc::clone(&stats));
        Ok(RawPublisher::new(writer, stats))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use byteorder::LittleEndian;

    #[test]
    fn serialized_bytes_go_out_as_they_are() {
        let bytes = vec![7, 0, 0, 0, 1, 2, 3];
        let sent = cdr_encoding::to_vec::<_, LittleEndian>(&Serialized(bytes.clone())).unwrap();
        assert_eq!(sent, bytes);
    }
}
