//! What is named as an input but is no plain file: refused, never waited for.

use super::{fdm, gcode, root};
use rustix::fs::{CWD, FileType, Mode, mknodat};
use std::path::PathBuf;
use std::process::{Command, Output};

/// A folder with a pipe that nobody writes to, under the names that commands look for.
struct Pipes(PathBuf);

impl Pipes {
    fn new() -> Self {
        let folder = std::env::temp_dir().join(format!("fdm_pipes_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(folder.join("bag")).unwrap();
        for name in ["pipe.yaml", "bag/bag_0.mcap", "bag/counts.json"] {
            mknodat(CWD, folder.join(name), FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).display().to_string()
    }
}

impl Drop for Pipes {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

/// Who waits for a pipe waits for ever: such a command is ended, with the code 124.
fn run(arguments: &[&str]) -> Output {
    let fdm = fdm().display().to_string();
    Command::new("timeout").args(["300", &fdm]).args(arguments).current_dir(root()).output().unwrap()
}

fn refusal(arguments: &[&str]) -> String {
    let output = run(arguments);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
    assert_eq!(text.trim_end().lines().count(), 1, "{arguments:?}: {text}");
    text
}

#[test]
fn no_command_reads_a_pipe_a_device_or_a_folder_for_a_file() {
    let pipes = Pipes::new();
    let (pipe, out) = (pipes.path("pipe.yaml"), pipes.path("out"));
    let file = gcode("prusa_cube_pla_marlin_relE.gcode");
    let inputs = [(pipe.as_str(), "a pipe"), ("/dev/null", "a device")];
    for (input, kind) in inputs {
        let commands: [&[&str]; 12] = [
            &["gcode", input],
            &["sim", input],
            &["up", "--gcode", input],
            &["classify", input],
            &["classify", "--manifest", input],
            &["report", input, "--out", &out],
            &["bag", "info", input],
            &["play", input],
            &["replay", input],
            &["identify", input],
            &["kinematics", "map", "--stl", input],
            &["advance", "train", "--measured", input, "--out", &out],
        ];
        for arguments in commands {
            let told = refusal(arguments);
            assert!(told.contains(&format!("{input}: not a file but {kind}")), "{arguments:?}: {told}");
        }
    }
    let told = refusal(&["sim", &file, "--scenario", &pipe]);
    assert!(told.contains(&format!("{pipe}: not a file but a pipe")), "{told}");
    for arguments in [["gcode", "config"], ["sim", "config"], ["classify", "config"]] {
        let told = refusal(&arguments);
        assert!(told.contains("config: not a file but a folder"), "{arguments:?}: {told}");
    }
}

/// The pipe stands where a file of the bag should.
#[test]
fn a_pipe_in_a_bag_is_not_waited_for() {
    let pipes = Pipes::new();
    let (bag, out) = (pipes.path("bag"), pipes.path("out.html"));
    for arguments in [&["report", bag.as_str(), "--out", &out][..], &["bag", "info", &bag]] {
        let told = refusal(arguments);
        assert!(told.contains("bag_0.mcap: not a file but a pipe"), "{arguments:?}: {told}");
    }
    let recovered = run(&["recover", &bag]);
    let told = String::from_utf8_lossy(&recovered.stderr).into_owned();
    assert_eq!(recovered.status.code(), Some(1), "{told}");
    assert!(told.contains("not a file but a pipe"), "{told}");
}
