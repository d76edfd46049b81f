//! `fdm wire` and `fdm kinematics`: the figures of both papers, the simulated wire wall, and what is refused.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

#[path = "process_models/budget.rs"]
mod budget;
#[path = "process_models/kinematics.rs"]
mod kinematics;
#[path = "process_models/parts.rs"]
mod parts;
#[path = "process_models/wire.rs"]
mod wire;

use parts::{cone, write_stl};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn root() -> PathBuf {
    std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap()
}

/// Executables stand beside the folder of the test's own.
fn fdm() -> PathBuf {
    let path = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    assert!(path.is_file(), "{} is missing: cargo build --workspace --bins", path.display());
    path
}

fn run(arguments: &[&str]) -> Output {
    Command::new(fdm()).current_dir(root()).args(arguments).output().unwrap()
}

/// Runs with `--json -`: standard output must hold one object and nothing else.
fn json(arguments: &[&str]) -> Value {
    let output = run(&[arguments, &["--json", "-"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Exit code 2 and one line that names value and limit.
fn refused(arguments: &[&str], parts: &[&str]) {
    let output = run(arguments);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    for part in parts {
        assert!(said.contains(part), "{said:?} lacks {part:?}");
    }
}

fn number(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("{name} is no number in {value}"))
}

fn list<'a>(value: &'a Value, name: &str) -> &'a [Value] {
    value[name].as_array().unwrap_or_else(|| panic!("{name} is no list in {value}"))
}

fn scratch(name: &str) -> String {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join(name).to_str().unwrap().to_owned()
}

/// Who reads ten lines and goes has not found a mistake.
#[test]
fn a_closed_pipe_is_no_complaint() {
    let mut child = Command::new(fdm())
        .current_dir(root())
        .args(["kinematics", "error"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
}

#[test]
fn an_option_without_effect_is_refused_with_what_it_needs() {
    for (arguments, option, wanted) in [
        (&["wire", "correct", "--mode", "head"][..], "--mode", "--height"),
        (&["wire", "correct", "--gain", "1"], "--gain", "--height"),
        (&["kinematics", "error", "--angle", "1"], "--angle", "--height"),
        (&["kinematics", "error", "--radius", "60"], "--radius", "--height"),
        (&["kinematics", "error", "--seed", "3"], "--seed", "--monte-carlo"),
        (&["kinematics", "map", "--unit", "25.4"], "--unit", "--stl"),
        (&["kinematics", "map", "--microsteps", "8"], "--microsteps", "--stl"),
        (&["kinematics", "budget", "--unit", "25.4"], "--unit", "--stl"),
    ] {
        refused(arguments, &[&format!("{option}: has an effect only together with {wanted}")]);
    }
}

#[test]
fn pictures_are_drawn_of_the_wall_and_the_hemisphere() {
    let wall = scratch("wall.svg");
    json(&["wire", "sim", "--layers", "2", "--seeds", "1..2", "--picture", &wall]);
    let hemisphere = scratch("hemisphere.svg");
    let map = json(&["kinematics", "map", "--picture", &hemisphere]);
    assert_eq!(list(&map, "spots").len(), 31 * 9);
    for file in [wall, hemisphere] {
        assert!(std::fs::read_to_string(file).unwrap().starts_with("<svg"));
    }
}

#[test]
fn bad_input_names_the_value_and_the_limit() {
    refused(&["wire", "plan", "--diameter", "-3"], &["--diameter -3 mm", "[0.1, 20] mm"]);
    refused(&["wire", "plan", "--film", "5"], &["--film 5 mm", "[0, 1.5] mm"]);
    for angle in ["0", "200", "NaN"] {
        let angle_deg = format!("--angle {angle} deg: must be in (0, 90] deg");
        refused(&["wire", "plan", "--film", "0.1", "--angle", angle], &[&angle_deg]);
    }
    refused(&["wire", "plan", "--power", "0"], &["--power 0 W", "> 0"]);
    refused(&["wire", "plan", "--material", "tin"], &["'tin' is unknown", "aluminium, copper"]);
    refused(&["wire", "correct", "--height", "NaN"], &["--height NaN mm", "[0, 7.16] mm"]);
    refused(&["wire", "sim", "--gain", "9"], &["--gain 9", "[0, 4]"]);
    refused(&["wire", "sim", "--noise", "-1"], &["--noise -1 mm", "[0, 10] mm"]);
    refused(&["wire", "sim", "--seeds", "5..1"], &["--seeds 5..1", "A <= B"]);
    refused(&["wire", "sim", "--picture", "wall.bmp"], &["wall.bmp", ".svg or .html"]);
    refused(&["kinematics", "error", "--height", "80"], &["--height 80 mm", "[0, 75] mm"]);
    refused(
        &["kinematics", "error", "--height", "10", "--angle", "1000"],
        &["--angle 1000 deg", "[0, 7.2] deg"],
    );
    refused(&["kinematics", "error", "--height", "10", "--angle", "-1"], &["--angle -1 deg", "> 0"]);
    refused(&["kinematics", "error", "--height", "10", "--radius", "900"], &["m: must be"]);
    refused(&["kinematics", "error", "--machine", "g7"], &["'g7' is unknown", "g1"]);
    refused(&["kinematics", "synthesize", "--target", "-0.1"], &["--target -0.1 mm", "> 0"]);
    let open = write_stl("open.stl", &cone(12, false));
    refused(&["kinematics", "map", "--stl", &open], &["open edges = 12", "must be 0"]);
    refused(&["kinematics", "map", "--stl", "README.md"], &["README.md: not an STL file"]);
    refused(&["kinematics", "map", "--stl", "/dev/zero"], &["/dev/zero: not a file"]);
    refused(&["kinematics", "map", "--stl", "nowhere.stl"], &["nowhere.stl"]);
}
