//! How many others are in the domain, and when they are too many.
//!
//! RustDDS 0.15.1 believes in every participant that is announced to it, keeps it as long as that one's own lease says,
//! and sends it four kinds of heartbeats ten times a second until they are acknowledged: a thousand that never answer
//! fill both cores of a host for ever (X1). None of them can be sent away. So a process that sees too many leaves the
//! domain in order and comes back without them, where somebody starts it again.

use rustdds::{
    DomainParticipant, DomainParticipantStatusEvent, DomainParticipantStatusListener, StatusEvented,
};
use std::collections::BTreeSet;

/// Participants that a process bears, itself included. A graph of ours has up to two a process, 24 in all, and who is started
/// again counts twice for a minute; a hundred that never answer cost about one core of a host with twelve processes.
const MOST: usize = 100;

/// The others, as the participants of this process know them.
pub(crate) struct Crowd(Vec<Known>);

struct Known {
    events: DomainParticipantStatusListener,
    prefixes: BTreeSet<Vec<u8>>,
}

impl Crowd {
    /// Around these participants. Nobody else may listen to what happens to them.
    pub(crate) fn around<'a>(participants: impl IntoIterator<Item = &'a DomainParticipant>) -> Self {
        let known = |participant: &DomainParticipant| Known {
            events: participant.status_listener(),
            prefixes: BTreeSet::new(),
        };
        Self(participants.into_iter().map(known).collect())
    }

    /// Takes in who came and went; how many there are where they are too many.
    pub(crate) fn look(&mut self) -> Option<usize> {
        self.0.iter_mut().map(Known::count).max().filter(|count| *count > MOST)
    }
}

impl Known {
    fn count(&mut self) -> usize {
        while let Some(event) = self.events.try_recv_status() {
            match event {
                DomainParticipantStatusEvent::ParticipantDiscovered { dpd } => {
                    self.prefixes.insert(dpd.guid.prefix.as_ref().to_vec());
                }
                DomainParticipantStatusEvent::ParticipantLost { id, .. } => {
                    self.prefixes.remove(id.as_ref());
                }
                _ => {}
            }
        }
        self.prefixes.len()
    }
}
