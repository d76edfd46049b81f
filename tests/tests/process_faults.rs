//! The faults of the catalogue that need processes: `fdm faults --process` over DDS at real time, and `fdm up` itself,
//! which starts ended processes again and ends in order. Real time passes here: DDS and processes have no other.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests: a failure is the test's failure; the figures are for people"
)]

#[allow(dead_code, reason = "each test uses its part of it")]
#[path = "process_faults/graph.rs"]
mod graph;

use cli::faults::catalogue::Catalogue;
use graph::{Graph, Network, Said, program, root};
use rustix::process::Signal;
use serde_json::Value;
use std::process::Command;
use std::time::{Duration, Instant};

/// A domain that no other test uses at the same time; ports of domains up to 101 lie below the ephemeral ones.
fn domain(test: u32) -> String {
    (20 + (std::process::id() * 2 + test) % 80).to_string()
}

/// What a short run on a shared machine says nothing of: how regular ticks are, how memory grows.
const FIGURES_OF_THE_MACHINE: [&str; 3] = ["C11", "L1", "L5"];

/// Time limits that a single try in debug programs says little of, on a machine that others use too: a hang (C4, 0.5 s) and
/// one emergency stop (L4, 0.25 s). `fdm faults --process` holds them.
const OF_A_SINGLE_TRY: [&str; 2] = ["C4", "L4"];
/// How late those may be here `[s]`.
const LATE_S: f64 = 1.0;

/// Whether a trial kept its limits, or missed one of time by less than that, and nothing else.
fn is_little_late(trial: &Value) -> bool {
    let late = |miss: &str| {
        let (_, what) = miss.split_once(": ").unwrap();
        what.split("; ").all(|part| {
            ["told after ", "degraded after ", "estop after "].iter().any(|late| part.starts_with(late))
        })
    };
    let misses = trial["misses"].as_array().unwrap();
    let soon = ["told_max_s", "reaction_max_s"].iter().all(|time| trial[time].as_f64() <= Some(LATE_S));
    misses.is_empty() || soon && misses.iter().all(|miss| late(miss.as_str().unwrap()))
}

/// Every process trial of the catalogue but those, with one seed; all of them with twenty run in `test.sh --long`.
#[test]
fn what_needs_processes_keeps_its_limits() {
    let catalogue = Catalogue::read(&root().join("config/faults.yaml")).unwrap();
    let with_processes: Vec<&str> = catalogue
        .faults
        .iter()
        .filter(|fault| !fault.process.is_empty())
        .map(|fault| fault.id.as_str())
        .filter(|id| !FIGURES_OF_THE_MACHINE.contains(id))
        .collect();
    let output = Command::new(program("fdm"))
        .current_dir(root())
        .args(["faults", "--process", "--seeds", "1..1", "--json", "-", "--only", &with_processes.join(",")])
        .env("ROS_DOMAIN_ID", domain(0))
        .env_remove("RUST_LOG")
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    println!("{told}");
    let figures: Value = serde_json::from_slice(&output.stdout).expect("figures");
    let faults = figures["faults"].as_array().unwrap();
    let shown: Vec<&str> = faults.iter().filter_map(|fault| fault["id"].as_str()).collect();
    assert_eq!(shown, with_processes, "every ID with a process trial is shown");
    for fault in faults {
        assert_eq!(fault["level"], "process");
        let kept = fault["within_limit"] == true;
        let id = fault["id"].as_str().unwrap();
        let late = OF_A_SINGLE_TRY.contains(&id) && trials_of(fault).iter().all(is_little_late);
        let misses: Vec<&Value> = trials_of(fault).iter().map(|trial| &trial["misses"]).collect();
        assert!(kept || late, "{id}: {misses:?}\n{told}\n{fault:#}");
        assert_eq!(fault["runs"].as_u64(), fault["trials"].as_array().map(|trials| trials.len() as u64));
    }
    assert_eq!(figures["false_trips"], 0, "{figures:#}");
    let kept = faults.iter().all(|fault| fault["within_limit"] == true);
    assert_eq!(output.status.code(), Some(i32::from(!kept)), "{told}\n{figures:#}");
    // Detection and actuation are figures of their own, and nothing is called degraded that went on.
    for trial in ["C1", "C4"].iter().flat_map(|id| of(faults, id)["trials"].as_array().unwrap()) {
        assert!(trial["told_max_s"].is_number() && trial["told_limit_source"] == "catalogue", "{trial:#}");
        assert_eq!(
            trial["action"] == "degraded",
            trial["reaction_max_s"].is_number() && trial["action"] != "safe_off"
        );
    }
    // The figures that are asked for by name.
    for (id, name) in [("P13", "answer"), ("C10", "whole")] {
        for trial in of(faults, id)["trials"].as_array().unwrap() {
            let measures = trial["measures"].as_array().unwrap();
            let measure = measures.iter().find(|measure| measure["name"] == name).expect(id);
            assert!(
                measure["p999_s"].is_number() && measure["count"].as_u64() >= Some(10),
                "{id}: {measure}"
            );
        }
    }
}

