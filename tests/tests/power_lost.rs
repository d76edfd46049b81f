//! P11: the power is lost. `fdm` and every node of a graph end in the same instant, in the midst of whatever they write;
//! with the next boot the bag is there, and nothing goes on by itself. Real time passes here: DDS and processes have no
//! other.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests: a failure is the test's failure"
)]

#[path = "power_lost/boot.rs"]
mod boot;
#[allow(dead_code, reason = "each test uses its part of it")]
#[path = "process_faults/graph.rs"]
mod graph;

use fdm_loop_msgs::{PrinterState, TriggerRequest};
use graph::{Graph, Network, program, root};
use models::units::Seconds;
use runtime::{Args, Node, topics};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(60);
/// Recorded before the power is lost: enough for several syncs of the recorder's, which come once a second.
const PRINTED: Duration = Duration::from_secs(5);

#[test]
fn a_bag_and_a_latch_outlive_a_loss_of_power() {
    let test = "a_bag_and_a_latch_outlive_a_loss_of_power";
    if let Some(alone) = system_tests::run_in_own_domain(test, 3).unwrap() {
        assert!(alone.success(), "it failed in its own domain, see above");
        return;
    }
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    executor.block_on(async {
        let mut graph = Graph::start(&std::env::var("ROS_DOMAIN_ID").unwrap(), Network::OfTheTest);
        let printing = async {
            while graph.pids().is_empty() || !graph.prints() {
                graph.next().await;
            }
        };
        tokio::time::timeout(PATIENCE, printing).await.expect("nothing is printed");
        let latched = ["safety_supervisor", "thermistor", "printer_sim"].map(|node| graph.command_of(node));
        it_heats_until_a_person_stops_it(&mut graph).await;
        graph.lose_power();
        the_bag_is_whole_but_for_its_end(graph.bag().as_path());
        boot::stays_off(latched).await;
    });
}

/// A hot printer in the midst of a print, and then a latched stop; the power is lost right after it is told.
async fn it_heats_until_a_person_stops_it(graph: &mut Graph) {
    let mut node = Node::start_with("person", Args::default()).unwrap();
    let mut printer = node.subscribe(&topics::PRINTER_STATE).unwrap();
    let mut safety = node.subscribe(&topics::SAFETY_STATE).unwrap();
    let estop = node.client(&topics::SAFETY_ESTOP).unwrap();
    let mut heats = false;
    let watched = async {
        let begin = tokio::time::Instant::now();
        while !heats || begin.elapsed() < PRINTED {
            let state = printer.recv().await.message;
            heats |= state.hotend_duty > 0.0 && state.phase == PrinterState::PHASE_PRINTING;
        }
    };
    tokio::time::timeout(PATIENCE, watched).await.expect("it does not heat and print");
    let answer = estop.call(TriggerRequest::default(), Seconds(10.0)).await.expect("nobody answers");
    assert!(answer.success && answer.message.starts_with("mode estop"), "{}", answer.message);
    // An answer does not wait for the disk; the mode is told as latched from when it is.
    let told = async { while !safety.recv().await.message.latched {} };
    tokio::time::timeout(PATIENCE, told).await.expect("the latch is not told");
    assert_eq!(graph.alive().len(), graph.pids().len(), "all run until the power is lost");
}

/// What was written is neither lost nor bent, and a report tells that the end is missing.
fn the_bag_is_whole_but_for_its_end(bag: &Path) {
    let active = bag.join("bag_0.mcap.active");
    assert!(active.is_file(), "{} is missing: the bag was closed", active.display());
    let page = cli::report::page(bag, None).unwrap();
    assert!(page.contains("This bag is not whole"), "the report tells nothing of it");
    let written = count(&["--active".as_ref(), active.as_os_str()]);
    let recovered = Command::new(program("fdm")).args(["recover", "--json", "-"]).arg(bag).output().unwrap();
    assert!(recovered.status.success(), "{}", String::from_utf8_lossy(&recovered.stderr));
    let recovered: Value = serde_json::from_slice(&recovered.stdout).unwrap();
    println!("recovered: {recovered}");
    let read = count(&[bag.as_os_str()]);
    let reported = std::fs::read_to_string(bag.join("counts.json")).unwrap();
    let reported: Value = serde_json::from_str(&reported).unwrap();
    assert_eq!(reported["topics"], written, "the recorder against the records that the power left whole");
    assert_eq!(read["rosbags"]["counts"], written, "rosbags");
    assert_eq!(read["mcap"]["counts"], written, "mcap-ros2-support");
    assert_eq!(read["rosbags"]["total"], recovered["messages"]);
    let states = written["/printer/printer/state"].as_u64();
    // 50 Hz, of which the recorder may hold a second back, and a busy machine half.
    assert!(states >= Some(100), "{states:?} states of a print of {PRINTED:?}");
    assert_eq!(recovered["files"][0]["outcome"], "recovered", "{recovered}");
}

/// What the Python readers find.
fn count(arguments: &[&std::ffi::OsStr]) -> Value {
    let mut python = Command::new(root().join("target/venv/bin/python"));
    let counted = python.arg(root().join("tests/readers/count.py")).args(arguments).output();
    let counted = counted.expect("target/venv is missing: launch_scripts/test.sh makes it");
    assert!(counted.status.success(), "{}", String::from_utf8_lossy(&counted.stderr));
    serde_json::from_slice(&counted.stdout).unwrap()
}
