//! The node as a process whose folder is not there. Real time passes: DDS has no other.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Only ends a test that hangs.
const PATIENCE: Duration = Duration::from_secs(30);

/// Killed in the end, or when it says nothing for so long that nothing more is to be expected.
struct Node(Child);

impl Drop for Node {
    fn drop(&mut self) {
        _ = self.0.kill();
        _ = self.0.wait();
    }
}

/// In the log that everybody sees, long before the source counts as lost.
#[test]
fn a_folder_that_is_not_there_is_warned_of_by_name() {
    let missing = std::env::temp_dir().join(format!("camera_not_there_{}", std::process::id()));
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/camera.param.yaml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_camera"));
    command.arg("--ros-args").arg("--params-file").arg(config).env_remove("RUST_LOG");
    // Ports of domains up to 101 lie below the ephemeral ones.
    command.env("ROS_DOMAIN_ID", (20 + std::process::id() % 80).to_string());
    let path = format!("folder.path:=\"{}\"", missing.display());
    for wish in ["driver:=folder", &path, "camera.lost_after_s:=600.0"] {
        command.args(["-p", wish]);
    }
    let mut node = Node(command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap());
    let lines = BufReader::new(node.0.stderr.take().unwrap()).lines();
    let (sender, said) = std::sync::mpsc::channel();
    let named = missing.display().to_string();
    std::thread::spawn(move || {
        for line in lines.map_while(Result::ok).filter(|line| line.contains(&named)) {
            _ = sender.send(line);
        }
    });
    let line = said.recv_timeout(PATIENCE).unwrap();
    assert!(line.contains("WARN") && line.contains("No such file or directory"), "{line}");
}
