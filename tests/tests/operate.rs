//! A person at a running graph: every word that `fdm` has for the supervisor, over DDS, to the end of the print.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::io::{BufRead, BufReader, Lines};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Longest wait until what was asked for shows.
const PATIENCE: Duration = Duration::from_secs(60);

fn root() -> PathBuf {
    std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap()
}

fn command(words: &[&str]) -> Command {
    let fdm = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    let mut command = Command::new(fdm);
    let domain = system_tests::own_domain(0);
    command.current_dir(root()).args(words).env("ROS_DOMAIN_ID", domain).env_remove("RUST_LOG");
    command
}

/// A graph that prints, what it says, and where it writes.
struct Graph {
    child: Child,
    lines: Lines<BufReader<ChildStderr>>,
    folder: PathBuf,
}

impl Graph {
    fn start() -> Self {
        let folder = std::env::temp_dir().join(format!("fdm_operate_{}", std::process::id()));
        let file = "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode";
        // A former print with this bag was paused when it ended, or latched: this one begins all the same.
        let logs = folder.join("bag_logs");
        std::fs::create_dir_all(&logs).unwrap();
        let former = r#"{"version":1,"mode":"observe","paused":"stale_printer"}"#;
        std::fs::write(logs.join("latch.standing.json"), former).unwrap();
        let mut child =
            command(&["up", "--gcode", file, "--warm", "--speed", "2", "--allow-fault-injection", "--bag"])
                .arg(folder.join("bag"))
                .arg("--json")
                .arg(folder.join("print.json"))
                .stdin(Stdio::null())
                .stderr(Stdio::piped())
                .spawn();
        let stderr = child.as_mut().unwrap().stderr.take().unwrap();
        Self { child: child.unwrap(), lines: BufReader::new(stderr).lines(), folder }
    }

    /// Reads on until a line says so; the graph's end is a failure.
    fn until(&mut self, what: &str) -> String {
        let mut said = String::new();
        for line in self.lines.by_ref().map_while(Result::ok) {
            if line.contains(what) {
                return line;
            }
            said.push_str(&line);
            said.push('\n');
        }
        panic!("'{what}' was not said, but:\n{said}");
    }

    /// Code, and the figures.
    fn end(mut self) -> (Option<i32>, Value) {
        while self.lines.next().is_some_and(|line| line.is_ok()) {}
        let code = self.child.wait().unwrap().code();
        let figures = std::fs::read(self.folder.join("print.json")).unwrap();
        std::fs::remove_dir_all(&self.folder).unwrap();
        (code, serde_json::from_slice(&figures).unwrap())
    }
}

/// What a failed test leaves behind would go on printing.
impl Drop for Graph {
    fn drop(&mut self) {
        if matches!(self.child.try_wait(), Ok(None)) {
            _ = kill_process(Pid::from_child(&self.child), Signal::INT);
            _ = self.child.wait();
        }
    }
}

