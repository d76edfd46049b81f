//! The catalogue of faults: each ID is shown by something that exists, and what runs in virtual time keeps its limit.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

#[path = "faults/asked.rs"]
mod asked;

use cli::faults::catalogue::Catalogue;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use system_tests::copy_folder;

/// Every requirement, by its letter and last number.
const REQUIRED: [(&str, u32); 7] = [("S", 11), ("C", 14), ("K", 8), ("P", 13), ("T", 5), ("L", 5), ("X", 2)];
/// How many may wait for a part that is not built.
const UNBUILT_MAX: usize = 5;

fn root() -> PathBuf {
    std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap()
}

fn catalogue() -> Catalogue {
    Catalogue::read(&root().join("config/faults.yaml")).unwrap()
}

/// Text of every file of tests in the workspace.
fn sources_of_tests() -> String {
    let mut text = String::new();
    let mut folders = vec![root().join("tests"), root().join("nodes")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && !path.ends_with("data") {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs" || extension == "sh") {
                text += &std::fs::read_to_string(path).unwrap();
            }
        }
    }
    text
}

/// Whether there is a function of this name that the test harness runs: marked as a test, and not left out.
fn is_run(sources: &str, test: &str) -> bool {
    let mut lines = Vec::new();
    for line in sources.lines().map(str::trim) {
        let name = line.trim_start_matches("async ").strip_prefix("fn ");
        if name.and_then(|name| name.strip_prefix(test)).is_some_and(|rest| rest.starts_with('(')) {
            let marks = |mark: &str| lines.iter().any(|line: &&str| line.starts_with(mark));
            return (marks("#[test]") || marks("#[tokio::test")) && !marks("#[ignore") && !marks("#[cfg");
        }
        // What stands above an item: attributes and comments, until something else does.
        if line.starts_with("#[") || line.starts_with("//") {
            lines.push(line);
        } else {
            lines.clear();
        }
    }
    false
}

#[test]
fn a_test_that_is_left_out_or_none_shows_nothing() {
    let sources = |marks: &str| format!("fn other() {{}}\n{marks}\n    fn it_holds() {{}}\n");
    for marks in ["#[test]", "#[test]\n/// S1.", "#[tokio::test(flavor = \"current_thread\")]\nasync "] {
        assert!(is_run(&sources(marks).replace("async \n    fn", "    async fn"), "it_holds"), "{marks}");
    }
    for marks in
        ["", "// #[test]", "#[test]\n#[ignore]", "#[test]\nfn before() {}", "#[test]\n#[cfg(windows)]"]
    {
        assert!(!is_run(&sources(marks), "it_holds"), "{marks}");
    }
    assert!(!is_run(&sources("#[test]"), "it_hold") && !is_run(&sources("#[test]"), "holds"));
}

