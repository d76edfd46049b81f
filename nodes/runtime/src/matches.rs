//! Which readers and writers of others the middleware has matched with those of this process.
//!
//! To have discovered an endpoint is not to speak with it: a volatile writer sends nothing of before the match, so what it
//! wrote a moment too early is lost for good. RustDDS tells each match when it is made.

use futures::StreamExt;
use rustdds::dds::statusevents::DomainParticipantStatusEvent as Event;
use rustdds::{DomainParticipant, GUID, StatusEvented};
use std::collections::HashSet;
use std::sync::Arc;
use tokio::sync::watch;

/// Bytes of a request's identity that tell its participant. Twelve do (RTPS 2.5, 9.3.1); the second half of what Cyclone
/// sends is a number of its own.
const PREFIX: usize = 8;

/// The matches of one participant, shared by its clients and servers.
#[derive(Clone)]
pub(crate) struct Matches {
    participant: DomainParticipant,
    known: Arc<watch::Sender<HashSet<GUID>>>,
}

impl Matches {
    pub(crate) fn of(participant: DomainParticipant) -> Self {
        Self { participant, known: Arc::new(watch::Sender::default()) }
    }

    /// Takes in what the middleware tells, for ever. It tells each change once: one of these for a participant.
    pub(crate) async fn follow(self) {
        let listener = self.participant.status_listener();
        let mut events = listener.as_async_status_stream();
        while let Some(event) = events.next().await {
            self.known.send_if_modified(|known| note(known, &event));
        }
    }

    /// Wakes at each change from now on.
    pub(crate) fn changes(&self) -> watch::Receiver<HashSet<GUID>> {
        self.known.subscribe()
    }

    /// Whether a reader of a topic (its name in DDS) is known, and matched, in this participant or in any.
    pub(crate) fn reader(&self, topic: &str, participant: Option<&[u8]>) -> Known {
        self.among(self.readers(topic), participant)
    }

    /// The same of a writer.
    pub(crate) fn writer(&self, topic: &str) -> Known {
        self.among(self.writers(topic), None)
    }

    /// Takes all readers of one topic and all writers of another as matched from now on. For those that have been known so
    /// long that their match must have gone untold: of many events at once the middleware drops some.
    pub(crate) fn assume(&self, readers_of: &str, writers_of: &str) {
        let endpoints = self.readers(readers_of).into_iter().chain(self.writers(writers_of));
        self.known.send_modify(|known| known.extend(endpoints));
    }

    fn readers(&self, topic: &str) -> Vec<GUID> {
        let readers = self.participant.discovered_readers();
        let of_topic = readers.iter().filter(|reader| *reader.subscription_topic_data.topic_name() == topic);
        of_topic.map(|reader| reader.reader_proxy.remote_reader_guid).collect()
    }

    fn writers(&self, topic: &str) -> Vec<GUID> {
        let writers = self.participant.discovered_writers();
        let of_topic = writers.iter().filter(|writer| writer.publication_topic_data.topic_name == topic);
        of_topic.map(|writer| writer.writer_proxy.remote_writer_guid).collect()
    }

    fn among(&self, endpoints: Vec<GUID>, participant: Option<&[u8]>) -> Known {
        let matched = self.known.borrow();
        endpoints
            .into_iter()
            .filter(|guid| participant.is_none_or(|prefix| guid.prefix.as_ref().starts_with(prefix)))
            .map(|guid| if matched.contains(&guid) { Known::Matched } else { Known::Discovered })
            .max()
            .unwrap_or(Known::No)
    }
}

/// How far an endpoint of another participant is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Known {
    No,
    Discovered,
    Matched,
}

/// The participant of an endpoint, from its identity.
pub(crate) fn participant_of(identity: &[u8]) -> &[u8] {
    identity.get(..PREFIX).unwrap_or(identity)
}

/// Notes what an event tells; whether it changed anything.
fn note(known: &mut HashSet<GUID>, event: &Event) -> bool {
    match event {
        Event::RemoteReaderMatched { remote_reader: guid, .. }
        | Event::RemoteWriterMatched { remote_writer: guid, .. } => known.insert(*guid),
        Event::ReaderLost { guid, .. } | Event::WriterLost { guid, .. } => known.remove(guid),
        Event::ParticipantLost { id, .. } => {
            let before = known.len();
            known.retain(|guid| guid.prefix != *id);
            known.len() < before
        }
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustdds::LostReason;

    fn guid(participant: u8, endpoint: u8) -> GUID {
        let mut bytes = [participant; 16];
        bytes[12..].copy_from_slice(&[0, 0, endpoint, 4]);
        GUID::from_bytes(bytes)
    }

    #[test]
    fn a_match_is_known_until_the_other_end_is_gone() {
        let mut known = HashSet::new();
        let local_writer = guid(1, 1);
        for endpoint in [1, 2] {
            let event = Event::RemoteReaderMatched { local_writer, remote_reader: guid(2, endpoint) };
            assert!(note(&mut known, &event));
            assert!(!note(&mut known, &event), "nothing new");
        }
        let event = Event::RemoteWriterMatched { local_reader: guid(1, 3), remote_writer: guid(3, 1) };
        assert!(note(&mut known, &event));
        assert!(note(&mut known, &Event::ReaderLost { guid: guid(2, 1), reason: LostReason::Disposed }));
        assert_eq!(known, HashSet::from([guid(2, 2), guid(3, 1)]));
        let gone = Event::ParticipantLost { id: guid(2, 1).prefix, reason: LostReason::Disposed };
        assert!(note(&mut known, &gone) && !note(&mut known, &gone));
        assert_eq!(known, HashSet::from([guid(3, 1)]));
    }

    /// Cyclone's request names its participant by half.
    #[test]
    fn an_asker_is_told_by_the_first_half_of_its_identity() {
        let mut identity = [2; 16];
        identity[8..].fill(99);
        assert!(guid(2, 1).prefix.as_ref().starts_with(participant_of(&identity)));
        assert!(!guid(3, 1).prefix.as_ref().starts_with(participant_of(&identity)));
    }
}
