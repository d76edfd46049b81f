//! kill -9, and SIGSTOP for 5 s, of each node but the simulated printer in turn during a print, over DDS at real time:
//! seen within 1 s, at the slicer's values in time, whole again within 5 s (`design` catalogue C1, C2, C4, C5, S7, T2).
//!
//! The graph is `fdm up`, which starts ended processes again; the observer is one more participant. Real time passes
//! here: DDS and processes have no other.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    reason = "helpers of tests: a failure is the test's failure; the times are for people"
)]

#[path = "process_faults/graph.rs"]
mod graph;
#[path = "process_faults/observer.rs"]
mod observer;
#[path = "process_faults/report.rs"]
mod report;
#[path = "process_faults/trial.rs"]
mod trial;

use fdm_loop_msgs::{PrinterState, SafetyState};
use graph::{Graph, root};
use models::units::Seconds;
use observer::{Observer, Seen, is_neutral};
use std::process::Command;
use trial::{Fault, Role, Trial};

/// Set in the process that observes: the domain is read from the environment, which a test cannot change in itself.
const OBSERVER: &str = "FDM_PROCESS_FAULTS_OBSERVER";
/// Longest time from the start to a closed loop on a warm printer.
const START: Seconds = Seconds(40.0);
/// Longest orderly end: every node promises 2 s, the recorder ends after the others.
const END: Seconds = Seconds(6.0);

/// All nodes but the printer, the thermistor last: its stop ends the job.
const NODES: [(&str, Role); 9] = [
    ("bag_recorder", Role::Aside),
    ("imu", Role::Watch),
    ("camera", Role::Watch),
    ("defect_classifier", Role::Watch),
    ("filament_encoder", Role::ControlPath),
    ("state_estimator", Role::ControlPath),
    ("mpc_controller", Role::ControlPath),
    ("safety_supervisor", Role::Supervisor),
    ("thermistor", Role::ControlPath),
];

#[test]
fn a_node_that_dies_or_hangs_is_seen_made_harmless_and_replaced() {
    if std::env::var_os(OBSERVER).is_none() {
        let status = Command::new(std::env::current_exe().unwrap())
            .args(["a_node_that_dies_or_hangs_is_seen_made_harmless_and_replaced", "--exact", "--nocapture"])
            .env(OBSERVER, "1")
            // Ports of domains up to 101 lie below the ephemeral ones.
            .env("ROS_DOMAIN_ID", (20 + std::process::id() % 80).to_string())
            .status()
            .unwrap();
        assert!(status.success(), "the observer failed, see above");
        return;
    }
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    executor.block_on(async {
        let mut graph = Graph::start();
        let mut observer = Observer::join();
        wait_for_print(&mut observer, &mut graph).await;
        let mut trials = Vec::new();
        for fault in [Fault::Kill, Fault::Stop] {
            for (node, role) in NODES {
                trials.push(Trial::run(node, role, fault, (&mut observer, &mut graph)).await);
            }
        }
        let mended = acknowledge(&mut observer, &mut graph).await;
        println!("{}", report::table(&trials));
        println!("acknowledged {mended:.2} s after the thermistor's first beat");
        let bag = end(&mut observer, &mut graph).await;
        println!("{bag}");
        let failures = report::failures(&trials);
        assert!(failures.is_empty(), "{}", failures.join("\n"));
    });
}

/// Until the supervisor acts, the printer prints and corrections are in force.
async fn wait_for_print(observer: &mut Observer, graph: &mut Graph) {
    let (mut acts, mut prints) = (false, false);
    let begin = observer.now();
    let closed = observer.until(graph, START, |_, seen| {
        match seen {
            Seen::Safety(state) => acts = state.mode == SafetyState::MODE_ACT,
            Seen::Printer(state) => {
                prints = state.phase == PrinterState::PHASE_PRINTING && !is_neutral(state)
            }
            _ => {}
        }
        acts && prints
    });
    assert!(closed.await, "no closed loop within {} s: acts {acts}, prints {prints}", START.0);
    assert_eq!(graph.pids().len(), 10, "{:?}", graph.pids());
    println!("closed loop after {:.1} s", (observer.now() - begin).0);
}

/// The job was given up and the heaters are off. A person acknowledges: the mode returns, the job does not.
async fn acknowledge(observer: &mut Observer, graph: &mut Graph) -> f64 {
    let mut newest = None;
    let off = observer.until(graph, Seconds(2.0), |_, seen| {
        if let Seen::Printer(state) = seen {
            newest = Some(state.clone());
        }
        newest.as_ref().is_some_and(|state| {
            state.phase == PrinterState::PHASE_FAILED
                && (state.hotend_target_degc, state.bed_target_degc) == (0.0, 0.0)
                && (state.hotend_duty, state.bed_duty) == (0.0, 0.0)
        })
    });
    assert!(off.await, "heaters are not off, or the job was not given up: {newest:?}");
    let begin = observer.now();
    // The first temperature may not have reached the supervisor yet: it says so, and is asked again.
    let granted = loop {
        let (granted, answer) = observer.acknowledge().await;
        println!("acknowledge: {granted}, {answer}");
        if granted || (observer.now() - begin).0 > 5.0 {
            break granted;
        }
    };
    assert!(granted, "not acknowledged within 5 s");
    let mut mode = u8::MAX;
    let returned = observer.until(graph, Seconds(5.0), |_, seen| {
        if let Seen::Safety(state) = seen {
            mode = state.mode;
        }
        mode == SafetyState::MODE_ACT
    });
    assert!(returned.await, "the mode does not return, it is {mode}");
    let after = (observer.now() - begin).0;
    let stays_off = |state: &PrinterState| {
        state.phase == PrinterState::PHASE_FAILED
            && (state.hotend_target_degc, state.hotend_duty) == (0.0, 0.0)
    };
    let heated = observer.until(graph, Seconds(1.0), |_, seen| match seen {
        Seen::Printer(state) => !stays_off(state),
        _ => false,
    });
    assert!(!heated.await, "the heaters were energised again");
    after
}

/// Ctrl-C: exit code 0, no process left, a bag that two Python readers open.
async fn end(observer: &mut Observer, graph: &mut Graph) -> String {
    let begin = observer.now();
    graph.interrupt();
    let mut status = None;
    while status.is_none() && (observer.now() - begin).0 < END.0 {
        observer.next(graph).await;
        status = graph.ended();
    }
    let took_s = (observer.now() - begin).0;
    let status = status.expect("fdm does not end");
    assert_eq!(status.code(), Some(0), "{status}");
    assert_eq!(graph.alive(), Vec::<&String>::new(), "processes are left");
    let counted = Command::new(root().join("target/venv/bin/python"))
        .arg(root().join("tests/readers/count.py"))
        .arg(graph.bag())
        .output()
        .expect("target/venv is missing: launch_scripts/test.sh makes it");
    assert!(counted.status.success(), "{}", String::from_utf8_lossy(&counted.stderr));
    let read: serde_json::Value = serde_json::from_slice(&counted.stdout).unwrap();
    let reported = std::fs::read_to_string(graph.bag().join("counts.json")).unwrap();
    let reported: serde_json::Value = serde_json::from_str(&reported).unwrap();
    assert_eq!(read["rosbags"]["counts"], reported["topics"], "rosbags against the recorder");
    assert_eq!(read["mcap"]["counts"], reported["topics"], "mcap-ros2-support against the recorder");
    format!("ended in {took_s:.1} s; bag: {} messages in {}", reported["messages"], reported["files"])
}
