//! C9: who publishes another type under the name of a topic, and who offers less than is asked for there.
//!
//! DDS forbids both to reach a subscriber. RustDDS 0.15.1 holds to that for the quality of service; it does not compare the
//! names of types, so that bytes of another type come as far as the decoder, and are counted there. (Bytes that it takes all
//! the same are a second publisher's, whatever their type is called: C8.)

use crate::Peer;
use crate::table::Kind;
use byteorder::LittleEndian;
use fdm_loop_msgs::{DefectReport, Header, RosType, Temperature};
use runtime::qos::{End, Reliability};
use runtime::topics::{self, Topic};
use runtime::{Args, Node, RawPublisher};

/// Who is looked at.
const NODE: &str = "safety_supervisor";
/// So many that are counted are no chance: one second of what is sent.
const ENOUGH: u64 = 20;

/// A message as it goes over the wire.
fn cdr<T: RosType>(message: &T) -> Vec<u8> {
    let body = cdr_encoding::to_vec::<T, LittleEndian>(message).unwrap();
    [&[0, 1, 0, 0], &body[..]].concat()
}

fn temperature(now_s: f64) -> Vec<u8> {
    cdr(&Temperature { header: Header::at(now_s), temperature: 210.0, ..Temperature::default() })
}

/// Under a topic's name another type: the name of it, and what a message of it looks like.
fn of_another_type<T: RosType>(stranger: &mut Node, topic: &Topic<T>) -> RawPublisher {
    let other = Temperature::DEFINITION.full_name();
    stranger.publish_raw(topic.name(), &other, topic.qos().offered).unwrap()
}

/// Neither is taken for what the topic carries; the one is counted, the other not even heard; the supervisor goes on.
pub(crate) async fn of_type_or_quality_harm_nothing(peer: &mut Peer) {
    let mut stranger = Node::start_with("stranger", Args::default()).unwrap();
    bytes_of_another_type_are_counted(peer, &mut stranger).await;
    less_than_is_asked_for_is_not_heard(peer, &mut stranger).await;
    drop(stranger);
    goes_on(peer).await;
}

async fn bytes_of_another_type_are_counted(peer: &mut Peer, stranger: &mut Node) {
    let commands = of_another_type(stranger, &topics::CONTROL_COMMAND);
    let permits = of_another_type(stranger, &topics::SAFETY_COMMAND);
    for (topic, publisher) in
        [(topics::CONTROL_COMMAND.name(), commands), (topics::SAFETY_COMMAND.name(), permits)]
    {
        let (before, refused) = (peer.shown.undecodable(NODE, topic), peer.shown.refused_in_all(NODE, topic));
        let send = |now_s: f64| _ = publisher.send(&temperature(now_s));
        let counted =
            peer.while_sending(send, |shown| shown.undecodable(NODE, topic) >= before + ENOUGH).await;
        assert!(counted, "{topic}: {} cannot be decoded", peer.shown.undecodable(NODE, topic) - before);
        // A message that is let through, if only to be refused for its values, is none of another type any more.
        assert_eq!(peer.shown.refused_in_all(NODE, topic), refused, "{topic}: some came further");
    }
}

/// Best effort where a reliable stream is asked for: no match. The same bytes, offered as they should be, are heard.
async fn less_than_is_asked_for_is_not_heard(peer: &mut Peer, stranger: &mut Node) {
    let (topic, qos) = (topics::DEFECTS.name(), topics::DEFECTS.qos());
    assert_eq!(qos.requested.reliability, Reliability::Reliable, "nothing less could be offered");
    let other = of_another_type(stranger, &topics::CONTROL_COMMAND);
    let counter = topics::CONTROL_COMMAND.name();
    let type_name = DefectReport::DEFINITION.full_name();
    let less = End { reliability: Reliability::BestEffort, ..qos.offered };
    for (offered, heard) in [(less, false), (qos.offered, true)] {
        let publisher = stranger.publish_raw(topic, &type_name, offered).unwrap();
        let (before, counted) = (peer.shown.received(NODE, topic), peer.shown.undecodable(NODE, counter));
        // What is counted of the other topic tells that the participant is known, and that a newer report has come.
        let send = |now_s: f64| {
            _ = other.send(&temperature(now_s));
            _ = publisher.send(&cdr(&DefectReport { header: Header::at(now_s), ..DefectReport::default() }));
        };
        let done = |shown: &crate::Shown| {
            let reported = shown.undecodable(NODE, counter) >= counted + 2 * ENOUGH;
            reported && (!heard || shown.received(NODE, topic) > before)
        };
        assert!(peer.while_sending(send, done).await, "offered {offered:?}: {}", publisher.sent());
        let received = peer.shown.received(NODE, topic) - before;
        assert_eq!(received > 0, heard, "{received} of {} heard, offered {offered:?}", publisher.sent());
    }
}

/// Sound messages are taken as before, and permits go out.
async fn goes_on(peer: &mut Peer) {
    let (command, permit) = (topics::CONTROL_COMMAND.name(), topics::SAFETY_COMMAND.name());
    let (received, sent) = (peer.shown.received(NODE, command), peer.shown.sent(NODE, permit));
    let goes_on = |shown: &crate::Shown| {
        shown.received(NODE, command) >= received + ENOUGH && shown.sent(NODE, permit) >= sent + ENOUGH
    };
    assert!(peer.until(Some(Kind::Sound), goes_on).await, "the supervisor does not go on");
}
