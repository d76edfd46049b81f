//! A node that never comes up and never ends by itself: who waits is told for whom, and Ctrl-C ends all in time even so.

use super::{ALONE, ENDS, fdm, folder, up_by};
use rustix::process::{Pid, Signal, kill_process};
use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::PoisonError;
use std::time::Instant;

/// Neither joins a graph nor heeds a demand to end; it ends with the test's folder.
const STUBBORN: &str = "#!/bin/sh\ntrap '' INT TERM HUP\nwhile [ -e \"$0\" ]; do sleep 0.1; done\n";

/// A folder of programs with a stubborn thermistor in it; `fdm` in it.
fn programs(folder: &Path) -> PathBuf {
    let ours = fdm();
    std::fs::create_dir_all(folder).unwrap();
    for name in cli::up::recipes::NODES.into_iter().chain(["fdm"]) {
        let (from, to) = (ours.with_file_name(name), folder.join(name));
        if name == "thermistor" {
            std::fs::write(&to, STUBBORN).unwrap();
            std::fs::set_permissions(&to, std::fs::Permissions::from_mode(0o755)).unwrap();
        } else {
            std::fs::hard_link(from, to).unwrap();
        }
    }
    folder.join("fdm")
}

#[test]
fn who_waits_for_a_node_is_told_so_and_ctrl_c_ends_even_that() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    // Beside the programs: a hard link leads to no other disk.
    let beside = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("late_{}", std::process::id()));
    let folder = folder("late");
    let mut child = up_by(&programs(&beside), &folder);
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    let waiting = lines.by_ref().find(|line| line.starts_with("waiting for ")).unwrap();
    // All others are configured; nobody is activated before all are.
    assert!(waiting.contains("thermistor (not configured)"), "{waiting}");
    assert!(waiting.contains("bag_recorder (not active), safety_supervisor (not active)"), "{waiting}");
    let asked = Instant::now();
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    let said: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{said:#?}");
    assert!(asked.elapsed() < ENDS, "after {:?}: {said:#?}", asked.elapsed());
    let killed: Vec<_> = said.iter().filter(|line| line.ends_with("and was killed")).collect();
    assert_eq!(killed, ["thermistor did not end in 1.4 s and was killed"]);
    std::fs::remove_dir_all(beside).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
}
