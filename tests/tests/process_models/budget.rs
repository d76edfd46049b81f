//! The machine's error budget: one number for classifier and supervisor.

use super::{json, refused, root};
use runtime::params::{NodePath, Parameters};

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
