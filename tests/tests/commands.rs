//! The command `fdm` as a program that others script against: field names, figures, exit codes.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

#[path = "commands/inputs.rs"]
mod inputs;
#[path = "commands/mistakes.rs"]
mod mistakes;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use system_tests::copy_folder;

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

/// What is always told of a file.
const SURVEY: [&str; 9] =
    ["layers", "moves", "arcs", "filament_mm", "print_time_s", "tools", "dialect", "warnings", "errors"];

fn gcode(name: &str) -> String {
    format!("tests/data/gcode/{name}")
}

fn number(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("{name} is no number in {value}"))
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().unwrap().keys().map(String::as_str).collect()
}

/// Beside the recorder of `fdm up`, under the clock of the same printer.
#[test]
fn a_recorder_of_its_own_has_a_name_and_the_printers_clock() {
    let said = |more: &[&str]| {
        let output = run(&[&["record", "--dry-run"], more].concat());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let (usual, left) = (said(&[]), said(&["--namespace", "/left", "--name", "witness"]));
    assert!(
        usual.contains("-r __node:=fdm_record -r __ns:=/printer ") && !usual.contains("/clock"),
        "{usual}"
    );
    assert!(
        left.contains("-r __node:=witness -r __ns:=/left ") && left.contains("-r /clock:=/left/clock"),
        "{left}"
    );
}

/// Contract of `architecture.md`: fields keep their names once published.
#[test]
fn fields_of_one_simulated_run() {
    let run = json(&["sim", &gcode("prusa_cube_pla_marlin_relE.gcode"), "--layers", "1", "--control", "off"]);
    for field in [
        "gcode",
        "material",
        "scenario",
        "control",
        "host",
        "seed",
        "print_time_s",
        "wall_time_s",
        "realtime_factor",
        "quality_mean",
        "width_rms_rel",
        "feed_error_rel",
        "feed_error_after_2s_rel",
        "recovery_time_s",
        "nis_mean",
        "nees_median",
        "detections",
        "false_alarms",
        "max_command",
    ] {
        assert!(keys(&run).contains(&field), "{field} is missing in {:?}", keys(&run));
    }
    assert_eq!(run["material"], "PLA");
    assert_eq!(run["ended"], "done");
}

/// Seeds and layers that no parameter was chosen on.
#[test]
fn the_closed_loop_makes_up_for_a_slip_and_the_open_one_does_not() {
    let file = gcode("prusa_cube_pla_marlin_relE.gcode");
    let comparison = json(&[
        "sim",
        &file,
        "--layers",
        "6",
        "--scenario",
        "slip09",
        "--control",
        "off,encoder,mpc",
        "--seeds",
        "101..102",
    ]);
    let results = comparison["results"].as_array().unwrap();
    assert_eq!(results.len(), 3);
    for group in results {
        let runs = group["runs"].as_array().unwrap();
        assert_eq!(runs.len(), 2);
        for run in runs {
            let settled = number(run, "feed_error_after_2s_rel");
            if group["control"] == "off" {
                // Slip 1 % and 0.2 % of creep are there before the 9 %.
                assert!((0.09..0.12).contains(&settled), "{settled}");
            } else {
                assert!(settled < 0.0025, "{} seed {}: {settled}", group["control"], run["seed"]);
                let width = number(run, "width_rms_rel");
                assert!(width < 0.75 * number(&results[0]["mean"], "width_rms_rel"), "{width}");
            }
            assert!(number(run, "nees_median") < 12.6, "{run}");
            for (channel, nis) in run["nis_mean"].as_object().unwrap() {
                let nis = nis.as_f64().unwrap();
                assert!((0.3..=1.5).contains(&nis), "{} {channel}: {nis}", group["control"]);
            }
            assert_eq!(run["false_alarms"], 0, "{run}");
        }
    }
}

/// A host that streams the file applies trims up to 0.3 s later, and closes no loop on the encoder itself.
#[test]
fn the_serial_host_makes_up_for_a_slip_too() {
    let file = gcode("prusa_cube_pla_marlin_relE.gcode");
    let run = json(&[
        "sim",
        &file,
        "--layers",
        "6",
        "--scenario",
        "slip09",
        "--control",
        "encoder",
        "--host",
        "serial",
        "--seed",
        "103",
    ]);
    let settled = number(&run, "feed_error_after_2s_rel");
    assert!(settled < 0.005, "{settled}");
    assert_eq!(run["host"], "serial");
}

/// P8: the same print, sound and with 0.8 mm of lost steps, seen by the camera alone.
#[test]
fn the_camera_tells_a_shifted_layer_from_a_sound_print() {
    let file = gcode("prusa_cube_pla_marlin_relE.gcode");
    let judged = |scenario: &str, seed: &str| {
        json(&["sim", &file, "--layers", "6", "--camera", "--scenario", scenario, "--seed", seed])
    };
    let sound = judged("nominal", "311");
    assert_eq!((&sound["ended"], &sound["false_alarms"]), (&"done".into(), &0.into()), "{sound}");
    let widths = number(&sound["camera"], "widths");
    let (bias_m, sigma_m) =
        (number(&sound["camera"], "width_bias_m"), number(&sound["camera"], "width_sigma_m"));
    // A tenth of a road: what P5 must not take for a defect.
    assert!(widths > 50.0 && bias_m.abs() < 4.5e-5 && sigma_m < 4.5e-5, "{widths} {bias_m} {sigma_m}");
    let shifted = judged("layer_shift", "312");
    assert_eq!(shifted["ended"], "paused", "{shifted}");
    let found = &shifted["detections"];
    let paused = found.as_array().unwrap().iter().find(|one| one["action"] == "paused").unwrap();
    assert_eq!(paused["fault"], "P8", "{shifted}");
    let reaction_s = number(paused, "detected_s") - number(paused, "onset_s");
    assert!((0.0..=30.0).contains(&reaction_s), "{reaction_s} s");
}

/// P5: a fifth of the melt is lost over sparse infill, where no width can be measured; and what happens around every
/// printer is none.
#[test]
fn the_camera_tells_too_little_melt_in_the_walls_of_a_part() {
    let file = gcode("prusa_cube_pla_marlin_relE.gcode");
    let scenario = std::env::temp_dir().join(format!("fdm_leak_{}.yaml", std::process::id()));
    let leak = "{component: extruder, kind: leak, size: 0.2, onset: {filament_share: 0.8}}";
    std::fs::write(&scenario, format!("description: a leak in the tenth layer\nfaults:\n  - {leak}\n"))
        .unwrap();
    let judged = |scenario: &str, seed: &str| {
        json(&["sim", &file, "--layers", "12", "--camera", "--scenario", scenario, "--seed", seed])
    };
    let thin = judged(scenario.to_str().unwrap(), "313");
    std::fs::remove_file(&scenario).unwrap();
    assert_eq!((&thin["ended"], &thin["false_alarms"]), (&"paused".into(), &0.into()), "{thin}");
    let found = &thin["detections"];
    let paused = found.as_array().unwrap().iter().find(|one| one["action"] == "paused").unwrap();
    let reaction_s = number(paused, "detected_s") - number(paused, "onset_s");
    assert!(paused["fault"] == "P5" && (0.0..=20.0).contains(&reaction_s), "{paused}");
    let sound = judged("nuisance", "314");
    assert_eq!((&sound["ended"], &sound["false_alarms"]), (&"done".into(), &0.into()), "{sound}");
}

/// What ends a print does, and what does not leaves it alone; a scenario that cannot be loaded fails. Without the camera:
/// what only it sees goes unnoticed here.
#[test]
fn every_shipped_scenario_runs() {
    let file = gcode("prusa_cube_pla_marlin_relE.gcode");
    for entry in std::fs::read_dir(root().join("config/scenarios")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let Some(scenario) = name.strip_suffix(".yaml") else { continue };
        let run = json(&["sim", &file, "--layers", "3", "--scenario", scenario, "--control", "mpc"]);
        let expected = match scenario {
            "heater_dead" | "heater_loose" | "heater_weak" | "heater_stuck_on" | "stop_pressed" => "failed",
            "thermistor_open" | "thermistor_short" | "thermistor_out" | "thermistor_loose" => "failed",
            "thermistor_stuck" | "thermistor_step" | "thermistor_drift" | "thermistor_drift_down" => "failed",
            name if name.starts_with("bed_") => "failed",
            "run_out" => "paused",
            _ => "done",
        };
        assert_eq!(run["ended"], expected, "{scenario}: {run}");
        assert_eq!(run["false_alarms"], 0, "{scenario}: {run}");
    }
}

#[test]
fn a_heater_fault_ends_the_print_and_is_told() {
    let file = gcode("prusa_cube_pla_marlin_relE.gcode");
    for (scenario, cause, limit_s) in
        [("thermistor_open", "S1", 0.5), ("heater_dead", "P2", 5.0), ("heater_stuck_on", "P1", 8.0)]
    {
        let run = json(&["sim", &file, "--layers", "3", "--scenario", scenario]);
        assert_eq!(run["ended"], "failed", "{scenario}: {run}");
        let found = &run["detections"][0];
        assert_eq!(found["fault"], cause, "{scenario}: {run}");
        let reaction_s = number(found, "detected_s") - number(found, "onset_s");
        assert!(reaction_s <= limit_s, "{scenario}: {reaction_s} s, limit {limit_s} s");
    }
}

#[test]
fn a_file_is_surveyed_with_its_oddities() {
    for name in [
        "prusa_cube_pla_marlin_relE.gcode",
        "prusa_bracket_petg_klipper_fwretract_absE.gcode",
        "prusa_ring_pla_marlin_arcfit_G2G3.gcode",
        "cura_cube_pla_marlin.gcode",
        "quirks_handmade.gcode",
    ] {
        let survey = json(&["gcode", &gcode(name)]);
        for field in SURVEY {
            assert!(keys(&survey).contains(&field), "{name}: {field}");
        }
        if name.starts_with("prusa") {
            let (planned_s, stated_s) = (number(&survey, "print_time_s"), number(&survey, "stated_time_s"));
            assert!((planned_s / stated_s - 1.0).abs() < 0.1, "{name}: {planned_s} s, stated {stated_s} s");
        }
        for warning in survey["warnings"].as_array().unwrap() {
            assert!(warning["line"].as_u64().is_some() && warning["reason"].is_string(), "{name}: {warning}");
        }
    }
}

#[test]
fn the_help_of_up_says_which_camera_is_looked_through() {
    let help = String::from_utf8(run(&["up", "--help"]).stdout).unwrap();
    assert!(help.contains("The camera is simulated") && help.contains("config/camera.param.yaml"), "{help}");
}

/// In virtual time a solve ends by its iterations: with no time at all for one, the figures are the same.
#[test]
fn a_busy_machine_changes_no_figure() {
    let folder = std::env::temp_dir().join(format!("fdm_no_time_{}", std::process::id()));
    copy_folder(&root().join("config"), &folder).unwrap();
    let path = folder.join("mpc_controller.param.yaml");
    let text = std::fs::read_to_string(&path).unwrap();
    let hurried = text.replace("time_limit_s: 0.05", "time_limit_s: 1e-9");
    assert_ne!(text, hurried);
    std::fs::write(&path, hurried).unwrap();

    let file = gcode("prusa_cube_pla_marlin_relE.gcode");
    let print = ["sim", &file, "--layers", "2", "--scenario", "slip09", "--control", "mpc"];
    let [usual, hurried] = ["config", folder.to_str().unwrap()].map(|config| {
        let mut figures = json(&[&print[..], &["--config", config]].concat());
        for of_the_machine in ["wall_time_s", "realtime_factor"] {
            assert!(figures.as_object_mut().unwrap().remove(of_the_machine).is_some());
        }
        figures
    });
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(usual, hurried);
}
