//! X1: garbage on the network. Whatever reaches the RTPS ports of a printing graph, the printer is at the slicer's values
//! within 0.25 s of the last permit that it can have heard, what dies is started again, and the graph is whole again by
//! itself: within 5 s of the last datagram where `FDM_WHOLE_LIMIT_S` holds it to that, as the long form of the tests does.
//!
//! The graph is `fdm up` in a network namespace of its own, the garbage comes from `tests/rtps_fuzz.py`, and what the
//! printer did is read from its states as an observer heard them and as the bag holds them. `FDM_RTPS_DATAGRAMS` sets
//! how many datagrams there are in all. Real time passes here: DDS and processes have no other.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    clippy::panic,
    reason = "helpers of tests: a failure is the test's failure; the figures are for people"
)]

#[path = "rtps_garbage/graph.rs"]
mod graph;
#[path = "rtps_garbage/judge.rs"]
mod judge;
#[path = "rtps_garbage/observer.rs"]
mod observer;
#[path = "rtps_garbage/report.rs"]
mod report;
#[path = "rtps_garbage/storm.rs"]
mod storm;

use graph::Graph;
use judge::Record;
use models::units::Seconds;
use observer::Observer;
use std::process::Command;
use storm::{Kind, Storm, Targets};

/// Set in the process that observes, inside the namespace.
const OBSERVER: &str = "FDM_RTPS_GARBAGE_OBSERVER";
/// Leaves the other kinds out, to look at one.
const ONLY: &str = "FDM_RTPS_KIND";
const TEST: &str = "garbage_on_the_network_is_survived";
/// Longest time from the start to a closed loop on a warm printer.
const START: Seconds = Seconds(40.0);
/// Longest orderly end of a graph.
const END: Seconds = Seconds(8.0);
/// A loopback interface as other machines have it, and DDS to be heard on it.
const NAMESPACE: &str = "ip link set lo up multicast on && ip route add 239.0.0.0/8 dev lo && exec \"$@\"";

/// Datagrams in all.
fn datagrams() -> u32 {
    std::env::var("FDM_RTPS_DATAGRAMS").ok().and_then(|text| text.parse().ok()).unwrap_or(20_000)
}

/// What is sent, mild kinds first: each hits every participant or, where it ends those that it hits, the nodes that are
/// started again. (The simulated printer is none of them, as its firmware is on no network.)
fn kinds() -> [Kind; 8] {
    let all = datagrams();
    // Two participants a node, and as many fakes to each as once made the middleware deaf for 9 s in the long form; one
    // datagram of a kind that ends processes does what many others do.
    let fakes = 2 * u32::try_from(storm::NODES.len()).unwrap() * (all / 20).min(2000);
    let (fragments, known) = (all / 100, all / 20);
    let rest = (all - fragments - 2 * known) / 4;
    let mild = |name, count| Kind { name, count, targets: Targets::Everyone, deadly: false };
    let kind = |name, count, targets| Kind { name, count, targets, deadly: true };
    [
        mild("garbage", rest),
        mild("valid_header", rest),
        mild("heartbeats", rest),
        // A quarter of these are participants that are believed in.
        kind("discovery", rest, Targets::Replaceable),
        kind("known_writer", known, Targets::Replaceable),
        kind("acknack", known, Targets::Replaceable),
        kind("participants", fakes, Targets::EachReplaceable),
        kind("data_frag", fragments, Targets::Replaceable),
    ]
}

#[test]
fn garbage_on_the_network_is_survived() {
    if std::env::var_os(OBSERVER).is_none() {
        assert!(inside_a_namespace().status().unwrap().success(), "the observer failed, see above");
        return;
    }
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    executor.block_on(async {
        let mut storms: Vec<Storm> = Vec::new();
        let mut kinds = kinds().into_iter().filter(|kind| kind.count > 0 && chosen(kind)).peekable();
        while kinds.peek().is_some() {
            let mut graph = Graph::start();
            let mut observer = Observer::join();
            let mut record = Record::default();
            observer.wait_for_print(&mut graph, START).await;
            let first = storms.len();
            for kind in kinds.by_ref() {
                let storm = Storm::run(kind, &mut observer, &mut graph, &mut record).await;
                let goes_on = storm.goes_on();
                storms.push(storm);
                // A print that was given up says nothing of corrections any more.
                if !goes_on {
                    break;
                }
            }
            observer.end(&mut graph, END, &mut record).await;
            let read = record.add_bag(&graph.bag());
            println!("{read} messages of the bag");
            // 50 permits a second, and a print that was waited for.
            assert!(read > 100, "{read} states and permits in {}", graph.bag().display());
            storms[first..].iter_mut().for_each(|storm| storm.judged = record.judge(storm.span_s));
        }
        println!("{}", report::table(&storms));
        let failures = report::failures(&storms);
        assert!(failures.is_empty(), "{}", failures.join("\n"));
    });
}

/// Whether no other kind was asked for.
fn chosen(kind: &Kind) -> bool {
    std::env::var(ONLY).map_or(true, |only| only.split(',').any(|name| name == kind.name))
}

/// This test again, where nobody else is on the network; in the network there is, where namespaces are not to be had.
fn inside_a_namespace() -> Command {
    let test = std::env::current_exe().unwrap();
    let namespace = Command::new("unshare").args(["-rn", "sh", "-c", NAMESPACE, "sh", "true"]).status();
    let mut command = if namespace.is_ok_and(|status| status.success()) {
        let mut command = Command::new("unshare");
        command.args(["-rn", "sh", "-c", NAMESPACE, "sh"]).arg(test);
        command
    } else {
        println!("no network namespace: unicast alone, in a domain of its own");
        let mut command = Command::new(test);
        command.env("ROS_DOMAIN_ID", system_tests::own_domain(0));
        command
    };
    command.args([TEST, "--exact", "--nocapture"]).env(OBSERVER, "1");
    command
}
