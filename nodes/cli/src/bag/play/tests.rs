use super::*;
use crate::report::scan::{Raw, Visitor};

/// A bag that is played does not move a printer.
#[test]
fn commands_are_played_only_where_they_are_asked_for() {
    let plays = |reel: &Reel, topic: &str| reel.plays(topic);
    let plain = Reel { clock: true, ..Reel::default() };
    for topic in ["/printer/safety/command", "/printer/control/command", "/clock"] {
        assert!(!plays(&plain, topic), "{topic}");
    }
    assert!(plays(&plain, "/printer/safety/state"));
    assert!(plays(&Reel { commands: true, ..Reel::default() }, "/printer/safety/command"));
    let inputs = Reel { inputs: true, ..Reel::default() };
    assert!(plays(&inputs, "/printer/sensors/imu/batch") && !plays(&inputs, "/printer/estimate/state"));
    let named = Reel { named: vec!["estimate/state".into()], ..Reel::default() };
    assert!(plays(&named, "/printer/estimate/state") && !plays(&named, "/printer/events"));
}

const SECOND: u64 = 1_000_000_000;

/// A reel of messages of topics at log times `[s]`, numbered as they stand in the bag.
fn reel(messages: &[(&str, u64)]) -> Reel {
    let mut reel = Reel::default();
    for (number, (topic, log_s)) in (0..).zip(messages) {
        let latched = if *topic == "/latched" { "durability: transient_local" } else { "" };
        let raw = Raw {
            topic,
            type_name: "std_msgs/msg/Empty",
            encoding: "cdr",
            offered_qos: latched,
            log_ns: log_s * SECOND,
            payload: &[0, 1, 0, 0, number],
        };
        reel.message(&raw);
    }
    reel.order();
    reel
}

/// Number, log time `[s]` and time into the play `[s]` of each message.
fn played(reel: &Reel) -> Vec<(u8, u64, u64)> {
    let told = |frame: &reel::Frame| (frame.payload[4], frame.log_ns / SECOND, frame.at_ns / SECOND);
    reel.frames.iter().map(told).collect()
}

/// Who names what the bag has not is told what it has.
#[test]
fn a_topic_that_is_not_there_is_told_with_those_that_are() {
    let mut reel = reel(&[("/printer/a/b", 1), ("/printer/safety/command", 2)]);
    for fine in ["a/b", "/printer/a/b", "safety/command"] {
        reel.named = vec![fine.to_owned()];
        reel.check_names().unwrap();
    }
    reel.named = vec!["a/b".to_owned(), "nix".to_owned()];
    let said = reel.check_names().unwrap_err().to_string();
    assert_eq!(said, "--topics nix: the bag has no such topic, but /printer/a/b, /printer/safety/command");
}

/// A clock that jumps back in the midst of a bag, as it does where a simulation begins anew: every message is played, in the
/// order in which it was recorded.
#[test]
fn nothing_is_dropped_where_the_clock_jumped_back() {
    let mut back = reel(&[("/a", 100), ("/b", 100), ("/a", 103), ("/b", 5), ("/a", 5), ("/a", 7)]);
    let all = [(0, 100, 0), (1, 100, 0), (2, 103, 3), (3, 5, 3), (4, 5, 3), (5, 7, 5)];
    assert_eq!(played(&back), all);
    assert_eq!(back.frames.iter().map(|frame| frame.stretch).collect::<Vec<_>>(), [0, 0, 0, 1, 1, 1]);
    assert!(back.remarks[0].contains("jumped 1 times"), "{:?}", back.remarks);
    back.begin_at(4.0).unwrap();
    assert_eq!(played(&back), [(5, 7, 1)]);
}

/// Topics that stand one behind the other in a file tell no jump: what belongs together is played together.
#[test]
fn topics_that_stand_behind_each_other_are_played_together() {
    let reel = reel(&[("/a", 1), ("/a", 50), ("/b", 2), ("/b", 49)]);
    assert_eq!(played(&reel), [(0, 1, 0), (2, 2, 1), (3, 49, 48), (1, 50, 49)]);
    assert!(reel.remarks.is_empty());
}

/// The first messages of a node that waits for its clock stand at zero, decades before all others.
#[test]
fn no_decades_are_waited_for() {
    let reel = reel(&[("/a", 0), ("/a", 1_700_000_000), ("/a", 1_700_000_002)]);
    assert_eq!(played(&reel), [(0, 0, 0), (1, 1_700_000_000, 0), (2, 1_700_000_002, 2)]);
}

#[test]
fn who_begins_later_hears_the_newest_word_of_each_latched_topic() {
    let messages = [("/latched", 10), ("/latched", 11), ("/a", 12), ("/a", 20), ("/a", 21)];
    let mut later = reel(&messages);
    later.begin_at(9.5).unwrap();
    assert_eq!(played(&later), [(1, 20, 0), (3, 20, 0), (4, 21, 1)]);
    let error = reel(&messages).begin_at(11.5).unwrap_err().to_string();
    assert_eq!(error, "--start 11.5 s: must be in [0, 11.000], what is played of the bag");
}

/// A clock of ROS counts nanoseconds in an i64: a time beyond it is named, before anything is played.
#[test]
fn a_time_that_no_clock_can_tell_is_named() {
    let mut reel = Reel::default();
    let (type_name, encoding, offered_qos, payload) = ("std_msgs/msg/Empty", "cdr", "", &[0, 1, 0, 0][..]);
    for log_ns in [5, i64::MAX.unsigned_abs(), u64::MAX - 3] {
        reel.message(&Raw { topic: "/a", type_name, encoding, offered_qos, log_ns, payload });
    }
    assert_eq!(reel.frames.len(), 2);
    let said = "log time of a message of /a: 18446744073709551612 ns; at most 9223372036854775807 ns";
    assert_eq!(reel.odd.as_deref(), Some(said));
}

/// What cannot be sent is counted and told, not tried: other encodings, the other order of bytes.
#[test]
fn what_cannot_be_sent_is_no_part_of_the_reel() {
    let mut reel = Reel::default();
    let (little, big, none) = ([0, 1, 0, 0], [0, 0, 0, 0], []);
    for (encoding, payload) in
        [("json", &little[..]), ("cdr", &big[..]), ("cdr", &none[..]), ("cdr", &little[..])]
    {
        let (topic, type_name, offered_qos) = ("/a", "std_msgs/msg/Empty", "");
        reel.message(&Raw { topic, type_name, encoding, offered_qos, log_ns: 1, payload });
    }
    assert_eq!((reel.frames.len(), reel.foreign.get("/a")), (1, Some(&3)));
}
