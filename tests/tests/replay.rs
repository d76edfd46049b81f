//! `fdm sim --bag` and `fdm replay`: what was recorded is said again to the last bit, and a change tells what it changes.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

#[path = "replay/damage.rs"]
mod damage;

fn root() -> PathBuf {
    std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap()
}

fn fdm(arguments: &[&str]) -> Output {
    let program = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    assert!(program.is_file(), "{} is missing: cargo build --workspace --bins", program.display());
    Command::new(program).current_dir(root()).args(arguments).output().unwrap()
}

fn json(arguments: &[&str]) -> Value {
    let output = fdm(&[arguments, &["--json", "-"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A print of one layer that runs out of filament in the middle, with a sensor in the nozzle, recorded in virtual time.
fn recorded(name: &str) -> String {
    recorded_with(name, &["--scenario", "run_out", "--advance", "predicted", "--with", "nozzle"])
}

/// A print of one layer, recorded in virtual time.
fn recorded_with(name: &str, options: &[&str]) -> String {
    let bag = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    _ = std::fs::remove_dir_all(&bag);
    let bag = bag.display().to_string();
    let gcode = "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode";
    let output = fdm(&[&["sim", gcode, "--layers", "1", "--bag", &bag], options].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    bag
}

fn of<'a>(figures: &'a Value, topic: &str) -> &'a Value {
    figures["outputs"].as_array().unwrap().iter().find(|output| output["topic"] == topic).unwrap()
}

fn count(output: &Value, name: &str) -> u64 {
    output[name].as_u64().unwrap()
}

/// Each topic has so many messages at least, and says every one of them again.
fn said_again(figures: &Value, outputs: &[(&str, u64)]) {
    for (topic, least) in outputs {
        let output = of(figures, topic);
        let [before, after, identical] = ["before", "after", "identical"].map(|name| count(output, name));
        assert!(before >= *least && before == after && after == identical, "{output}");
    }
}

/// Same inputs, same build: every estimate, command, permit, decision and prediction, bit by bit; twice. Another
/// parameter: what it would have changed, in its brain and in those behind it, and nowhere else.
#[test]
fn a_replay_says_again_what_was_recorded_and_what_a_change_would_change() {
    let bag = recorded("replayed");
    let first = json(&["replay", &bag, "--check"]);
    assert_eq!((&first["identical"], &first["parameters"]), (&true.into(), &"bag".into()), "{first}");
    let outputs = [
        ("estimate/state", 2000),
        ("control/command", 2000),
        ("safety/command", 5000),
        ("control/schedule", 10),
        ("safety/schedule", 10),
        ("advance/prediction", 100),
        ("events", 1),
    ];
    said_again(&first, &outputs);
    assert_eq!(json(&["replay", &bag]), first, "a second time");

    // A print that is no experiment teaches nothing: the bag is refused, with what it lacks.
    let refused = fdm(&["identify", &bag]);
    let why = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!((refused.status.code(), refused.stdout.len()), (Some(2), 0), "{why}");
    assert!(why.contains("duty: heater off at the start for") && why.contains("identify.gcode"), "{why}");

    let changed = json(&["replay", &bag, "--set", "mpc_controller.trims.feed_gain=0.06"]);
    assert_eq!((&changed["baseline"], &changed["identical"]), (&"replayed".into(), &false.into()));
    let estimates = of(&changed, "estimate/state");
    assert_eq!(count(estimates, "identical"), count(estimates, "before"), "estimates are ahead of control");
    for topic in ["control/command", "safety/command"] {
        let output = of(&changed, topic);
        let field = &output["fields"]["flow_factor"];
        let [rms, max] = ["rms", "max"].map(|name| field[name].as_f64().unwrap());
        assert!(0.0 < rms && rms < max && max < 0.25, "{topic}: {field}");
        assert!(
            output["first_difference"]["stamp_s"].as_f64().unwrap() > 60.0,
            "no road is laid before: {output}"
        );
    }
}

/// With the camera: the pictures of the bag are judged anew, and found to show the same, bit by bit.
#[test]
fn a_replay_judges_the_same_pictures_as_before() {
    let bag = recorded_with("judged", &["--camera"]);
    let figures = json(&["replay", &bag, "--camera", "--check"]);
    assert_eq!(figures["identical"], true, "{figures}");
    said_again(&figures, &[("vision/defects", 100), ("vision/bead_width", 10), ("quality/layer", 1)]);
}

/// The printer says that the job has ended before nobody hears it any more: the page knows, and so do the brains of a replay.
/// It knows the host and what was not fitted, too.
#[test]
fn a_print_in_virtual_time_is_recorded_to_its_end() {
    for (scenario, phase, verdict) in
        [("nominal", "done", "Printed to its end"), ("heater_dead", "failed", "Stopped by the supervisor")]
    {
        let bag = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("ended_{phase}"));
        _ = std::fs::remove_dir_all(&bag);
        let bag = bag.display().to_string();
        let gcode = "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode";
        let printer = ["--host", "serial", "--without", "tachometer,encoder", "--with", "nozzle"];
        let print = ["sim", gcode, "--layers", "1", "--scenario", scenario, "--bag", &bag];
        let print = json(&[&print[..], &printer].concat());
        assert_eq!(print["ended"], phase, "{print}");
        let out = format!("{bag}.html");
        assert!(fdm(&["report", &bag, "--out", &out]).status.success());
        let page = std::fs::read_to_string(&out).unwrap();
        let at_the_end = format!("<dt>Phase at the end</dt><dd>{phase}");
        assert!(page.contains(&at_the_end) && page.contains(verdict), "{scenario}");
        for told in [
            "host serial",
            "<dt>Sensors</dt><dd>without tachometer, encoder<wbr><small>with nozzle<wbr></small>",
        ] {
            assert!(page.contains(told), "{scenario}: no {told}");
        }
        assert_eq!(json(&["replay", &bag, "--check"])["identical"], true, "{scenario}");
    }
}

/// SIGKILL at random moments under 2 kHz IMU and 30 frames of 300 kB a second, half of them among splits and compactions:
/// no acknowledged message is lost, a loss of power would cost 1 s at most, `rosbags` counts every bag as we do.
/// `FDM_KILLS` sets how many: 50 in the long run.
#[test]
fn no_kill_costs_an_acknowledged_message() {
    let kills = std::env::var("FDM_KILLS").unwrap_or_else(|_| "4".to_owned());
    let figures = json(&["bench", "recorder", "--kills", &kills]);
    let figure = |name: &str| {
        let all = figures["benchmarks"].as_array().unwrap();
        let found = all.iter().find(|benchmark| benchmark["name"].as_str().unwrap().contains(name));
        found.unwrap_or_else(|| panic!("{name}: {figures}"))["ours"].as_f64().unwrap()
    };
    assert!(figure("messages acknowledged") > 500.0, "{figures}");
    let bad = ["acknowledged messages lost", "bags that rosbags counts otherwise"].map(figure);
    assert!(bad.iter().sum::<f64>() < 0.5, "{figures}");
    assert!(figure("lost with the power") <= 1.0, "{figures}");
}

/// What is recorded is what is asked for; who asks for a topic that there is not is told of those that there are.
#[test]
fn the_recorder_is_started_as_asked() {
    let asked =
        ["record", "--bag", "x y", "--topics", "sensors/imu/batch,/clock", "--snapshot-s", "5", "--paused"];
    let output = fdm(&[&asked[..], &["--use-sim-time=false", "--dry-run"]].concat());
    assert!(output.status.success(), "{output:?}");
    let line = String::from_utf8(output.stdout).unwrap();
    for part in [
        "bag_dir:=\"x y\"",
        "topics:=[\"sensors/imu/batch\",\"/clock\"]",
        "snapshot_s:=5.0",
        "start_paused:=true",
        "use_sim_time:=false",
    ] {
        assert!(line.contains(part), "{part}: {line}");
    }
    for option in ["--topics", "--leave-out"] {
        let refused = fdm(&["record", "--bag", "x y", option, "/clock,sensors/nonsense"]);
        let said = String::from_utf8(refused.stderr).unwrap();
        assert_eq!((refused.status.code(), said.lines().count()), (Some(2), 1), "{said}");
        assert!(
            said.contains(&format!("{option} sensors/nonsense: no topic of this system; there are ")),
            "{said}"
        );
        assert!(said.contains(", sensors/imu/batch, "), "{said}");
    }
    assert!(!PathBuf::from("x y").exists());
    let refused = fdm(&["record", "--namespace", "left"]);
    let said = String::from_utf8(refused.stderr).unwrap();
    assert!(refused.status.code() == Some(2) && said.contains("begins with no /: write /left"), "{said}");
}

/// Figures take no recording's place, whatever command has them.
#[test]
fn no_figures_replace_a_recording() {
    let (bag, other) = (recorded("figures"), recorded("figures_other"));
    let (recording, metadata) = (format!("{bag}/figures_0.mcap"), format!("{bag}/metadata.yaml"));
    let before = std::fs::read(&recording).unwrap();
    let commands: [&[&str]; 6] = [
        &["bag", "info", &bag, "--json", &recording],
        &["recover", &bag, "--json", &recording],
        &["play", &bag, "--json", &recording],
        &["replay", &bag, "--json", &metadata],
        &["sim", "tests/data/gcode/straight_line.gcode", "--json", &recording],
        &["report", &other, "--out", &recording],
    ];
    for command in commands {
        let output = fdm(command);
        let line = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), line.lines().count()), (Some(2), 1), "{command:?}: {line}");
        assert!(line.ends_with("choose another file\n"), "{line}");
    }
    assert_eq!(std::fs::read(&recording).unwrap(), before);
    assert_eq!(json(&["bag", "info", &bag])["remarks"], serde_json::json!([]));
}

/// A name, a range or a bag that is none ends with code 2 and one line that says which.
#[test]
fn what_cannot_be_replayed_is_refused_in_one_line() {
    let bag = recorded("refused");
    for (set, said) in [
        ("mpc_controller.trims.feed_gian=0.06", "unknown field `feed_gian`"),
        ("mpc_controller.period_s=-1", "period_s = -1 s: must be in [0.05, 1]"),
        ("thermistor.tau=1", "no brain 'thermistor' is replayed; there are state_estimator"),
        ("mpc_controller", "must be node.parameter=value"),
        ("defect_classifier.width.fresh_s=1", "the bag holds nothing of sensors/camera/image_raw/compressed"),
    ] {
        let output = fdm(&["replay", &bag, "--set", set]);
        let line = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), line.lines().count()), (Some(2), 1), "{line}");
        assert!(line.starts_with(&format!("fdm: --set {}", set.split('=').next().unwrap())), "{line}");
        assert!(line.contains(said), "{line}");
    }
    let output = fdm(&["replay", "tests/data/gcode"]);
    assert_eq!(output.status.code(), Some(2));
}
