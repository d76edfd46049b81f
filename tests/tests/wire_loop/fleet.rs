//! The processes of a wire machine, started from the folder of the test's own executable.

use rustix::process::{Pid, Signal, kill_process};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Running nodes; none outlives the test.
pub(crate) struct Fleet(Vec<(&'static str, Child)>);

impl Fleet {
    /// Starts nodes with overrides `name:=value` of their parameters, besides their files.
    pub(crate) fn start(nodes: &[(&'static str, &[&str])]) -> Self {
        Self(nodes.iter().map(|(node, overrides)| (*node, start(node, overrides))).collect())
    }

    /// kill -9 of one node.
    pub(crate) fn kill(&mut self, name: &str) {
        for (_, child) in self.0.iter_mut().filter(|(node, _)| *node == name) {
            child.kill().unwrap();
            child.wait().unwrap();
        }
        self.0.retain(|(node, _)| *node != name);
    }

    /// SIGTERM to all: each ends in order within 2 s, with a margin for a machine under load.
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
                assert!(begin.elapsed() < Duration::from_secs(5), "{name} does not end");
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

/// Parameter files as `fdm wire up` and `fdm up` give them.
fn files(node: &str) -> &'static [&'static str] {
    match node {
        "safety_supervisor" => &["safety_supervisor.param.yaml", "wire/safety_supervisor.param.yaml"],
        "mpc_controller" => &["wire/mpc_controller.param.yaml", "wire/controller.yaml", "wire/process.yaml"],
        "defect_classifier" => {
            &["defect_classifier.param.yaml", "quality.yaml", "printers/ender3.yaml", "materials/pla.yaml"]
        }
        "printer_sim" => &["wire/printer_sim.param.yaml", "plants/wire.yaml", "wire/process.yaml"],
        other => unreachable!("{other} has no part in these tests"),
    }
}

fn start(node: &str, overrides: &[&str]) -> Child {
    let deps = std::env::current_exe().unwrap();
    let program = deps.parent().and_then(Path::parent).unwrap().join(node);
    assert!(program.is_file(), "{} is missing: build it first (cargo build -p {node})", program.display());
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let config = root.join("config");
    let arguments =
        files(node).iter().flat_map(|file| ["--params-file".into(), config.join(file)] as [PathBuf; 2]);
    let mut command = Command::new(program);
    // Files that parameters name are relative to the repository.
    command
        .current_dir(root)
        .arg("--ros-args")
        .args(arguments)
        .args(overrides.iter().flat_map(|assignment| ["-p", assignment]))
        .env_remove("RUST_LOG")
        .env(runtime::STOP_WITH_PARENT, std::process::id().to_string())
        .stdout(Stdio::null());
    command.spawn().unwrap()
}