fn trials_of(fault: &Value) -> &[Value] {
    fault["trials"].as_array().unwrap()
}

fn of<'a>(faults: &'a [Value], id: &str) -> &'a Value {
    faults.iter().find(|fault| fault["id"] == id).unwrap()
}

/// Programs that are missing are no missed limits.
#[test]
fn without_its_nodes_nothing_is_tried() {
    let folder = std::env::temp_dir().join(format!("fdm_alone_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let alone = folder.join("fdm");
    std::fs::copy(program("fdm"), &alone).unwrap();
    let output = Command::new(&alone)
        .current_dir(root())
        .args(["faults", "--process", "--only", "C1", "--config", "config"])
        .env("ROS_DOMAIN_ID", domain(0))
        .output()
        .unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{told}");
    assert!(!told.contains("limits missed"), "{told}");
}

/// Longest time from the last start until every node is active and the printer is heard. C12 asks for 5 s, which
/// `fdm faults --process` holds graphs to in every order of starts (C10, `whole`). Here it is twice that: another graph of
/// this very file comes up on the same two cores meanwhile, of debug binaries as well, and each gets half of them. (Alone
/// it takes 1.6 s.) A graph that does not find itself on a plain `lo` never comes up at all.
const UP: Duration = Duration::from_secs(10);

/// What `fdm up` does by itself, seen by what it says alone; Ctrl-C ends it in order, with a bag that others can read. C12:
/// all of it where nothing but `lo` is there.
#[test]
fn a_node_that_dies_is_started_again_and_all_end_with_ctrl_c() {
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    executor.block_on(async {
        let mut graph = Graph::start(&domain(1), Network::Own);
        let started = async { while graph.pids().is_empty() && graph.next().await == Said::Other {} };
        tokio::time::timeout(Duration::from_secs(60), started).await.expect("nothing is started");
        let last_start = Instant::now();
        let up = async { while !graph.prints() && graph.next().await == Said::Other {} };
        tokio::time::timeout(UP, up).await.expect("the graph is not whole in time, or a node died");
        println!("whole {:.1} s after the last start", last_start.elapsed().as_secs_f64());
        assert_eq!(graph.pids().len(), 10, "{:?}", graph.pids());
        for node in ["bag_recorder", "state_estimator"] {
            graph.signal(node, Signal::KILL);
            let again = async { while graph.next().await != Said::RunsAgain(node.to_owned()) {} };
            tokio::time::timeout(Duration::from_secs(5), again).await.expect("it is not started again");
        }
        graph.end(0).await;
        assert_eq!(graph.alive(), Vec::<&String>::new(), "processes are left");
        let counted = Command::new(root().join("target/venv/bin/python"))
            .arg(root().join("tests/readers/count.py"))
            .arg(graph.bag())
            .output()
            .expect("target/venv is missing: launch_scripts/test.sh makes it");
        assert!(counted.status.success(), "{}", String::from_utf8_lossy(&counted.stderr));
        let read: Value = serde_json::from_slice(&counted.stdout).unwrap();
        let reported = std::fs::read_to_string(graph.bag().join("counts.json")).unwrap();
        let reported: Value = serde_json::from_str(&reported).unwrap();
        assert_eq!(read["rosbags"]["counts"], reported["topics"], "rosbags against the recorder");
        assert_eq!(read["mcap"]["counts"], reported["topics"], "mcap-ros2-support against the recorder");
    });
}
