//! The rules of `nodes/README.md` that a compiler does not hold: who may depend on whom, and that no test is left out.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

#[path = "structure/units.rs"]
mod units;
#[path = "structure/version.rs"]
mod version;

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, Package};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Nodes with a brain.
const NODES: [&str; 12] = [
    "advance_predictor",
    "bag_recorder",
    "camera",
    "defect_classifier",
    "filament_encoder",
    "imu",
    "mpc_controller",
    "printer_bridge",
    "printer_sim",
    "safety_supervisor",
    "state_estimator",
    "thermistor",
];

fn root() -> PathBuf {
    std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap()
}

fn metadata() -> Metadata {
    MetadataCommand::new().manifest_path(root().join("Cargo.toml")).no_deps().exec().unwrap()
}

fn package<'a>(metadata: &'a Metadata, name: &str) -> &'a Package {
    metadata.packages.iter().find(|package| package.name.as_str() == name).unwrap()
}

/// Dependencies of the built code; with `optional` those that a feature brings in as well.
fn dependencies(package: &Package, optional: bool) -> BTreeSet<&str> {
    package
        .dependencies
        .iter()
        .filter(|dependency| dependency.kind == DependencyKind::Normal && (optional || !dependency.optional))
        .map(|dependency| dependency.name.as_str())
        .collect()
}

#[test]
fn models_knows_arithmetic_alone() {
    let metadata = metadata();
    let allowed = BTreeSet::from(["nalgebra", "serde", "thiserror"]);
    let found = dependencies(package(&metadata, "models"), true);
    assert!(found.is_subset(&allowed), "{found:?}");
}

#[test]
fn a_brain_uses_models_and_its_one_solver() {
    let metadata = metadata();
    for node in NODES {
        let mut allowed = BTreeSet::from(["models", "serde", "thiserror"]);
        allowed.extend(match node {
            "mpc_controller" => &["clarabel", "nalgebra"][..],
            // The checksum of its files.
            "advance_predictor" => &["nalgebra", "serde_json", "sha2"],
            "state_estimator" => &["nalgebra"],
            // A simulated camera says JPEG.
            "printer_sim" => &["jpeg-encoder", "nalgebra", "rand", "rand_distr"],
            // OpenCV reads pictures that are cut off without a word; the checksum of its files.
            "defect_classifier" => &["nalgebra", "opencv", "serde_json", "sha2", "zune-jpeg"],
            "bag_recorder" => &["serde_json"],
            _ => &[],
        });
        let found = dependencies(package(&metadata, node), false);
        assert!(found.is_subset(&allowed), "{node}: {found:?} beyond {allowed:?}");
    }
}

#[test]
fn no_node_uses_another_node() {
    let metadata = metadata();
    for node in NODES {
        let found = dependencies(package(&metadata, node), true);
        for other in NODES {
            assert!(!found.contains(other), "{node} depends on {other}");
        }
    }
}

#[test]
fn the_ros_client_and_the_solver_stand_in_one_crate_each() {
    let metadata = metadata();
    let users = |dependency: &str| -> Vec<&str> {
        let uses = |package: &&Package| dependencies(package, true).contains(dependency);
        let mut users: Vec<_> =
            metadata.packages.iter().filter(uses).map(|package| package.name.as_str()).collect();
        users.sort_unstable();
        users
    };
    assert_eq!(users("ros2-client"), ["runtime"]);
    assert_eq!(users("rustdds"), ["runtime"]);
    assert_eq!(users("clarabel"), ["mpc_controller"]);
    // A picture enters the graph in the one and is judged in the other.
    assert_eq!(users("opencv"), ["camera", "defect_classifier"]);
}

/// Rust files under a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
    found
}

/// Files of a brain: everything in `src` but the shell and the tests.
fn brain_files(node: &str) -> Vec<PathBuf> {
    // The last ones are the recorder's: its work is files and a thread that writes them.
    const SHELL: [&str; 11] =
        ["node", "convert", "main", "load", "writer", "file", "folder", "recovery", "walk", "whole", "tests"];
    let source = root().join("nodes").join(node).join("src");
    let shell = |path: &PathBuf| {
        let inside = path.strip_prefix(&source).unwrap().with_extension("");
        inside.components().any(|part| {
            let name = part.as_os_str().to_string_lossy();
            SHELL.contains(&name.as_ref()) || name.ends_with("_tests") || name.starts_with("tests_")
        })
    };
    let files: Vec<_> = sources(&source).into_iter().filter(|path| !shell(path)).collect();
    assert!(files.len() >= 3, "{node}: only {files:?} are looked at");
    files
}

#[test]
fn brains_and_models_have_no_clock_thread_file_or_log() {
    const FORBIDDEN: [&str; 6] =
        ["Instant::now", "SystemTime::now", "std::thread", "std::fs", "tracing::", "tokio::"];
    for node in NODES.into_iter().chain(["models"]) {
        for path in brain_files(node) {
            let text = std::fs::read_to_string(&path).unwrap();
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            for word in FORBIDDEN {
                assert!(!code.contains(word), "{} uses {word}", path.display());
            }
        }
    }
}

#[test]
fn the_supervisor_sees_commands_params_units_and_job_phases_alone() {
    for path in brain_files("safety_supervisor") {
        let text = std::fs::read_to_string(&path).unwrap();
        for (start, _) in text.match_indices("models::") {
            let module: String =
                text[start + 8..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            let allowed = ["command", "params", "units", "status"];
            assert!(allowed.contains(&module.as_str()), "{}: models::{module}", path.display());
        }
    }
}

/// The README's commands are typed as they stand.
/// A program that panics ends at once: what unwinds half of a node may leave the other half at work.
#[test]
fn programs_end_where_they_panic() {
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let (_, release) = manifest.split_once("\n[profile.release]\n").unwrap();
    let profile = release.split("\n[").next().unwrap();
    assert!(profile.lines().any(|line| line == "panic = \"abort\""), "{profile}");
}

#[test]
fn scripts_can_be_run() {
    use std::os::unix::fs::PermissionsExt;
    let scripts = ["demo.sh", "test.sh", "debian/build.sh"].map(|script| format!("launch_scripts/{script}"));
    for script in scripts.iter().map(String::as_str).chain([".ci/run", "tests/fuzz/run.sh"]) {
        let mode = std::fs::metadata(root().join(script)).unwrap().permissions().mode();
        assert_eq!(mode & 0o111, 0o111, "{script} has mode {mode:o}");
    }
}

/// A file without a target would look like a test and never run.
#[test]
fn every_file_in_tests_is_a_target() {
    let metadata = metadata();
    let targets: BTreeSet<PathBuf> = package(&metadata, "system_tests")
        .targets
        .iter()
        .map(|target| std::fs::canonicalize(&target.src_path).unwrap())
        .collect();
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")).unwrap() {
        let path = std::fs::canonicalize(entry.unwrap().path()).unwrap();
        if path.extension().is_some_and(|extension| extension == "rs") {
            assert!(targets.contains(&path), "{} is no [[test]] of tests/Cargo.toml", path.display());
        }
    }
}
