//! No node outlives the `fdm up` that started it, not even one that is killed: nobody would start it again; and what was
//! stopped ends in order.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

#[path = "orphans/late.rs"]
mod late;

use rustix::process::{Pid, Signal, kill_process_group, test_kill_process};
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Longest time until the last node has ended: every node promises 2 s.
const LIMIT: Duration = Duration::from_secs(4);

/// Longest time from Ctrl-C until `fdm` has ended: it promises 2 s, ends by force after 1.4 s what hangs, and needs 0.5 s where
/// nothing does. The second beyond is for a machine on which even the end of a process waits for its turn.
const ENDS: Duration = Duration::from_secs(3);

/// `fdm up` in a folder of its own; its process group is its own too.
fn up(folder: &Path) -> Child {
    up_by(&fdm(), folder)
}

/// The same by a certain `fdm`.
fn up_by(fdm: &Path, folder: &Path) -> Child {
    let root = std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap();
    Command::new(fdm)
        .current_dir(root)
        .args(["up", "--gcode", "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode", "--bag"])
        .arg(folder.join("bag"))
        .env("ROS_DOMAIN_ID", system_tests::own_domain(0))
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .stderr(Stdio::piped())
        .process_group(0)
        .spawn()
        .unwrap()
}

fn fdm() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm")
}

fn folder(test: &str) -> PathBuf {
    std::env::temp_dir().join(format!("fdm_orphans_{test}_{}", std::process::id()))
}

/// Reads on until it tells of the print's progress a second time, ten seconds after the first.
fn prints(lines: &mut impl Iterator<Item = String>) {
    let (mut said, mut told) = (Vec::new(), 0);
    while told < 2 {
        let Some(line) = lines.next() else { panic!("it ended before that: {said:#?}") };
        told += usize::from(line.contains(" % at "));
        said.push(line);
    }
}

/// One after another: each brings up a whole graph.
static ALONE: Mutex<()> = Mutex::new(());

/// The whole graph stopped and continued, as `kill -STOP` of its group and `fg` do: the middleware does not outlive that, so
/// the print is lost; `fdm` says so, ends all others in order, and the bag is closed.
#[test]
fn a_group_that_was_stopped_ends_in_order_when_it_goes_on() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = folder("stopped");
    let mut child = up(&folder);
    let group = Pid::from_child(&child);
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    // "0.0 % at 0 s: ...", and again ten seconds later: it prints, and is recorded.
    prints(&mut lines);
    kill_process_group(group, Signal::STOP).unwrap();
    std::thread::sleep(Duration::from_secs(2));
    kill_process_group(group, Signal::CONT).unwrap();
    let said: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(1), "{said:#?}");
    // The middleware may have the last word.
    assert!(said.iter().any(|line| line.starts_with("fdm: ") && line.contains("was lost")), "{said:#?}");
    assert!(closed(&folder) > 100, "{said:#?}");
    std::fs::remove_dir_all(folder).unwrap();
}

/// The nodes go to active in their order: who records, who guards, ..., the printer. Ctrl-C in a terminal reaches `fdm` and
/// every node at once, in the midst of a print: code 0 in time, no node is taken for one that died, none is left, the bag is
/// closed.
#[test]
fn ctrl_c_at_the_whole_group_ends_it_in_order() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = folder("interrupted");
    let mut child = up(&folder);
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    let nodes = nodes(&mut lines);
    prints(&mut lines);
    let asked = Instant::now();
    kill_process_group(Pid::from_child(&child), Signal::INT).unwrap();
    let said: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{said:#?}");
    let ended = asked.elapsed();
    println!("ended {ended:?} after Ctrl-C");
    assert!(ended < ENDS, "{ended:?}: {said:#?}");
    assert!(!said.iter().any(|line| line.contains("runs again") || line.contains("ended (")), "{said:#?}");
    let left: Vec<_> = nodes.iter().filter(|(_, pid)| test_kill_process(*pid).is_ok()).collect();
    assert!(left.is_empty(), "{left:?} live on");
    assert!(closed(&folder) > 100, "{said:#?}");
    let names: Vec<&str> = nodes.iter().map(|(name, _)| name.as_str()).collect();
    assert!(names.starts_with(&["bag_recorder", "safety_supervisor"]) && names.ends_with(&["printer_sim"]));
    let active: Vec<String> = names.iter().map(|name| activated(&folder, name)).collect();
    assert!(active.is_sorted(), "{names:?} at {active:#?}");
    std::fs::remove_dir_all(folder).unwrap();
}

