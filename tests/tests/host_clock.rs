//! The graph on the host's clock, as beside a real printer, here one with a sensor in its nozzle: nobody tells `/clock`, and
//! the loop corrects all the same.
#![allow(clippy::unwrap_used, reason = "helpers of tests: a failure is the test's failure")]

use rustix::process::{Pid, Signal, kill_process};
use rustix::time::{ClockId, clock_gettime};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

/// Seconds since this machine was started, which all nodes of a host count.
#[allow(clippy::cast_precision_loss, reason = "seconds")]
fn host_s() -> f64 {
    clock_gettime(ClockId::Monotonic).tv_sec as f64
}

#[test]
fn a_graph_without_simulated_time_corrects_by_the_hosts_clock() {
    let root = std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap();
    let fdm = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    let folder = std::env::temp_dir().join(format!("fdm_host_clock_{}", std::process::id()));
    let bag = folder.join("bag");
    let begun_s = host_s();
    let mut graph = Command::new(&fdm)
        .current_dir(root)
        .args(["up", "--host-clock", "--warm", "--with", "nozzle", "--gcode"])
        .args(["tests/data/gcode/prusa_cube_pla_marlin_relE.gcode", "--bag"])
        .arg(&bag)
        .env("ROS_DOMAIN_ID", system_tests::own_domain(0))
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(graph.stderr.take().unwrap()).lines().map_while(Result::ok);
    // A line every ten seconds of the print: at the third it has printed for twenty.
    let third = lines.by_ref().filter(|line| line.contains(" % at ")).nth(2).unwrap();
    kill_process(Pid::from_child(&graph), Signal::INT).unwrap();
    let said: Vec<String> = lines.collect();
    graph.wait().unwrap();
    assert!(third.contains(", act,"), "{third}: corrections are let through\n{said:#?}");

    let output = Command::new(fdm).args(["bag", "info", "--json", "-"]).arg(&bag).output().unwrap();
    let info: Value = serde_json::from_slice(&output.stdout).unwrap();
    let count = |topic: &str| info["topics"][topic]["messages"].as_u64().unwrap_or(0);
    assert_eq!(count("/clock"), 0);
    // Permits come fifty times a second, commands four times and with each temperature.
    assert!(count("/printer/safety/command") > 15 * 50, "{info:#}");
    assert!(count("/printer/control/command") > 15 * 4, "{info:#}");
    // The sensor in the nozzle is read ten times a second, and only the estimator listens.
    assert!(count("/printer/sensors/nozzle/temperature") > 15 * 10, "{info:#}");
    let start_s: f64 = info["note"]["start_clock_s"].as_str().unwrap().parse().unwrap();
    assert!(
        (begun_s - 1.0..=host_s()).contains(&start_s),
        "{start_s}: the bag is of the host's clock\n{info:#}"
    );
    std::fs::remove_dir_all(folder).unwrap();
}
