//! The bridge as a process on the graph, with a stand-in of Marlin behind a pseudo-terminal. Real time passes: DDS and
//! serial lines have no other.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

#[path = "../../nodes/printer_bridge/tests/stand_in/mod.rs"]
mod stand_in;

use fdm_loop_msgs::{DiagnosticArray, DiagnosticStatus, PrintEvent, PrinterState, TemperatureReport};
use runtime::{Args, Node, Subscription, topics};
use rustix::process::{Pid, Signal, kill_process};
use stand_in::StandIn;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Longest wait for anything: only ends a test that hangs.
const PATIENCE: Duration = Duration::from_secs(20);

/// A program of this build.
fn program(name: &str) -> Command {
    let deps = std::env::current_exe().unwrap();
    let program = deps.parent().and_then(Path::parent).unwrap().join(name);
    assert!(program.is_file(), "{} is missing: build it first", program.display());
    let mut command = Command::new(program);
    command.env_remove("RUST_LOG");
    command
}

/// A node with files of parameters below `config`.
fn node(name: &str, files: &[&str]) -> Command {
    let mut command = program(name);
    command.arg("--ros-args");
    for file in files {
        let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config");
        command.arg("--params-file").arg(config.join(file));
    }
    command
}

/// The bridge on a serial line.
fn bridge(line: &Path) -> Command {
    let mut command = node("printer_bridge", &["printer_bridge.param.yaml"]);
    let wishes = [
        format!("serial.path:=\"{}\"", line.display()),
        "serial.retry_min_s:=0.05".into(),
        "marlin.greeting_s:=0.1".into(),
    ];
    for wish in wishes {
        command.args(["-p", &wish]);
    }
    command
}

#[test]
fn simulated_time_writing_and_hosts_to_come_are_refused_with_what_to_do() {
    for (wish, answer) in [
        ("use_sim_time:=true", "leave it out"),
        ("read_only:=false", "set it to true"),
        ("host:=moonraker", "use marlin_serial"),
        ("host:=octoprint", "disconnect OctoPrint"),
    ] {
        let output = bridge(Path::new("/dev/null")).args(["-p", wish]).output().unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{wish}: {told}");
        assert!(told.contains(answer), "{wish}: {told}");
    }
}

#[test]
fn a_printer_on_a_serial_line_is_on_the_graph() {
    if let Some(alone) =
        system_tests::run_in_own_domain("a_printer_on_a_serial_line_is_on_the_graph", 0).unwrap()
    {
        assert!(alone.success(), "it failed in its own domain, see above");
        return;
    }
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    executor.block_on(watch());
}

async fn watch() {
    let path = std::env::temp_dir().join(format!("bridge_pty_{}", std::process::id()));
    let mut peer = Peer::join();
    let mut process = Process(bridge(&path).stdout(Stdio::null()).spawn().unwrap(), path.clone());
    // A device that is not there is an error in the diagnostics, not the end of the node.
    peer.until("error of a missing device", |seen| seen.level == Some(DiagnosticStatus::ERROR)).await;

    let printer = StandIn::start(&path);
    peer.until("name of the firmware", |seen| {
        seen.events.iter().any(|event| event.what == "firmware_found" && event.why.contains(stand_in::NAME))
    })
    .await;
    peer.until("temperatures", |seen| {
        seen.report
            .as_ref()
            .is_some_and(|report| same(report.hotend_degc, 199.87) && same(report.bed_degc, 59.9))
    })
    .await;
    let idle = |state: &PrinterState| {
        state.phase == PrinterState::PHASE_IDLE && same(state.hotend_target_degc, 200.0) && !state.homed
    };
    peer.until("an idle printer", |seen| seen.state.as_ref().is_some_and(idle)).await;
    printer.print_from_card(Some((10, 1000)));
    let prints =
        |state: &PrinterState| state.phase == PrinterState::PHASE_PRINTING && same(state.flow_factor, 1.0);
    peer.until("a print", |seen| seen.state.as_ref().is_some_and(prints)).await;
    peer.until("diagnostics that are well", |seen| seen.level == Some(DiagnosticStatus::OK)).await;

    not_stopped_is_told_as_such().await;
    peer.until("a print that goes on", |seen| seen.state.as_ref().is_some_and(prints)).await;

    printer.say("Error:Thermal Runaway, system stopped! Heater_ID: 0");
    let failed = |state: &PrinterState| state.phase == PrinterState::PHASE_FAILED;
    peer.until("a failed job", |seen| seen.state.as_ref().is_some_and(failed)).await;

    let sent = printer.end();
    assert!(
        sent.iter().all(|line| ["M115", "M155 S1", "M105", "M27", "M114"].contains(&line.as_str())),
        "{sent:?}"
    );
    peer.until("loss", |seen| {
        seen.events.iter().any(|event| event.what == "link_lost" && !event.why.is_empty())
    })
    .await;
    peer.until("error of a lost device", |seen| seen.level == Some(DiagnosticStatus::ERROR)).await;
    process.end();
}

