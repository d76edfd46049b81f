//! A print whose supervisor hangs, is deactivated, shut down or killed again and again: a person is told, and can stop the
//! printer all the same. Real time passes here: DDS and processes have no other.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests: a failure is the test's failure"
)]

#[allow(dead_code, reason = "each test uses its part of it")]
#[path = "process_faults/graph.rs"]
mod graph;

use fdm_loop_msgs::{ChangeState, ChangeStateRequest, DiagnosticStatus, PrinterState, Transition};
use graph::{Graph, Network, program};
use models::units::Seconds;
use runtime::{Args, Client, Node, topics};
use rustix::process::Signal;
use std::process::Output;
use std::time::{Duration, Instant};

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(60);
/// Longest wait of a person for a stop, its confirmation included.
const STOPS: Duration = Duration::from_secs(3);
/// Who guards.
const GUARD: &str = "safety_supervisor";

#[test]
fn a_print_without_its_supervisor_is_told_and_can_be_stopped() {
    let test = "a_print_without_its_supervisor_is_told_and_can_be_stopped";
    if let Some(alone) = system_tests::run_in_own_domain(test, 5).unwrap() {
        assert!(alone.success(), "it failed in its own domain, see above");
        return;
    }
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    executor.block_on(async {
        let domain = std::env::var("ROS_DOMAIN_ID").unwrap();
        let mut graph = Graph::start(&domain, Network::OfTheTest);
        told(&mut graph, ", act, ").await;
        let mut node = Node::start_with("person", Args::default()).unwrap();
        let change = node.client_of(&format!("/printer/{GUARD}"), &topics::CHANGE_STATE).unwrap();
        it_is_taken_out_of_its_work(&mut graph, &mut node, &change).await;
        it_is_shut_down(&mut graph, &change).await;
        it_hangs_for_long(&mut graph).await;
        it_hangs_and_the_printer_is_stopped(&mut graph, &mut node, &domain).await;
        // A person ended it, past the supervisor: `fdm up` has heard so on `events`.
        graph.end(0).await;
    });
}

/// Waits for a line of `fdm up`.
async fn told(graph: &mut Graph, what: &str) -> String {
    tokio::time::timeout(PATIENCE, graph.until(what)).await.expect(what)
}

/// Asks the supervisor for a step.
async fn step(change: &Client<ChangeState>, id: u8) {
    let transition = Transition { id, label: String::new() };
    let answer = change.call(ChangeStateRequest { transition }, Seconds(10.0)).await;
    assert!(answer.expect("nobody answers").success, "transition {id}");
}

/// Deactivated by anybody: it is silent, and says so itself; so does the printer.
async fn it_is_taken_out_of_its_work(graph: &mut Graph, node: &mut Node, change: &Client<ChangeState>) {
    let mut reports = node.subscribe(&topics::DIAGNOSTICS).unwrap();
    step(change, Transition::DEACTIVATE).await;
    told(graph, "nobody watches the heaters; `fdm estop` still works").await;
    told(graph, "safety_supervisor is inactive, somebody has taken it out of its work").await;
    told(graph, ", no supervisor, ").await;
    let warned = async {
        let mut missing = vec!["/printer/safety_supervisor", "/printer/printer_sim"];
        while !missing.is_empty() {
            for status in reports.recv().await.message.status {
                let warns = status.level == DiagnosticStatus::WARN && status.message.contains("the heaters");
                missing.retain(|name| !(warns && *name == status.name));
            }
        }
    };
    tokio::time::timeout(PATIENCE, warned).await.expect("no warning on /diagnostics");
    step(change, Transition::ACTIVATE).await;
    told(graph, "safety_supervisor watches the printer again").await;
}

/// Shut down by anybody: a process that does nothing for good is replaced.
async fn it_is_shut_down(graph: &mut Graph, change: &Client<ChangeState>) {
    step(change, Transition::ACTIVE_SHUTDOWN).await;
    told(graph, "safety_supervisor was shut down (finalized)").await;
    told(graph, "safety_supervisor runs again as process").await;
    told(graph, ", act, ").await;
}

/// It hangs for so long that it is replaced.
async fn it_hangs_for_long(graph: &mut Graph) {
    graph.signal(GUARD, Signal::STOP);
    told(graph, "safety_supervisor has been silent for 10 s: it is ended by force").await;
    told(graph, "safety_supervisor runs again as process").await;
    told(graph, ", act, ").await;
}

/// It hangs, and `fdm estop` reaches the printer.
async fn it_hangs_and_the_printer_is_stopped(graph: &mut Graph, node: &mut Node, domain: &str) {
    let mut states = node.subscribe(&topics::PRINTER_STATE).unwrap();
    graph.signal(GUARD, Signal::STOP);
    let begin = Instant::now();
    let estop = tokio::process::Command::new(program("fdm"))
        .arg("estop")
        .env("ROS_DOMAIN_ID", domain)
        .env_remove("RUST_LOG")
        .output();
    let Output { status, stdout, stderr } = estop.await.unwrap();
    let said = format!("{}{}", String::from_utf8_lossy(&stdout), String::from_utf8_lossy(&stderr));
    println!("{:.2} s: {said}", begin.elapsed().as_secs_f64());
    assert!(
        status.success() && said.contains("told the printer itself, which confirms: heaters off"),
        "{said}"
    );
    assert!(begin.elapsed() < STOPS, "{:?}", begin.elapsed());
    while states.try_recv().is_some() {}
    let state = tokio::time::timeout(PATIENCE, states.recv()).await.expect("no state").message;
    assert_eq!((state.phase, state.mains_on), (PrinterState::PHASE_FAILED, false), "{state:?}");
    assert!(state.hotend_target_degc <= 0.0 && state.bed_target_degc <= 0.0, "{state:?}");
}