fn said(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// A request that is granted, and what is answered.
fn granted(words: &[&str]) -> String {
    let output = command(words).output().unwrap();
    assert!(output.status.success(), "{words:?}: {}", said(&output));
    said(&output)
}

/// What `fdm status` tells once `holds`; the last that it told where that does not come in time.
fn status_where(what: &str, holds: impl Fn(&Value) -> bool) -> Value {
    let begin = Instant::now();
    loop {
        let output = command(&["status", "--listen-s", "1.2", "--json", "-"]).output().unwrap();
        let told: Value = serde_json::from_slice(&output.stdout).unwrap_or_default();
        if holds(&told) {
            return told;
        }
        assert!(begin.elapsed() < PATIENCE, "not {what}: {told}\n{}", said(&output));
    }
}

#[test]
fn a_person_is_heard_and_a_print_that_a_person_stops_has_not_failed() {
    let mut graph = Graph::start();
    graph.until(", act, ");
    // Ctrl-Z: the printer would go on without its loop, so it is not heeded.
    kill_process(Pid::from_child(&graph.child), Signal::TSTP).unwrap();
    graph.until("cannot be suspended");
    // On a busy machine the mode may be degraded just then: it is set beneath that.
    let set = granted(&["mode", "observe"]);
    assert!(set.contains("mode observe") || set.contains("observe is set"), "{set}");
    graph.until(", observe, ");
    status_where("observe", |told| told["mode"] == "observe" && told["phase"] == "printing");
    // Long after the end of this test, so that the print goes on as it is.
    let slip = ["inject", "extruder", "slip", "--size", "0.09", "--start-s", "3000", "--duration-s", "20"];
    let injected = granted(&slip);
    assert!(injected.contains("injected: extruder slip, size 0.09 (no unit), from 30"), "{injected}");
    assert!(injected.contains("s of the simulation on, lasts 20 s"), "{injected}");
    graph.until("fault injected: extruder slip");
    // S7: a sensor of the simulated printer falls silent, which the supervisor tells and gets over.
    let cut = ["inject", "encoder", "off", "--duration-s", "30"];
    assert!(granted(&cut).contains("injected: encoder off, from"));
    let silent = |told: &Value| told["cause"].as_str().is_some_and(|cause| cause.starts_with("S7"));
    status_where("degraded", |told| told["mode"] == "degraded" && silent(told));
    status_where("observe again", |told| told["mode"] == "observe");
    let paused = granted(&["pause"]);
    assert!(paused.contains("mode paused"), "{paused}");
    assert!(paused.contains("; the printer confirms: paused"), "{paused}");
    graph.until("supervisor at");
    let held = status_where("paused", |told| told["mode"] == "paused" && told["phase"] == "paused");
    assert!(held["cause"].as_str().unwrap().starts_with("P13") && held["latched"] == false, "{held}");
    let answer = granted(&["resume"]);
    assert!(answer.contains("mode paused until") || answer.contains("mode observe"), "{answer}");
    status_where("resumed", |told| told["mode"] == "observe" && told["phase"] == "printing");
    let refused = command(&["acknowledge"]).output().unwrap();
    assert_eq!(refused.status.code(), Some(2), "nothing is latched: {}", said(&refused));
    assert!(said(&refused).contains("nothing to acknowledge"), "{}", said(&refused));
    let refused = command(&["approve"]).output().unwrap();
    assert!(
        refused.status.code() == Some(2) && said(&refused).contains("not in advise"),
        "{}",
        said(&refused)
    );
    let stopped = granted(&["stop"]);
    assert!(stopped.contains("safety/stop: mode safe_off"), "{stopped}");
    assert!(stopped.contains("the printer confirms: heaters off, job given up"), "{stopped}");
    let told = graph.until("safe_off: P13");
    assert!(told.contains("start the next print") && !told.contains("fdm acknowledge"), "{told}");
    let (code, figures) = graph.end();
    assert_eq!(code, Some(0), "{figures}");
    assert_eq!(figures["ended"], "stopped");
    assert!(figures["cause"].as_str().unwrap().starts_with("P13"), "{figures}");
    let modes = figures["modes"].to_string();
    assert!(modes.contains("paused") && modes.contains("safe_off"), "{modes}");
}

/// What no printer takes is told at once, and where no printer takes faults that is told with what to do.
#[test]
fn a_fault_that_nobody_takes_is_refused() {
    for (size, told) in
        [("2", "size = 2 (no unit): must be in [0, 0.95]"), ("0.1", "fdm up --allow-fault-injection")]
    {
        let refused = command(&["inject", "extruder", "slip", "--size", size, "--namespace", "/nobody"])
            .output()
            .unwrap();
        assert_eq!(refused.status.code(), Some(2), "{}", said(&refused));
        assert!(refused.stdout.is_empty() && said(&refused).contains(told), "{}", said(&refused));
    }
}

/// A process that was stopped and continued has lost its middleware: who asked is told to ask again, no crash.
#[test]
fn a_command_that_was_stopped_says_so_and_ends() {
    let mut child = command(&["status", "--listen-s", "60"]).stderr(Stdio::piped()).spawn().unwrap();
    let pid = Pid::from_child(&child);
    // From here on it can tell that it goes on after a stop.
    let caught = || {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
        let signals = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap().trim();
        u64::from_str_radix(signals, 16).unwrap() >> (Signal::CONT.as_raw() - 1) & 1 == 1
    };
    while !caught() {
        std::thread::yield_now();
    }
    kill_process(pid, Signal::STOP).unwrap();
    kill_process(pid, Signal::CONT).unwrap();
    let mut said = String::new();
    std::io::Read::read_to_string(&mut child.stderr.take().unwrap(), &mut said).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(1), "{said}");
    assert!(said.contains("stopped and continued") && said.contains("start the command again"), "{said}");
}
