//! The recorder as a process over DDS, its bags as two independent Python readers see them, and a kill in the middle.
//! Real time passes here: DDS has no other.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // helpers of tests

#[path = "bag/clocked.rs"]
mod clocked;
#[path = "bag/foreign.rs"]
mod foreign;
#[path = "bag/played.rs"]
mod played;
#[path = "bag/process.rs"]
mod process;
#[path = "bag/publisher.rs"]
mod publisher;

use process::{Bag, Domain, Publisher, Recorder};
use rustix::process::Signal;
use serde_json::Value;
use std::collections::BTreeMap;
use std::time::Duration;

/// Messages by topic.
type Counts = BTreeMap<String, u64>;

/// A JSON object of counts.
fn counts(value: &Value) -> Counts {
    serde_json::from_value(value.clone()).unwrap()
}

/// The topics of `among` alone.
fn only(counts: &Counts, among: &Counts) -> Counts {
    counts.iter().filter(|(name, _)| among.contains_key(*name)).map(|(name, n)| (name.clone(), *n)).collect()
}

/// Both readers decode every message of the bag, and count what `metadata.yaml` and the recorder say.
fn read_by_all(bag: &Bag) -> Value {
    let read = bag.read();
    let reported = bag.reported();
    let expected = counts(&reported["topics"]);
    assert!(!expected.is_empty(), "{reported}");
    assert_eq!(counts(&read["rosbags"]["counts"]), expected, "rosbags against counts.json");
    assert_eq!(counts(&read["rosbags"]["declared"]), expected, "metadata.yaml against counts.json");
    assert_eq!(counts(&read["mcap"]["counts"]), expected, "mcap-ros2-support against counts.json");
    assert_eq!(read["rosbags"]["total"], reported["messages"]);
    assert_eq!(read["mcap"]["files"], reported["files"]);
    assert_eq!(reported["state"], "closed");
    assert_eq!(read["rosbags"]["differing"], serde_json::json!([]), "standard types that differ");
    read
}

/// Sent with a short window, so the recorder asks for best effort: on a busy host a few do not arrive.
const BEST_EFFORT: &str = "/printer/printer/state";

/// Every message sent is in the bag, once, readable by tools that share no code with us; the bag says what was printed.
/// What did not arrive on the best effort topic is counted.
#[test]
fn a_bag_holds_every_message_that_was_sent() {
    let bag = Bag::new("whole");
    let domain = Domain::new(0);
    let mut recorder = Recorder::start(&bag, domain);
    let mut sent = Publisher::start(domain, "known").sent();
    recorder.stop();

    let read = read_by_all(&bag);
    let reported = bag.reported();
    let mut recorded = only(&counts(&reported["topics"]), &sent);
    let (states, states_sent) = (recorded.remove(BEST_EFFORT).unwrap(), sent.remove(BEST_EFFORT).unwrap());
    assert_eq!(recorded, sent, "recorded against sent");
    let run = counts(&reported["run"]);
    assert_eq!((run["dropped"], run["received"]), (0, reported["messages"].as_u64().unwrap()));
    let lost = states_sent.checked_sub(states).expect("no message twice");
    assert!(lost <= run["missed"], "{lost} lost, {run:?}");
    let note = &read["mcap"]["note"];
    assert_eq!((&note["print_id"], &note["config"]), (&"cube".into(), &"a: 1\n".into()));
    assert_eq!(note["config_sha256"], publisher::CONFIG_SHA256);
    assert!(note["recorder_parameters"].as_str().unwrap().contains("bag_dir"));
    assert!(note["recorder_build"].as_str().unwrap().starts_with(env!("CARGO_PKG_VERSION")));
}

/// A recorder killed in the middle loses nothing that it had acknowledged: the next one in the same folder recovers the
/// file to exactly the whole records it held, and goes on in a second file. Both are one bag.
#[test]
fn a_killed_recorder_loses_nothing_it_acknowledged() {
    let bag = Bag::new("killed");
    let domain = Domain::new(1);
    let mut first = Recorder::start(&bag, domain);
    let mut publisher = Publisher::start(domain, "stream");
    let acknowledged = publisher.acknowledged(1, 300);
    first.kill();
    let held = bag.held_by_active(0);
    for (topic, count) in &acknowledged {
        assert!(held.get(topic) >= Some(count), "{topic}: {held:?} against {acknowledged:?}");
    }

    let mut second = Recorder::start(&bag, domain);
    publisher.acknowledged(2, 300);
    second.stop();
    let read = read_by_all(&bag);
    let files = counts(&read["mcap"]["files"]);
    assert_eq!(files.keys().collect::<Vec<_>>(), [&bag.file(0), &bag.file(1)]);
    assert_eq!(files[&bag.file(0)], held.values().sum::<u64>(), "recovered against held");
    assert!(files[&bag.file(1)] > 300, "{files:?}");
}

