//! What `fdm install` lays out is found by the rules of ament's index, runs from anywhere as anybody, and takes what
//! `ros2 run` and `launch_ros` pass. No ROS here: the rules are written down below.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

#[path = "idl_conformance/definition.rs"]
#[allow(dead_code, reason = "one of two users of it")]
mod definition;
#[path = "install/first.rs"]
mod first;
#[path = "install/layouts.rs"]
mod layouts;
#[path = "install/package.rs"]
mod package;

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::collections::BTreeSet;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// Programs that are run; the others are stand-ins of a few bytes.
const RUN: [&str; 2] = ["fdm", "thermistor"];
/// launch_ros kills a node that lives on for 5 s after SIGINT; every node promises 2 s.
const END_LIMIT: Duration = Duration::from_secs(2);
/// `nobody`.
const NOBODY: u32 = 65534;

fn root() -> PathBuf {
    std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap()
}

/// Version of the workspace.
fn cargo_version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

/// Executables stand beside the folder of the test's own.
fn binaries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().to_owned()
}

/// A prefix, installed once for all tests of this process.
static PREFIX: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("installed");
    _ = std::fs::remove_dir_all(&folder);
    let (programs, prefix) = (folder.join("programs"), folder.join("prefix"));
    std::fs::create_dir_all(&programs).unwrap();
    for program in cli::up::recipes::NODES.into_iter().chain(["printer_bridge"]) {
        let path = programs.join(program);
        std::fs::write(&path, "#!/bin/false\n").unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    }
    for program in RUN {
        // Without symbols a twentieth is copied.
        let mut strip = Command::new("strip");
        strip.arg("-o").args([programs.join(program), binaries().join(program)]);
        assert!(strip.status().unwrap().success(), "{program}: cargo build --workspace --bins");
    }
    let installed = Command::new("sh")
        .args(["-c", "umask 077; exec \"$0\" install --prefix \"$1\""])
        .args([programs.join("fdm"), prefix.clone()])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(installed.status.success(), "{}", String::from_utf8_lossy(&installed.stderr));
    prefix
});

/// `ament_index_python.get_package_prefix`: the first prefix of the path with a marker of that name.
fn package_prefix(ament_prefix_path: &str, package: &str) -> Option<PathBuf> {
    let marker = Path::new("share/ament_index/resource_index/packages").join(package);
    ament_prefix_path
        .split(':')
        .filter(|prefix| !prefix.is_empty())
        .map(PathBuf::from)
        .find(|prefix| prefix.join(&marker).exists())
}

/// `ros2pkg.api.get_executable_paths`: files below `lib/<package>` that may be run.
fn executables(prefix: &Path, package: &str) -> BTreeSet<String> {
    let entries = std::fs::read_dir(prefix.join("lib").join(package)).unwrap().map(Result::unwrap);
    entries
        .filter(|entry| entry.metadata().unwrap().permissions().mode() & 0o111 != 0)
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect()
}

/// `ros2launch.api.get_share_file_path_from_package`: every file of that name below `share/<package>`; several are an
/// error there.
fn launch_files(folder: &Path, name: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(launch_files(&path, name));
        } else if path.file_name().is_some_and(|file| file == name) {
            found.push(path);
        }
    }
    found
}

#[test]
fn the_index_leads_to_programs_and_launch_files() {
    let prefix = PREFIX.clone();
    for shell in ["sh", "bash"] {
        let script = format!(
            "set -eu; . {0}/share/fdm_loop/local_setup.{shell}; . {0}/share/fdm_loop/local_setup.{shell}; \
             echo $AMENT_PREFIX_PATH; command -v fdm",
            prefix.display()
        );
        let said = Command::new(shell)
            .args(["-c", &script])
            .env("AMENT_PREFIX_PATH", "/nowhere:/opt/ros/jazzy")
            .output()
            .unwrap();
        let text = String::from_utf8(said.stdout).unwrap();
        let (path, fdm) = text.trim().split_once('\n').unwrap();
        // Read twice, put first once.
        assert_eq!(path, format!("{}:/nowhere:/opt/ros/jazzy", prefix.display()));
        assert_eq!(Path::new(fdm), prefix.join("bin/fdm"));
        assert_eq!(package_prefix(path, "fdm_loop"), Some(prefix.clone()));
    }
    let expected: BTreeSet<String> =
        cli::up::recipes::NODES.into_iter().chain(["printer_bridge", "fdm"]).map(str::to_owned).collect();
    assert_eq!(executables(&prefix, "fdm_loop"), expected);
    let share = prefix.join("share/fdm_loop");
    for name in ["sim.launch.py", "monitor.launch.py", "replay.launch.py"] {
        assert_eq!(launch_files(&share, name), [share.join("launch").join(name)], "{name}");
    }
    let package = std::fs::read_to_string(share.join("package.xml")).unwrap();
    assert!(package.contains("<name>fdm_loop</name>"));
}