#[test]
fn every_requirement_has_a_trial_or_a_test_that_exists_and_few_wait() {
    let (catalogue, sources) = (catalogue(), sources_of_tests());
    let mut missing = Vec::new();
    for (letter, last) in REQUIRED {
        for number in 1..=last {
            let id = format!("{letter}{number}");
            match catalogue.faults.iter().find(|fault| fault.id == id) {
                None => missing.push(format!("{id}: not in config/faults.yaml")),
                Some(fault) => {
                    if let Some(test) = fault.test.as_ref().filter(|test| !is_run(&sources, test)) {
                        missing.push(format!("{id}: there is no test {test} that is run"));
                    }
                }
            }
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
    let reasons: Vec<&String> = catalogue.faults.iter().filter_map(|fault| fault.waiting.as_ref()).collect();
    let unbuilt = reasons.iter().filter(|reason| reason.starts_with("not built: ")).count();
    assert!(unbuilt <= UNBUILT_MAX, "{unbuilt} wait for a part");
    assert_eq!(reasons.len(), unbuilt, "what is built has a test: {reasons:?}");
}

/// One seed that nothing was chosen on; twenty of each ID run in `test.sh --long`.
#[test]
fn what_needs_no_camera_keeps_its_limit_in_virtual_time() {
    let path = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    let only =
        "S1,S2,S3,S4,S5,S6,S7,S10,C1,C2,C4,C6,C7,C8,C13,K1,K2,K3,K4,K5,K6,K7,K8,P1,P2,P3,P4,P5,P6,P7,P12,P13";
    let output = Command::new(path)
        .current_dir(root())
        .args(["faults", "--only", only, "--no-camera", "--seeds", "71..71", "--json", "-"])
        .output()
        .unwrap();
    let figures: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(output.status.success(), "{}\n{figures:#}", String::from_utf8_lossy(&output.stderr));
    let faults = figures["faults"].as_array().unwrap();
    assert_eq!(faults.len(), only.split(',').count());
    for fault in faults {
        for field in ["level", "reaction_p50_s", "reaction_max_s", "limit_s", "action"] {
            assert!(fault.get(field).is_some(), "{field} is missing in {fault}");
        }
        assert!(fault["runs"].as_u64() > Some(0), "{fault:#}");
        assert_eq!(fault["within_limit"], true, "{fault:#}");
        for figures in std::iter::once(fault).chain(fault["trials"].as_array().unwrap()) {
            let limited = ["limit", "limit_s", "limit_layers"].iter().any(|limit| !figures[*limit].is_null());
            assert_eq!(limited, figures["limit_source"].is_string(), "{figures:#}");
        }
    }
}

/// A limit of filament is one of millimetres and seconds, for people and programs; a reader sees whose it is.
#[test]
fn a_limit_is_told_with_its_units_and_its_source() {
    let path = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    let figures_of = |to: &str| {
        let arguments = ["faults", "--only", "P6,P12", "--seeds", "71..71", "--json", to];
        Command::new(&path).current_dir(root()).args(arguments).output().unwrap()
    };
    let figures: Value = serde_json::from_slice(&figures_of("-").stdout).unwrap();
    let slip = &figures["faults"][0];
    for figures in [slip, &slip["trials"][0]] {
        let limit = ["limit_mm", "limit_s"].map(|field| figures[field].clone());
        assert_eq!(limit, [Value::from(7.0), Value::from(1.0)], "{figures:#}");
    }
    assert_eq!(slip["trials"][0]["limit_source"], "catalogue");
    // all have the same limit: the source told of all is that of the one that came closest to it
    let of_trials: Vec<&Value> =
        slip["trials"].as_array().unwrap().iter().map(|trial| &trial["limit_source"]).collect();
    assert!(of_trials.contains(&&slip["limit_source"]), "{slip:#}");
    let sources: Vec<&Value> = figures["faults"][1]["trials"]
        .as_array()
        .unwrap()
        .iter()
        .map(|trial| &trial["limit_source"])
        .collect();
    assert!(
        sources.contains(&&Value::from("stricter")) && sources.contains(&&Value::from("catalogue")),
        "{sources:?}"
    );
    let table = String::from_utf8(figures_of("/dev/null").stdout).unwrap();
    assert!(table.contains(" 7 mm + 1 s  yes"), "{table}");
    assert!(table.contains("  30 s  yes") && table.contains("  0.5 s  yes"), "{table}");
}

/// A limit that cannot be kept is told as missed, with exit code 1.
#[test]
fn a_missed_limit_is_told() {
    let folder = std::env::temp_dir().join(format!("fdm_faults_{}", std::process::id()));
    let text = std::fs::read_to_string(root().join("config/faults.yaml")).unwrap();
    copy_folder(&root().join("config"), &folder).unwrap();
    let gcode = root().join("tests/data/gcode");
    // Three readings at 10 Hz have to be seen: none follows within 10 ms.
    let impossible = text
        .replace("../tests/data/gcode", gcode.to_str().unwrap())
        .replace("limit_s: 0.5,", "limit_s: 0.01,");
    std::fs::write(folder.join("faults.yaml"), impossible).unwrap();
    let path = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    let output = Command::new(path)
        .args(["faults", "--only", "S1", "--seeds", "72..72", "--config"])
        .arg(&folder)
        .output()
        .unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("limits missed: S1"), "{told}");
    let table = String::from_utf8_lossy(&output.stdout);
    assert!(table.contains("missed: S1 hot end open, seed 72: 0."), "late, not absent: {table}");
}

/// At least five simulated hours of sound prints with every nuisance, in which nothing trips: all files and materials, files
/// that change set-points, fan and filament. Those with the camera run in `test.sh --long`.
#[test]
fn nothing_trips_in_five_hours_of_sound_prints() {
    let path = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    // One trial of a fraction of a second stands for the rest of the catalogue.
    let arguments =
        ["faults", "--only", "P13", "--seeds", "1..1", "--no-camera", "--hours", "5", "--json", "-"];
    let output = Command::new(path).current_dir(root()).args(arguments).output().unwrap();
    let figures: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(output.status.success(), "{}\n{figures:#}", String::from_utf8_lossy(&output.stderr));
    assert!(figures["hours"].as_f64() >= Some(5.0), "{figures:#}");
    assert_eq!((&figures["false_trips"], &figures["camera_hours"]), (&Value::from(0), &Value::from(0.0)));
    assert!(figures["file_pauses"].as_u64() >= Some(3), "a file asks for three pauses: {figures:#}");
}

/// Where an ID that is not tried here is shown is told of each, never in a circle.
#[test]
fn an_id_that_is_not_tried_says_why_or_where() {
    let path = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    let told = |arguments: &[&str]| {
        let output = Command::new(&path).current_dir(root()).arg("faults").args(arguments).output().unwrap();
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{arguments:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    for level in [&["--only", "C3, S11"][..], &["--process", "--only", "C3, S11"]] {
        let told = told(level);
        assert!(
            told.contains("C3 waits (not built: ") && told.contains("S11 has the test a_wrong_unit"),
            "{told}"
        );
    }
    assert!(told(&["--process", "--only", "S1"]).contains("S1 is, without --process"));
    assert!(told(&["--process", "--hours", "1"]).contains("--hours"));
}

/// What needs processes is no empty table of virtual time.
#[test]
fn what_only_processes_can_show_is_told() {
    let path = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    let output = Command::new(path).current_dir(root()).args(["faults", "--only", "L1"]).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{told}");
    assert!(told.contains("--process"), "{told}");
}

/// What only the camera sees is no empty table without it, alone or beside what runs.
#[test]
fn what_only_the_camera_can_show_is_told() {
    let path = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    for (only, blind) in [("S8,P8", "nothing of S8, P8:"), ("S1,S8", "nothing of S8:")] {
        let arguments = ["faults", "--only", only, "--no-camera", "--seeds", "1..1"];
        let output = Command::new(&path).current_dir(root()).args(arguments).output().unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), output.stdout.len()), (Some(2), 0), "{told}");
        assert!(told.contains(blind), "{told}");
    }
}
