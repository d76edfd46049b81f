//! No node outlives the `fdm up` that started it, not even one that is killed: nobody would start it again.
#![allow(clippy::unwrap_used, reason = "helpers of tests: a failure is the test's failure")]

use rustix::process::{Pid, test_kill_process};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longest time until the last node has ended: every node promises 2 s.
const LIMIT: Duration = Duration::from_secs(4);

#[test]
fn nodes_end_with_the_command_that_started_them() {
    let root = std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap();
    let fdm = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    let folder = std::env::temp_dir().join(format!("fdm_orphans_{}", std::process::id()));
    let mut child = Command::new(fdm)
        .current_dir(root)
        .args(["up", "--gcode", "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode", "--bag"])
        .arg(folder.join("bag"))
        .env("ROS_DOMAIN_ID", system_tests::own_domain(0))
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // "10 node processes: bag_recorder 123, ..."
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    let list = lines.find(|line| line.contains("node processes:")).unwrap();
    let pids: Vec<Pid> = list
        .split([' ', ','])
        .filter_map(|word| word.parse().ok())
        .filter(|pid| *pid > 100)
        .filter_map(Pid::from_raw)
        .collect();
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(pids.len(), 10, "{list}");
    let killed = Instant::now();
    while pids.iter().any(|pid| test_kill_process(*pid).is_ok()) {
        let left: Vec<_> = pids.iter().filter(|pid| test_kill_process(**pid).is_ok()).collect();
        assert!(killed.elapsed() < LIMIT, "{left:?} of {list} live on");
        std::thread::yield_now();
    }
    std::fs::remove_dir_all(folder).unwrap();
}
