//! `ros2 launch` starts what `fdm up` starts. Without ROS: the launch file is evaluated against stand-ins of the launch
//! modules (`tests/readers/launch.py`), and both lists of processes are compared down to every merged parameter.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

use runtime::Args;
use runtime::params::{NodePath, Parameters};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn root() -> PathBuf {
    std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap()
}

/// Executables stand beside the folder of the test's own.
fn binaries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().to_owned()
}

const GCODE: &str = "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode";

fn launched(arguments: &[&str]) -> Output {
    let bin = format!("bin:={}", binaries().display());
    Command::new("python3")
        .current_dir(root())
        .args(["tests/readers/launch.py", "launch_scripts/sim.launch.py", &bin])
        .args(arguments)
        .output()
        .unwrap()
}

fn processes(output: &Output) -> Vec<Value> {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Node, program, namespace and every parameter after merging, as text.
fn meaning(process: &Value) -> [String; 4] {
    let text = |name: &str| process[name].as_str().unwrap().to_owned();
    let words = process["arguments"].as_array().unwrap().iter().map(|word| word.as_str().unwrap().to_owned());
    let args = Args::parse(words).unwrap();
    let (node, namespace) = (text("node"), args.namespace.unwrap());
    let path = NodePath { qualified: format!("{namespace}/{node}"), base: node.clone() };
    // Relative paths are those of the folder that both were started in.
    let files: Vec<PathBuf> = args.params_files.iter().map(|file| root().join(file)).collect();
    let parameters = Parameters::read(&files, &args.parameters, &path).unwrap();
    [node, text("program"), namespace, parameters.text()]
}

#[test]
fn the_launch_file_starts_what_fdm_up_starts() {
    let folder = std::env::temp_dir().join(format!("fdm_launch_{}", std::process::id()));
    let bag = folder.join("bag");
    let bag = bag.to_str().unwrap();
    let up = Command::new(binaries().join("fdm"))
        .current_dir(root())
        .args(["up", "--gcode", GCODE, "--bag", bag, "--scenario", "slip09", "--speed", "4", "--layers", "3"])
        .args(["--control", "encoder", "--host", "serial", "--seed", "7", "--warm", "--dry-run"])
        .output()
        .unwrap();
    let ours: Vec<Value> = processes(&up)[0].as_array().unwrap().clone();
    let theirs = processes(&launched(&[
        &format!("gcode:={GCODE}"),
        &format!("bag:={bag}"),
        "scenario:=slip09",
        "speed:=4.0",
        "layers:=3",
        "control:=encoder",
        "host:=serial",
        "seed:=7",
        "warm:=true",
    ]));
    // The one parameter that only `fdm up` has: the text of the whole configuration, for the bag.
    let config_file = format!("{bag}_logs/config.txt");
    assert_eq!(ours.len(), theirs.len());
    for (ours, theirs) in ours.iter().zip(&theirs) {
        assert_eq!(meaning(ours).map(|part| part.replace(&config_file, "")), meaning(theirs));
        let printer = theirs["node"] == "printer_sim";
        assert_eq!((theirs["respawn"] == true, theirs["ends_all"] == true), (!printer, printer));
    }
    _ = std::fs::remove_dir_all(folder);
}

/// Without multicast on `lo` twelve processes see each other: ten nodes and `fdm` as ever, an eleventh where it is asked
/// for, and no more.
#[test]
fn the_predictor_is_started_where_it_is_asked_for_alone() {
    let folder = std::env::temp_dir().join(format!("fdm_launch_advance_{}", std::process::id()));
    let bag = folder.join("bag");
    let nodes = |advance: &[&str]| {
        let up = Command::new(binaries().join("fdm"))
            .current_dir(root())
            .args(["up", "--gcode", GCODE, "--bag", bag.to_str().unwrap(), "--dry-run"])
            .args(advance)
            .output()
            .unwrap();
        processes(&up)[0].as_array().unwrap().iter().map(meaning).collect::<Vec<_>>()
    };
    let source = |nodes: &[[String; 4]], name: &str| {
        let controller = nodes.iter().find(|[node, ..]| node == "mpc_controller").unwrap();
        controller[3].contains(&format!("advance.source: \"{name}\""))
    };
    let usual = nodes(&[]);
    assert_eq!(usual.len(), 10);
    assert!(usual.iter().all(|[node, ..]| node != "advance_predictor") && source(&usual, "material"));
    let predicted = nodes(&["--advance", "predicted"]);
    assert_eq!(predicted.len(), 11);
    assert_eq!(predicted.iter().filter(|[node, ..]| node == "advance_predictor").count(), 1);
    assert!(source(&predicted, "predicted"));
}

#[test]
fn what_is_wrong_is_told_before_anything_starts() {
    for (arguments, said) in [
        (&[][..], "'gcode' was not provided"),
        (&["gcode:=none.gcode"], "gcode:=none.gcode: no such file"),
        (&[&format!("gcode:={GCODE}"), "control:=perhaps"], "control:=perhaps is not one of"),
        (&[&format!("gcode:={GCODE}"), "bag:=config"], "the folder is there and not empty"),
        (&[&format!("gcode:={GCODE}"), "bin:=/tmp"], "build all nodes with `cargo build --release`"),
    ] {
        let output = launched(arguments);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && text.contains(said), "{arguments:?}: {text}");
    }
}
