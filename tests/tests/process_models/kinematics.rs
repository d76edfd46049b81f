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

/// Model book 4.4: 0.10 mm -> 64 and 0.05 mm -> 128 microsteps of 1.8 degrees at 10 mm; the motors alone make 0.19 mm at
/// z = 0. Error is proportional to motor angle times lead there, so an encoder is needed exactly where 5 % of a full step
/// and the driver's finest microstep, 1/256, make more than the target: 0.19 mm times (1 + 0.05 * 256) / (0.05 * 256).
#[test]
fn microsteps_do_not_replace_an_encoder() {
    for (target, microsteps) in [("0.1", 64), ("0.05", 128)] {
        let figures = json(&["kinematics", "synthesize", "--target", target]);
        let target_mm: f64 = target.parse().unwrap();
        let designs = list(&figures, "designs");
        assert_eq!(designs[0]["microsteps"], microsteps);
        assert!((number(&designs[0], "motor_error_mm") - 0.19).abs() < 0.01, "{figures}");
        for design in designs {
            let motor_mm = 0.19 * number(design, "step_deg") / 1.8 * number(design, "lead_mm") / 10.0;
            assert!((number(design, "motor_error_mm") / motor_mm - 1.0).abs() < 0.06, "{design}");
            let needed = design["encoder_needed"].as_bool().unwrap();
            let least_mm = motor_mm * (1.0 + 1.0 / (0.05 * 256.0));
            // Not judged where the two lie within the error of 0.19 mm.
            assert!(
                needed == (least_mm > target_mm) || (least_mm / target_mm - 1.0).abs() < 0.06,
                "{design}"
            );
            if !needed {
                let sum_mm = number(design, "sum_error_mm");
                let parts_mm = number(design, "motor_error_mm") + number(design, "microstep_error_mm");
                assert!(sum_mm <= target_mm && (sum_mm / parts_mm - 1.0).abs() < 0.02, "{design}");
            }
        }
        assert!(designs.iter().any(|design| design["encoder_needed"] == false), "{figures}");
    }
}

/// The sum that `synthesize` promises is the error of motors that are wrong by it.
#[test]
fn a_promised_sum_is_the_error_of_its_angle() {
    let figures = json(&["kinematics", "synthesize", "--target", "0.1"]);
    let same_lead = |design: &&serde_json::Value| {
        design["encoder_needed"] == false && (number(design, "lead_mm") - 4.0).abs() < 1e-9
    };
    let design = list(&figures, "designs").iter().find(same_lead).unwrap();
    let step_deg = number(design, "step_deg");
    let angle_deg = step_deg * (0.05 + 1.0 / number(design, "microsteps"));
    // The machine's lead is 10 mm: a carriage as wrong as at 4 mm is one of a smaller angle, and the hemisphere does not
    // see the table.
    let angle = format!("{}", angle_deg * 0.4);
    let row = &json(&["kinematics", "error", "--height", "0", "--angle", &angle])["rows"][0];
    assert!((number(row, "error_mm") / number(design, "sum_error_mm") - 1.0).abs() < 0.01, "{design} {row}");
}

#[test]
fn a_target_that_nothing_reaches_is_called_so() {
    let arguments = ["kinematics", "synthesize", "--target", "0.00001"];
    assert_eq!(json(&arguments)["reachable"], false);
    let text = String::from_utf8(run(&arguments).stdout).unwrap();
    assert!(text.contains("Not reachable"), "{text}");
    assert_eq!(json(&["kinematics", "synthesize", "--target", "0.1"])["reachable"], true);
}

#[test]
fn one_random_draw_has_no_deviation() {
    let output = run(&["kinematics", "error", "--height", "10", "--monte-carlo", "1"]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(2) && said.contains("2..=1000000"), "{said}");
}