/// The supervisor latches, and the bridge sends nothing: who pressed it has to know that the printer heats on.
async fn not_stopped_is_told_as_such() {
    let latch = std::env::temp_dir().join(format!("bridge_latch_{}.json", std::process::id()));
    let mut supervisor =
        node("safety_supervisor", &["safety_supervisor.param.yaml", "hosts/marlin.param.yaml"]);
    supervisor.args(["-p", &format!("latch_file:=\"{}\"", latch.display())]);
    let mut supervisor = Process(supervisor.stdout(Stdio::null()).spawn().unwrap(), latch);
    for (request, mode, instead) in [
        ("pause", "mode paused", "pause it at the printer"),
        ("estop", "mode estop", "use the printer's own switch"),
    ] {
        let mut pressed = program("fdm");
        pressed.arg(request);
        let pressed = tokio::process::Command::from(pressed).output().await.unwrap();
        let told = String::from_utf8_lossy(&pressed.stderr);
        assert_eq!(pressed.status.code(), Some(2), "{told}");
        assert!(
            told.contains(&format!("the supervisor took it ({mode}")) && told.contains(instead),
            "{told}"
        );
        assert!(told.contains("which says: printing, set to 200 and 60 degC, mains on"), "{told}");
    }
    supervisor.end();
}

fn same(value: f64, expected: f64) -> bool {
    (value - expected).abs() < 1e-9
}

/// The newest of each, and every event.
#[derive(Default)]
struct Seen {
    report: Option<TemperatureReport>,
    state: Option<PrinterState>,
    level: Option<u8>,
    events: Vec<PrintEvent>,
}

struct Peer {
    _node: Node,
    reports: Subscription<TemperatureReport>,
    states: Subscription<PrinterState>,
    events: Subscription<PrintEvent>,
    diagnostics: Subscription<DiagnosticArray>,
    seen: Seen,
}

impl Peer {
    fn join() -> Self {
        let mut node = Node::start_with("peer", Args::default()).unwrap();
        Self {
            reports: node.subscribe(&topics::TEMPERATURE_REPORT).unwrap(),
            states: node.subscribe(&topics::PRINTER_STATE).unwrap(),
            events: node.subscribe(&topics::EVENTS).unwrap(),
            diagnostics: node.subscribe(&topics::DIAGNOSTICS).unwrap(),
            seen: Seen::default(),
            _node: node,
        }
    }

    async fn until(&mut self, what: &str, wished: impl Fn(&Seen) -> bool) {
        let limit = tokio::time::sleep(PATIENCE);
        tokio::pin!(limit);
        while !wished(&self.seen) {
            tokio::select! {
                report = self.reports.recv() => self.seen.report = Some(report.message),
                state = self.states.recv() => self.seen.state = Some(state.message),
                event = self.events.recv() => self.seen.events.push(event.message),
                array = self.diagnostics.recv() => {
                    let own = array.message.status.iter().find(|status| status.name.ends_with("printer_bridge"));
                    self.seen.level = own.map(|status| status.level).or(self.seen.level);
                }
                () = &mut limit => panic!("no {what}: {:?}", self.seen.events),
            }
        }
    }
}

/// A running node and its file; neither outlives the test.
struct Process(Child, PathBuf);

impl Process {
    /// SIGTERM: it ends in order.
    fn end(&mut self) {
        kill_process(Pid::from_child(&self.0), Signal::TERM).unwrap();
        assert_eq!(self.0.wait().unwrap().code(), Some(0));
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        _ = self.0.kill();
        _ = self.0.wait();
        _ = std::fs::remove_file(&self.1);
    }
}
