//! The node processes, started from the folder of the test's own executable.

use rustix::process::{Pid, Signal, kill_process};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Nodes that are looked at.
pub(crate) const NODES: [&str; 7] = [
    "thermistor",
    "filament_encoder",
    "imu",
    "camera",
    "state_estimator",
    "mpc_controller",
    "safety_supervisor",
];

/// Running nodes; none outlives the test.
pub(crate) struct Fleet(Vec<(&'static str, Child)>);

impl Fleet {
    /// Starts all nodes on the host's clock.
    pub(crate) fn start() -> Self {
        Self(NODES.map(|node| (node, start(node))).into_iter().collect())
    }

    /// Processes that are already started.
    pub(crate) fn of(processes: Vec<(&'static str, Child)>) -> Self {
        Self(processes)
    }

    /// SIGTERM to one node.
    pub(crate) fn ask_to_end(&self, name: &str) {
        for (_, child) in self.0.iter().filter(|(node, _)| *node == name) {
            kill_process(Pid::from_child(child), Signal::TERM).unwrap();
        }
    }

    /// SIGTERM to all: each ends in order within 2 s.
    pub(crate) fn end(&mut self) {
        for (_, child) in &self.0 {
            _ = kill_process(Pid::from_child(child), Signal::TERM);
        }
        let begin = Instant::now();
        for (name, child) in &mut self.0 {
            let status = loop {
                if let Some(status) = child.try_wait().unwrap() {
                    break status;
                }
                assert!(begin.elapsed() < Duration::from_secs(3), "{name} does not end");
                std::thread::sleep(Duration::from_millis(5));
            };
            assert_eq!(status.code(), Some(0), "{name}");
        }
    }
}

impl Drop for Fleet {
    fn drop(&mut self) {
        for (_, child) in &mut self.0 {
            _ = child.kill();
            _ = child.wait();
        }
    }
}

/// The simulated printer with a file that it never gets to print: it is cold.
pub(crate) fn start_printer() -> Child {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let files = [
        "printer_sim.param.yaml",
        "plants/ender3.yaml",
        "printers/ender3_motion.yaml",
        "quality.yaml",
        "materials/pla.yaml",
    ];
    let gcode = root.join("tests/data/gcode/quirks_handmade.gcode");
    let wish = format!("run.gcode:=\"{}\"", gcode.display());
    command("printer_sim", &files.map(str::to_owned)).args(["-p", &wish]).spawn().unwrap()
}

fn start(node: &str) -> Child {
    start_with(node, &[])
}

/// A node with its shipped parameters, and further arguments after them.
pub(crate) fn start_with(node: &str, arguments: &[&str]) -> Child {
    let mut files = vec![format!("{node}.param.yaml")];
    let more: &[&str] = match node {
        "state_estimator" | "mpc_controller" => &["printers/ender3.yaml", "materials/pla.yaml"],
        "defect_classifier" => &["quality.yaml", "printers/ender3.yaml", "materials/pla.yaml"],
        "advance_predictor" => &["advance/physics.yaml"],
        _ => &[],
    };
    files.extend(more.iter().map(|file| (*file).to_owned()));
    command(node, &files).args(arguments).spawn().unwrap()
}

fn command(node: &str, files: &[String]) -> Command {
    let deps = std::env::current_exe().unwrap();
    let program = deps.parent().and_then(Path::parent).unwrap().join(node);
    assert!(program.is_file(), "{} is missing: build it first (cargo build -p {node})", program.display());
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config");
    let config = std::fs::canonicalize(config).unwrap();
    let arguments = files.iter().flat_map(|file| ["--params-file".into(), config.join(file)] as [PathBuf; 2]);
    let mut command = Command::new(program);
    // Files of networks are named from here.
    command.current_dir(config.parent().unwrap());
    command.arg("--ros-args").args(arguments).env_remove("RUST_LOG").stdout(Stdio::null());
    command
}