/// From a folder of somebody else, as somebody else where this test may become one and they may enter.
#[test]
fn the_installed_command_finds_its_own_configuration_from_anywhere() {
    let prefix = PREFIX.clone();
    let elsewhere = prefix.parent().unwrap().join("elsewhere");
    std::fs::create_dir_all(&elsewhere).unwrap();
    let mut command = Command::new(prefix.join("bin/fdm"));
    command
        .current_dir(&elsewhere)
        .env_remove("FDM_CONFIG")
        .args(["up", "--dry-run", "--bag", "/tmp/never_written", "--scenario", "slip09", "--gcode"])
        .arg(prefix.join("share/fdm_loop/gcode/prusa_cube_pla_marlin_relE.gcode"));
    let enters = |folder: &Path| std::fs::metadata(folder).unwrap().permissions().mode() & 0o005 == 0o005;
    if rustix::process::geteuid().is_root() && elsewhere.ancestors().all(enters) {
        command.uid(NOBODY).gid(NOBODY);
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).unwrap();
    for file in ["lib/fdm_loop/safety_supervisor", "share/fdm_loop/config/scenarios/slip09.yaml"] {
        assert!(text.contains(prefix.join(file).to_str().unwrap()), "{file} in {text}");
    }
    let clone = root().join("config");
    assert!(!text.contains(clone.to_str().unwrap()), "{text}");
}

/// What `launch_ros` passes, and an end by SIGINT with code 0.
#[test]
fn an_installed_node_takes_what_ros2_run_passes_and_ends_on_sigint() {
    let prefix = PREFIX.clone();
    let config = prefix.join("share/fdm_loop/config/thermistor.param.yaml");
    let domain = system_tests::own_domain(0);
    let node = Command::new(prefix.join("lib/fdm_loop/thermistor"))
        .current_dir("/")
        .args([
            "--ros-args",
            "--log-level",
            "debug",
            "-r",
            "__node:=hot",
            "-r",
            "__ns:=/left",
            "--params-file",
        ])
        .arg(&config)
        .args(["-p", "hotend.max_c:=512.5"])
        .env("ROS_DOMAIN_ID", &domain)
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let status = Command::new(prefix.join("bin/fdm"))
        .args(["status", "--namespace", "/left", "--listen-s", "1.5", "--json", "-"])
        .env("ROS_DOMAIN_ID", &domain)
        .output()
        .unwrap();
    let seen: Value = serde_json::from_slice(&status.stdout).unwrap();
    let pid = Pid::from_child(&node);
    kill_process(pid, Signal::INT).unwrap();
    let asked = Instant::now();
    let ended = node.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ended.stderr);
    assert!(asked.elapsed() < END_LIMIT, "{:?}", asked.elapsed());
    assert_eq!(ended.status.code(), Some(0), "{said}");
    assert!(seen["nodes"]["/left/hot"]["beats"].as_u64() > Some(0), "{seen}: {said}");
    // The override counts, and what was installed stands in for a file that is not given: all else is there.
    let refused = Command::new(prefix.join("lib/fdm_loop/thermistor"))
        .args(["--ros-args", "-p", "hotend.max_c:=9999.0"])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        refused.status.code() == Some(2) && said.contains("hotend.max_c = 9999 degC: must be in"),
        "{said}"
    );
}

/// A node that joins before the loopback carries multicast finds nobody: each waits for it, also where it is started alone.
#[test]
fn every_unit_comes_behind_the_loopback() {
    let template = root().join("launch_scripts/systemd/fdm_loop@.service");
    let template = std::fs::read_to_string(template).unwrap();
    for key in ["Wants", "After"] {
        let line = format!("{key}=fdm_loop-loopback.service");
        assert!(template.lines().any(|found| found == line), "{line}");
    }
}
