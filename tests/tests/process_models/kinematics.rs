//! The figures of the five-axis machine.

use super::{json, list, number, run};

/// Acceptance: Table 2 within 10 %, Table 1 from z = 15 mm on within 15 %. Below it Table 1 contradicts Table 2 (24.9 mm
/// at 1.8 degrees, 2.52 mm at 1.0), and both cannot be met: ours is at most a seventh of it away, and no larger.
#[test]
fn the_tables_of_the_hybrid_paper_are_met_where_they_agree_with_each_other() {
    let figures = json(&["kinematics", "error"]);
    assert!(figures["provenance"].as_str().unwrap().contains("not printed"));
    for row in list(&figures, "rows") {
        let residual = number(row, "residual_rel");
        let bounds = match (row["table"].as_u64(), number(row, "height_mm")) {
            (Some(2), _) => -0.10..0.10,
            (Some(1), height_mm) if height_mm < 14.9 => 1.0 / 7.0 - 1.0..0.15,
            (Some(1), _) => -0.15..0.15,
            _ => panic!("{row}"),
        };
        assert!(bounds.contains(&residual), "{row}");
        assert_eq!(row["failed"], 0);
    }
    let text = String::from_utf8(run(&["kinematics", "error"]).stdout).unwrap();
    assert!(text.contains("hypothesis") && text.contains("not printed"), "{text}");
}

/// What Table 2 and the shape of the error say of the rows of Table 1 below 15 mm: higher up the machine is less wrong,
/// and 1.8 degrees are at least 1.8 times as bad as the 2.52 mm printed for 1.0, for gains only grow towards the fold.
#[test]
fn the_rows_of_table_1_near_the_fold_are_consistent_with_table_2() {
    let figures = json(&["kinematics", "error"]);
    let of_1: Vec<f64> = list(&figures, "rows")
        .iter()
        .filter(|row| row["table"] == 1)
        .map(|row| number(row, "error_mm"))
        .collect();
    assert!(of_1.len() == 8 && of_1.is_sorted_by(|lower, higher| lower > higher), "{of_1:?}");
    assert!(of_1[0] >= 1.8 * 2.52, "{of_1:?}");
}

/// Worst errors are of all combinations of signs or of none: where wrong carriages have no pose, how many is said.
#[test]
fn a_motor_too_wrong_for_a_pose_gives_a_count_and_no_worst_error() {
    let arguments = ["kinematics", "error", "--height", "0,75", "--angle", "7.2", "--monte-carlo", "50"];
    let figures = json(&arguments);
    let [fold, pole] = list(&figures, "rows") else { panic!("{figures}") };
    assert!(fold["failed"].as_u64().unwrap() > 0 && fold["error_mm"].is_null(), "{fold}");
    assert!(fold["random_failed"].as_u64().unwrap() > 0 && fold["random_mm"].is_null(), "{fold}");
    assert!(pole["failed"] == 0 && number(pole, "error_mm") > 0.0 && pole["random_failed"] == 0, "{pole}");
    let text = String::from_utf8(run(&arguments).stdout).unwrap();
    assert!(text.contains(&format!("{} of 32 combinations of signs", fold["failed"])), "{text}");
    assert!(text.contains(&format!("{} of 50 draws", fold["random_failed"])), "{text}");
}

/// Model book 4.4: 0.10 mm -> 64 and 0.05 mm -> 128 microsteps; the motors alone make 0.19 mm at z = 0.
#[test]
fn microsteps_do_not_replace_an_encoder() {
    for (target, microsteps) in [("0.1", 64), ("0.05", 128)] {
        let figures = json(&["kinematics", "synthesize", "--target", target]);
        let design = &list(&figures, "designs")[0];
        assert!(
            (number(design, "step_deg") - 1.8).abs() < 1e-9
                && (number(design, "lead_mm") - 10.0).abs() < 1e-9
        );
        assert_eq!(design["microsteps"], microsteps);
        assert!((number(design, "motor_error_mm") - 0.19).abs() < 0.01, "{design}");
        assert_eq!(design["encoder_needed"], true);
    }
}