/// T1: a recorder whose disk is full ends and says so; the next one makes its file a bag that holds all that it had
/// acknowledged.
#[test]
fn a_full_disk_ends_the_recorder_and_loses_nothing_it_acknowledged() {
    let bag = Bag::new("full");
    let domain = Domain::new(2);
    let mut first = Recorder::start_on_full_disk(&bag, domain, 1024);
    let mut publisher = Publisher::start(domain, "stream");
    let acknowledged = publisher.acknowledged(1, 30);
    assert!(first.fails_within(Duration::from_secs(60)), "it goes on, or ends as if all were well");
    let held = bag.held_by_active(0);
    for (topic, count) in &acknowledged {
        assert!(held.get(topic) >= Some(count), "{topic}: {held:?} against {acknowledged:?}");
    }

    let mut second = Recorder::start(&bag, domain);
    publisher.acknowledged(2, 30);
    second.stop();
    let files = counts(&read_by_all(&bag)["mcap"]["files"]);
    assert_eq!(files[&bag.file(0)], held.values().sum::<u64>(), "recovered against held");
}

/// Whether these are the bytes that were sent: on the wire they are made up to a multiple of four with zeros.
fn is_of(heard: &[u8], sent: &[u8]) -> bool {
    heard.strip_prefix(sent).is_some_and(|rest| rest.len() < 4 && rest.iter().all(|byte| *byte == 0))
}

/// Reliable at both ends, with a window that is never full.
const MOTION: &str = "/printer/printer/motion";

/// A simulated print, played over DDS at 20 times its pace: the recorder writes the same bytes of each topic in the same
/// order, every one of a topic that is reliable at both ends; what did not arrive of a best effort topic it has counted as missed.
#[test]
fn a_bag_that_is_played_arrives_as_it_was_recorded() {
    let (print, bag, domain) = (Bag::new("print"), Bag::new("heard"), Domain::new(3));
    played::simulate(&print);
    let mut recorder = Recorder::start(&bag, domain);
    recorder.listens(&bag);
    let told = played::play(&print, domain);
    recorder.stop();

    let (sent, heard) = (print.payloads(), bag.payloads());
    let held: usize = sent.values().map(Vec::len).sum();
    assert!(held > 5000 && told["messages"] == held && told["published"] == held, "{held}: {told}");
    assert_eq!((&told["dropped"], &told["remarks"]), (&0.into(), &serde_json::json!([])), "{told}");
    // Lost between two that were heard, which a reader can know of, and before the first or after the last, which none can.
    let (mut between, mut around) = (0, 0);
    for (topic, sent) in &sent {
        let heard = heard.get(topic).unwrap_or_else(|| panic!("{topic}: not one of {} messages", sent.len()));
        let mut rest = sent.iter().enumerate();
        let mut place = |heard| rest.find(|(_, sent)| is_of(heard, sent)).map(|(place, _)| place);
        let places: Option<Vec<usize>> = heard.iter().map(|heard| place(heard)).collect();
        let places = places.unwrap_or_else(|| panic!("{topic}: other bytes, or another order"));
        let span = places[places.len() - 1] - places[0] + 1;
        between += span - heard.len();
        around += sent.len() - span;
    }
    let run = counts(&bag.reported()["run"]);
    assert!(between as u64 <= run["missed"], "{between} lost, {run:?}");
    assert!(around * 100 < held, "{around} of {held} lost before and after");
    for topic in [MOTION, "/printer/printer/coming", "/printer/estimate/state"] {
        assert_eq!(heard[topic].len(), sent[topic].len(), "{topic} is reliable at both ends");
    }
}

