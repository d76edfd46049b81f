//! The machine's error budget: one number for classifier and supervisor.

use super::{json, refused, root};
use runtime::params::{NodePath, Parameters};
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};
use system_tests::copy_folder;

#[derive(serde::Deserialize)]
struct MachineBlock {
    error_known: bool,
    error_m: f64,
}

/// What classifier and supervisor are told of the machine is one number.
fn budgets(overrides: &[(&str, &str)]) -> (MachineBlock, f64) {
    let read = |node: &str| {
        let path = NodePath { qualified: format!("/printer/{node}"), base: node.to_owned() };
        let own = overrides.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned()));
        let own: Vec<_> =
            own.filter(|(name, _)| name.starts_with("shift") == (node == "safety_supervisor")).collect();
        Parameters::read(&[root().join(format!("config/{node}.param.yaml"))], &own, &path).unwrap()
    };
    let supervisor: safety_supervisor::Params = read("safety_supervisor").parse().unwrap();
    (read("defect_classifier").block("machine").unwrap(), supervisor.shift.machine_error_m)
}

#[test]
fn both_parameter_files_carry_the_same_budget_of_the_machine() {
    let (classifier, supervisor_m) = budgets(&[]);
    assert!(!classifier.error_known, "the shipped printer is a cartesian one");
    assert!((classifier.error_m - supervisor_m).abs() < 1e-12);
}

/// 0.8 mm of offset end the print of a machine that is true to 0.1 mm, not of one that is only true to 1.5 mm.
#[test]
fn a_shift_within_the_machines_error_is_not_blamed_on_the_print() {
    let end = |error_m: &str| {
        let folder = config_with(error_m, error_m);
        let file = root().join("tests/data/gcode/prusa_cube_pla_marlin_relE.gcode");
        let figures = json(&[
            "sim",
            file.to_str().unwrap(),
            "--config",
            folder.to_str().unwrap(),
            "--camera",
            "--scenario",
            "layer_shift",
            "--layers",
            "2",
            "--control",
            "mpc",
        ]);
        std::fs::remove_dir_all(&folder).unwrap();
        figures["ended"].as_str().unwrap().to_owned()
    };
    assert_eq!(end("0.0001"), "paused");
    assert_eq!(end("0.0015"), "done");
}

#[test]
fn two_nodes_that_know_different_errors_of_one_machine_are_refused() {
    let folder = config_with("0.0005", "0.0");
    let file = root().join("tests/data/gcode/prusa_cube_pla_marlin_relE.gcode");
    refused(
        &["sim", file.to_str().unwrap(), "--config", folder.to_str().unwrap()],
        &["machine.error_m = 0.0005 m", "shift.machine_error_m = 0 m", "must be the same"],
    );
    std::fs::remove_dir_all(&folder).unwrap();
}

/// The shipped parameters with a budget of the machine in classifier and supervisor `[m]`.
fn config_with(classifier_m: &str, supervisor_m: &str) -> PathBuf {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let name = format!("fdm_budget_{}_{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let folder = std::env::temp_dir().join(name);
    copy_folder(&root().join("config"), &folder).unwrap();
    let change = |file: &str, from: &str, to: String| {
        let path = folder.join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{file}: {from}");
        std::fs::write(&path, text.replace(from, &to)).unwrap();
    };
    change("defect_classifier.param.yaml", "error_known: false", "error_known: true".to_owned());
    change("defect_classifier.param.yaml", "error_m: 0.0", format!("error_m: {classifier_m}"));
    change(
        "safety_supervisor.param.yaml",
        "machine_error_m: 0.0",
        format!("machine_error_m: {supervisor_m}"),
    );
    folder
}

/// What `fdm kinematics budget` prints is what both nodes take, and it is small against a layer shift of 0.5 mm where the
/// hemisphere is not near its fold.
#[test]
fn the_printed_budget_is_what_both_nodes_take() {
    let figures = json(&["kinematics", "budget"]);
    let error_m = figures["safety_supervisor_machine_error_m"].as_f64().unwrap();
    assert!((figures["defect_classifier"]["error_m"].as_f64().unwrap() - error_m).abs() < 1e-15);
    assert!(2e-3 * figures["lateral_mm"].as_f64().unwrap() <= error_m && error_m < 5e-4, "{error_m}");
    let value = format!("{error_m:.6}");
    let (classifier, supervisor_m) = budgets(&[
        ("machine.error_known", "true"),
        ("machine.error_m", &value),
        ("shift.machine_error_m", &value),
    ]);
    assert!(classifier.error_known && (classifier.error_m - supervisor_m).abs() < 1e-12);
    // A full step wrong, down to the fold: no budget hides that.
    refused(
        &["kinematics", "budget", "--step", "36", "--from-height", "0"],
        &["machine_error_m", "must be in [0, 0.01]"],
    );
}