/// Ctrl-C while the nodes still come up: the same, whatever has been recorded by then.
#[test]
fn ctrl_c_at_a_group_that_comes_up_ends_it_in_order() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = folder("early");
    let mut child = up(&folder);
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    let pids = pids(&mut lines);
    let asked = Instant::now();
    kill_process_group(Pid::from_child(&child), Signal::INT).unwrap();
    let said: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{said:#?}");
    assert!(asked.elapsed() < ENDS, "{:?}: {said:#?}", asked.elapsed());
    let left: Vec<_> = pids.iter().filter(|pid| test_kill_process(**pid).is_ok()).collect();
    assert!(left.is_empty(), "{left:?} live on");
    std::fs::remove_dir_all(folder).unwrap();
}

/// The processes of the nodes.
fn pids(lines: &mut impl Iterator<Item = String>) -> Vec<Pid> {
    nodes(lines).into_iter().map(|(_, pid)| pid).collect()
}

/// The nodes and their processes, as `fdm` names them: "10 node processes: bag_recorder 123, ...".
fn nodes(lines: &mut impl Iterator<Item = String>) -> Vec<(String, Pid)> {
    let list = lines.find(|line| line.contains("node processes:")).unwrap();
    let (_, list) = list.split_once(": ").unwrap();
    let node = |entry: &str| {
        let (name, pid) = entry.rsplit_once(' ').unwrap();
        (name.to_owned(), Pid::from_raw(pid.parse().unwrap()).unwrap())
    };
    let nodes: Vec<_> = list.split(", ").map(node).collect();
    assert_eq!(nodes.len(), 10, "{list}");
    nodes
}

/// When a node went to active, as its log has it: "2026-11-24T12:26:02.168278Z  INFO ...: activating -> active".
fn activated(folder: &Path, node: &str) -> String {
    let log = std::fs::read_to_string(folder.join(format!("bag_logs/{node}.log"))).unwrap();
    let line = log
        .lines()
        .find(|line| line.contains("activating -> active"))
        .unwrap_or_else(|| panic!("{node}: {log}"));
    line.split_whitespace().next().unwrap().to_owned()
}

/// Messages of a bag whose every file is closed.
fn closed(folder: &Path) -> u64 {
    let info =
        Command::new(fdm()).args(["bag", "info", "--json", "-"]).arg(folder.join("bag")).output().unwrap();
    let told: serde_json::Value = serde_json::from_slice(&info.stdout).unwrap();
    let states: Vec<_> = told["files"].as_array().unwrap().iter().map(|file| &file["state"]).collect();
    assert!(!states.is_empty() && states.iter().all(|state| *state == "closed"), "{told}");
    told["messages"].as_u64().unwrap()
}

#[test]
fn nodes_end_with_the_command_that_started_them() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = folder("killed");
    let mut child = up(&folder);
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    let pids = pids(&mut lines);
    child.kill().unwrap();
    child.wait().unwrap();
    let killed = Instant::now();
    while pids.iter().any(|pid| test_kill_process(*pid).is_ok()) {
        let left: Vec<_> = pids.iter().filter(|pid| test_kill_process(**pid).is_ok()).collect();
        assert!(killed.elapsed() < LIMIT, "{left:?} live on");
        std::thread::yield_now();
    }
    std::fs::remove_dir_all(folder).unwrap();
}
