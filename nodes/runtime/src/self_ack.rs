//! Tells a participant on a `lo` without multicast that its own announcements arrived.
//!
//! RustDDS 0.15.1 counts itself among the readers of its discovery (SEDP), but on a `lo` without multicast nothing that
//! it sends reaches itself. So these readers never acknowledge, and every participant repeats its heartbeats to all
//! others ten times a second for ever: 22 participants of a graph of 11 processes exchange 21 000 packets a second, a
//! quarter of a core. What a process announces it knows anyway; so this sends the missing ACKNACK to the participant's
//! own port. How many announcements there are is not told, so each number up to [`MOST`] is acknowledged: RustDDS takes
//! the one that is right and ignores those beyond what it has sent. Where multicast works nothing is sent.

use crate::participants::{lo_has_multicast, port};
use rustdds::{DomainParticipant, RTPSEntity};
use std::net::{Ipv4Addr, UdpSocket};

/// Announcements of a kind that are acknowledged; a node has a dozen or two. Four kinds fit into one datagram and into
/// the queue of 1024 in which RustDDS takes them.
const MOST: u32 = 160;
/// Middle byte and kind of the built-in writers and readers (RTPS 2.5, 9.3.1.5): topics, publications, subscriptions, liveliness.
const KINDS: [[u8; 3]; 4] = [[0, 0, 2], [0, 0, 3], [0, 0, 4], [0, 2, 0]];
const WRITER: u8 = 0xc2;
const READER: u8 = 0xc7;

/// The acknowledging end of one participant.
#[derive(Debug)]
pub(crate) struct SelfAck {
    socket: UdpSocket,
    port: u16,
    prefix: [u8; 12],
    count: u32,
}

impl SelfAck {
    /// For a participant that does not hear itself; `None` for one that does, or where there is no socket to be had:
    /// then all works as well, at a higher price.
    pub(crate) fn of(participant: &DomainParticipant) -> Option<Self> {
        if lo_has_multicast() {
            return None;
        }
        Some(Self {
            socket: UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).ok()?,
            port: port(participant.domain_id(), participant.participant_id()),
            prefix: participant.guid().prefix.as_ref().try_into().ok()?,
            count: 0,
        })
    }

    /// Acknowledges all that was announced so far.
    pub(crate) fn send(&mut self) {
        let datagram = self.datagram();
        // Nobody listens: then nobody repeats anything either.
        _ = self.socket.send_to(&datagram, (Ipv4Addr::LOCALHOST, self.port));
    }

    /// The message: its header, and an ACKNACK for each kind and number, the highest first, so that no repair begins.
    fn datagram(&mut self) -> Vec<u8> {
        let mut bytes = b"RTPS\x02\x04\x01\x12".to_vec();
        bytes.extend(self.prefix);
        for kind in KINDS {
            for acknowledged in (1..=MOST).rev() {
                self.count = self.count.wrapping_add(1);
                // ACKNACK, little endian and final, 24 bytes.
                bytes.extend([0x06, 0x03, 24, 0]);
                for end in [READER, WRITER] {
                    bytes.extend(kind);
                    bytes.push(end);
                }
                // All before the next one: high and low half; a set of no bits.
                bytes.extend(0_u32.to_le_bytes());
                bytes.extend((acknowledged + 1).to_le_bytes());
                bytes.extend(0_u32.to_le_bytes());
                bytes.extend(self.count.to_le_bytes());
            }
        }
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_datagram_acknowledges_each_number_of_each_kind_once() {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let mut ack = SelfAck { socket, port: 0, prefix: [7; 12], count: 0 };
        let bytes = ack.datagram();
        assert!(bytes.len() < 65_000);
        assert_eq!(&bytes[..20], b"RTPS\x02\x04\x01\x12\x07\x07\x07\x07\x07\x07\x07\x07\x07\x07\x07\x07");
        let messages: Vec<&[u8]> = bytes[20..].chunks(28).collect();
        assert_eq!(messages.len(), 4 * MOST as usize);
        assert_eq!(messages[0][..16], [6, 3, 24, 0, 0, 0, 2, 0xc7, 0, 0, 2, 0xc2, 0, 0, 0, 0]);
        assert_eq!(messages[0][16..20], (MOST + 1).to_le_bytes());
        assert_eq!(messages[MOST as usize - 1][16..20], 2_u32.to_le_bytes());
        // A number that came before is ignored.
        let counts: std::collections::BTreeSet<&[u8]> =
            messages.iter().map(|message| &message[24..]).collect();
        assert_eq!(counts.len(), messages.len());
    }
}
