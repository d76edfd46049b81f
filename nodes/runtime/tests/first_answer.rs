//! What a server says before anybody asks, as another participant sees it. Real time passes here: DDS has no other.
#![allow(clippy::unwrap_used, clippy::expect_used)] // helpers of tests: a failure is the test's failure

use fdm_loop_msgs::{SetModeRequest, SetModeResponse};
use rustdds::no_key::{DataReaderCdr, DataWriterCdr};
use rustdds::policy::{History, Reliability};
use rustdds::{DomainParticipant, Duration as DdsDuration, QosPolicyBuilder, TopicKind};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A node that does not outlive its test.
struct Talker(Child);

impl Drop for Talker {
    fn drop(&mut self) {
        _ = self.0.kill();
        _ = self.0.wait();
    }
}

/// A client's first answer is not the first sample of its server: Cyclone DDS loses that one where a heartbeat tells of it
/// before it has come.
#[test]
fn the_first_sample_of_a_server_is_nobodys_answer() {
    let domain = u16::try_from(20 + (std::process::id() * 3 + 7) % 80).unwrap();
    let tests = std::env::current_exe().unwrap();
    let pair: PathBuf = tests.parent().unwrap().parent().unwrap().join("examples/pair");
    let talker = Command::new(pair)
        .args(["--ros-args", "-p", "role:=talker"])
        .env("ROS_DOMAIN_ID", domain.to_string())
        .env_remove("RMW_IMPLEMENTATION")
        .stderr(Stdio::null())
        .spawn();
    let _talker = Talker(talker.unwrap());

    let participant = DomainParticipant::new(domain).unwrap();
    let qos = QosPolicyBuilder::new()
        .reliability(Reliability::Reliable { max_blocking_time: DdsDuration::from_millis(100) })
        .history(History::KeepLast { depth: 10 })
        .build();
    let topic = |name: &str, kind: &str| {
        let kind = format!("fdm_loop_msgs::srv::dds_::SetMode_{kind}_");
        participant.create_topic(name.to_owned(), kind, &qos, TopicKind::NoKey).unwrap()
    };
    let requests = topic("rq/printer/safety/set_modeRequest", "Request");
    let replies = topic("rr/printer/safety/set_modeReply", "Response");
    let writer: DataWriterCdr<SetModeRequest> =
        participant.create_publisher(&qos).unwrap().create_datawriter_no_key_cdr(&requests, None).unwrap();
    let mut reader: DataReaderCdr<SetModeResponse> =
        participant.create_subscriber(&qos).unwrap().create_datareader_no_key_cdr(&replies, None).unwrap();

    let begin = Instant::now();
    let is_server = |name: &str| {
        participant.discovered_writers().iter().any(|writer| writer.publication_topic_data.topic_name == name)
    };
    while !is_server("rr/printer/safety/set_modeReply") {
        assert!(begin.elapsed() < Duration::from_secs(30), "no server");
        std::thread::sleep(Duration::from_millis(10));
    }
    // Both ends match a little later: what is said before is heard by nobody.
    std::thread::sleep(Duration::from_millis(500));
    let answer = loop {
        assert!(begin.elapsed() < Duration::from_secs(30), "no answer");
        writer.write(SetModeRequest { mode: SetModeRequest::MODE_OBSERVE }, None).unwrap();
        std::thread::sleep(Duration::from_millis(100));
        // Who has matched before the first sample hears that one too.
        if let Some(answer) = reader.take_next_sample().unwrap().filter(|answer| answer.value().accepted) {
            break answer;
        }
    };
    let number = i64::from(answer.sample_info().sample_identity().sequence_number);
    assert!(number > 1, "number {number}: {:?}", answer.value());
}
