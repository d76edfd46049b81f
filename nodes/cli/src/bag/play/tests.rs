use super::*;

#[test]
fn quality_of_service_is_read_as_it_is_written() {
    let written = bag_recorder::offered_qos::OfferedQos { reliable: false, transient_local: true, depth: 7 };
    let read = offered(&written.text());
    assert_eq!(
        (read.reliability, read.durability, read.depth),
        (Reliability::BestEffort, Durability::TransientLocal, 7)
    );
    assert_eq!(offered("").depth, DEPTH);
}

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