/// Stopped and continued twice, by SIGSTOP and by Ctrl-Z: each time it says so and goes on at its place in the bag. What
/// comes once and reliably is heard in its order; what was on its way when it stopped may be lost, latched words come again.
#[test]
fn a_play_that_was_stopped_goes_on_at_its_place() {
    let (print, bag, domain) = (Bag::new("long"), Bag::new("resumed"), Domain::new(4));
    played::simulate(&print);
    let mut recorder = Recorder::start(&bag, domain);
    recorder.listens(&bag);
    let play = played::Group::play(&print, domain, "10");
    for stop in [Signal::STOP, Signal::TSTP] {
        let bytes = bag.active_bytes();
        played::until(|| bag.active_bytes() > bytes + 200_000);
        play.signal(stop);
        play.stands_still();
        // Ten seconds of the bag, and more than the watch over the middleware allows.
        std::thread::sleep(Duration::from_secs(2));
        play.signal(Signal::CONT);
    }
    let (code, told) = play.ended();
    recorder.stop();
    let told: Value = serde_json::from_slice(&told).unwrap();
    assert_eq!(code, Some(0), "{told}");
    let remarks = told["remarks"].as_array().unwrap();
    assert!(remarks.len() == 2 && remarks.iter().all(|said| said.to_string().contains("goes on")), "{told}");
    assert!(told["published"].as_u64() >= told["messages"].as_u64(), "{told}");
    let (sent, heard) = (print.payloads(), bag.payloads());
    let (sent, heard) = (&sent[MOTION], &heard[MOTION]);
    let mut rest = sent.iter();
    assert!(heard.iter().all(|heard| rest.any(|sent| is_of(heard, sent))), "other bytes, or another order");
    assert!(is_of(heard.last().unwrap(), sent.last().unwrap()), "it did not come to its end");
    let lost = sent.len() - heard.len();
    println!("{lost} of {} lost", sent.len());
    assert!(lost * 50 < sent.len(), "{lost} of {} lost", sent.len());
}

/// Ctrl-C at a play and at a recorder that was started by `fdm record`: code 0, no process is left, the figures tell how far
/// it came, the bag is closed and every reader opens it.
#[test]
fn ctrl_c_ends_a_play_and_a_recorder_in_order() {
    let (print, bag, domain) = (Bag::new("printed"), Bag::new("interrupted"), Domain::new(5));
    played::simulate(&print);
    let record = played::Group::record(&bag, domain);
    played::until(|| bag.active_bytes() > 0);
    let play = played::Group::play(&print, domain, "5");
    played::until(|| bag.active_bytes() > 200_000);
    play.signal(Signal::INT);
    let (code, told) = play.ended();
    let told: Value = serde_json::from_slice(&told).unwrap();
    assert_eq!(code, Some(0), "{told}");
    let published = told["published"].as_u64().unwrap();
    assert!(published > 0 && published < told["messages"].as_u64().unwrap(), "{told}");
    // In the midst of its wait for subscribers too.
    let waiting = played::Group::play(&print, domain, "5");
    played::until(|| waiting.listens_to(Signal::INT));
    waiting.signal(Signal::INT);
    let (code, told) = waiting.ended();
    assert_eq!(code, Some(0), "{}", String::from_utf8_lossy(&told));
    record.signal(Signal::INT);
    assert_eq!(record.ended().0, Some(0));
    read_by_all(&bag);
}

/// A recorder that was stopped and continued has lost its middleware: its file is closed all the same, and who started it
/// is told to start it again.
#[test]
fn a_recorder_that_was_stopped_leaves_a_bag() {
    let (print, bag, domain) = (Bag::new("source"), Bag::new("stopped"), Domain::new(6));
    played::simulate(&print);
    let record = played::Group::record(&bag, domain);
    played::until(|| bag.active_bytes() > 0);
    let play = played::Group::play(&print, domain, "5");
    played::until(|| bag.active_bytes() > 20_000);
    record.signal(Signal::STOP);
    std::thread::sleep(Duration::from_secs(2));
    record.signal(Signal::CONT);
    assert_eq!(record.ended().0, Some(1));
    assert_eq!(bag.active_bytes(), 0, "no file is left open");
    play.signal(Signal::INT);
    play.ended();
    read_by_all(&bag);
}

/// Somebody publishes what is to be played, a print that runs or another play: a supervisor would take one's readings for the
/// other's. Who wants it all the same says so.
#[test]
fn a_bag_is_not_played_into_a_graph_that_lives() {
    let (print, domain) = (Bag::new("beside"), Domain::new(8));
    played::simulate(&print);
    let living = played::Group::play(&print, domain, "1");
    // Its own look for others is over, and its wait for subscribers lasts longer.
    std::thread::sleep(Duration::from_secs(3));
    let (code, said) = played::tried(&print, domain, &[]);
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("is published already in this ROS_DOMAIN_ID") && said.contains("--beside-live"),
        "{said}"
    );
    let how = ["--beside-live", "--topics", "print/info", "--rate", "100"];
    let (code, said) = played::tried(&print, domain, &how);
    assert_eq!(code, Some(0), "{said}");
    living.signal(Signal::INT);
    assert_eq!(living.ended().0, Some(0));
}

/// The publishing process of the tests above: they start this program again with a role.
#[test]
#[ignore = "a process of the other tests"]
fn publisher_process() {
    if let Ok(role) = std::env::var(process::ROLE) {
        publisher::run(&role);
    }
}
