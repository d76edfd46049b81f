//! The wire process: the paper's figures, the simulated wall, and plans that are refused.

use super::{json, list, number, refused, root, run, scratch};
use std::path::Path;
use std::process::Command;

/// Printed in the paper: 3.50 and 1.68 mm/s, 2.16 mm.
#[test]
fn the_planned_process_is_the_printed_one() {
    let plan = json(&["wire", "plan"]);
    assert!((number(&plan, "wire_mm_s") - 3.50).abs() < 0.005, "{plan}");
    assert!((number(&plan, "head_mm_s") - 1.68).abs() < 0.005, "{plan}");
    assert!((number(&plan, "layer_height_mm") - 2.16).abs() < 0.005, "{plan}");
}

/// What a cubic centimetre takes from room temperature to melt `[J]`, from handbook figures of the pure metal (316: of the
/// steel): density times (specific heat times difference, and heat of fusion).
const MELT_J_CM3: [(&str, f64); 4] = [
    ("aluminium", 2.70 * (0.897 * 640.0 + 397.0)),
    ("copper", 8.96 * (0.440 * 1065.0 + 209.0)),
    ("steel", 7.85 * (0.694 * 1507.0 + 247.0)),
    ("stainless_316", 7.95 * (0.590 * 1415.0 + 270.0)),
];

/// 1 kW on aluminium at 6.5 % is the nominal 65 W; every metal's speed is power over section and heat of melting, and twice
/// the power is twice the speed.
#[test]
fn speed_is_proportional_to_power_in_every_metal() {
    for (metal, melt_j_cm3) in MELT_J_CM3 {
        let plan = |power: &str| {
            json(&["wire", "plan", "--material", metal, "--power", power, "--absorptivity", "0.1"])
        };
        let speed = |power: &str| number(&plan(power), "wire_mm_s");
        assert!((speed("2000") / speed("1000") - 2.0).abs() < 1e-9);
        // 100 W absorbed, a wire of 3 mm; the handbook's figures are rounded to three digits.
        let mm_s = 100.0 / (1e-3 * melt_j_cm3 * std::f64::consts::FRAC_PI_4 * 9.0);
        assert!((speed("1000") / mm_s - 1.0).abs() < 0.01, "{metal}: {} {mm_s}", speed("1000"));
    }
    let plan = json(&["wire", "plan", "--power", "1000"]);
    assert!((number(&plan, "absorbed_w") - 65.0).abs() < 1e-9);
}

/// Acceptance: all rows but the misprint within 0.035 mm/s, and the misprint where it is read as 3.69 mm.
#[test]
fn the_tables_of_the_wire_paper_are_met_but_for_one_row() {
    let figures = json(&["wire", "correct"]);
    let rows = list(&figures, "published");
    assert_eq!(rows.len(), 6);
    for row in rows {
        let residual = number(row, "wire_residual_mm_s").abs().max(number(row, "head_residual_mm_s").abs());
        let misprint = (number(row, "height_mm") - 3.09).abs() < 1e-9;
        assert_eq!(residual > 0.035, misprint, "{row}");
        assert_eq!(row["hypothesis"].as_bool().unwrap(), (number(row, "height_mm") - 3.69).abs() < 1e-9);
    }
}

/// Each mode lays the same section: a dip of a quarter of a millimetre wants r = 1 + 0.635 * 0.25 / 2.16.
#[test]
fn every_mode_lays_the_same_section() {
    for mode in ["both", "wire", "head"] {
        let figures = json(&["wire", "correct", "--height", "1.91", "--mode", mode]);
        let row = &list(&figures, "heights")[0];
        assert!((number(row, "section_ratio") - 1.073_495).abs() < 1e-6, "{mode}: {row}");
    }
}

/// Acceptance: 20 layers with dips and bumps of 0.5 mm in each, 0.1 mm of noise, layer k correcting layer k+1. The
/// default seeds and others, which nothing was chosen on. A mean of ratios could hide a bad wall behind a good one: the
/// mean height RMS of all walls has the ratio too, within the 5 % that 40 seeds leave (the last layer's roughness: 3.4996 at
/// 101..140), and no wall is worse than without the loop. Mean heights alone do not
/// make it: about each layer's mean the figures hold too.
#[test]
fn the_closed_loop_keeps_the_wall_straight() {
    for seeds in ["1..40", "101..140"] {
        let figures = json(&["wire", "sim", "--layers", "20", "--noise", "0.1", "--seeds", seeds]);
        let pooled = |name: &str| {
            let [open, closed] = [0, 1].map(|group| number(&figures["results"][group][name], "mean"));
            open / closed
        };
        for (ratio, height, wanted) in [
            ("ratio", "rms_mm", 2.5),
            ("last_ratio", "last_rms_mm", 3.5),
            ("roughness_ratio", "roughness_mm", 2.5),
            ("last_roughness_ratio", "last_roughness_mm", 3.5),
        ] {
            assert!(number(&figures[ratio], "mean") >= wanted, "{seeds} {ratio}: {}", figures[ratio]);
            assert!(pooled(height) >= 0.95 * wanted, "{seeds} {height}: {}", pooled(height));
            assert!(number(&figures[ratio], "least") > 1.0, "{seeds} {ratio}: {}", figures[ratio]);
        }
        for run in list(&figures["results"][1], "runs") {
            assert!(run["refused"] == 0 && number(run, "measured") > 1000.0, "{run}");
        }
    }
}

/// Beyond a gain of 2 limits hold what would grow, and the figures look better than open: the text says so.
#[test]
fn a_growth_that_limits_hide_is_said() {
    let text = String::from_utf8(run(&["wire", "sim", "--gain", "2.2", "--seeds", "1..3"]).stdout).unwrap();
    // 1.2^19 = 31.9.
    assert!(text.contains("UNSTABLE") && text.contains("1.200") && text.contains("31.9 times"), "{text}");
    assert!(text.contains("limits held the correction in"), "{text}");
}

/// A copy of the shipped configuration with one text of `wire/<file>` replaced.
fn config_with(name: &str, file: &str, (from, to): (&str, &str)) -> String {
    let folder = scratch(name);
    let copied = Command::new("cp").args(["-rT"]).arg(root().join("config")).arg(&folder).status().unwrap();
    assert!(copied.success());
    let path = Path::new(&folder).join("wire").join(file);
    let text = std::fs::read_to_string(root().join("config/wire").join(file)).unwrap();
    assert!(text.contains(from), "{from}");
    std::fs::write(path, text.replace(from, to)).unwrap();
    folder
}

#[test]
fn a_plan_beyond_machine_or_mass_balance_is_refused_by_every_command() {
    for (name, from, to, part) in [
        ("fast", "head_m_s: 0.00168", "head_m_s: 1.68", "law.head_m_s = 1.68 m/s: must be in [0.0005, 0.01]"),
        (
            "high",
            "      height_m: 0.00216",
            "      height_m: 0.0216",
            "law.height_m = 0.0216 m: must be within 10 %",
        ),
        ("rich", "wire_m_s: 0.0035 ", "wire_m_s: 0.0045 ", "law.wire_m_s = 0.0045 m/s: must be within 10 %"),
    ] {
        let config = config_with(&format!("wire_{name}"), "process.yaml", (from, to));
        for arguments in [
            &["wire", "correct", "--height", "2.0"][..],
            &["wire", "sim", "--layers", "1", "--seeds", "1..1"],
            &["wire", "up", "--layers", "1", "--dry-run"],
        ] {
            refused(&[arguments, &["--config", &config]].concat(), &[part]);
        }
    }
}

#[test]
fn refused_heights_are_said() {
    let config = config_with("wire_deaf", "controller.yaml", ("error_max_m: 0.005", "error_max_m: 5.0e-9"));
    let arguments = ["wire", "sim", "--layers", "2", "--seeds", "1..2", "--config", &config];
    let text = String::from_utf8(run(&arguments).stdout).unwrap();
    assert!(text.contains("heights: 100.0 % refused") && text.contains("all: closed is open"), "{text}");
}

#[test]
fn options_of_a_wall_are_refused_before_it_starts() {
    for (option, value, told) in
        [("--namespace", "bad ns", "write /bad_ns"), ("--layers", "0", "--layers <LAYERS>")]
    {
        let output = run(&["wire", "up", option, value, "--dry-run"]);
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && said.contains(told), "{said}");
    }
}

/// Height RMS of each layer, mean over the seeds, of walls whose first layer alone has dips and bumps.
fn decay(gain: &str) -> Vec<f64> {
    let figures =
        json(&["wire", "sim", "--dips", "first", "--noise", "0", "--gain", gain, "--seeds", "1..5"]);
    list(&figures["results"][1], "rms_by_layer_mm").iter().map(|value| value.as_f64().unwrap()).collect()
}

/// On the plant, whose own gain is 0.99: inside (0, 2) the first layer's error fades to what scatter and the plant's
/// drift of 0.018 mm a layer leave (drift over gain: 0.06 mm at 0.3).
#[test]
fn the_simulated_wall_is_stable_for_gains_in_zero_to_two() {
    for gain in ["0.3", "0.635", "1.0", "1.5", "1.9"] {
        let rms_mm = decay(gain);
        assert!(rms_mm[19] < 0.85 * rms_mm[0] + 0.05, "gain {gain}: {rms_mm:?}");
        // No growth either: the second ten layers are no rougher than the first ten but for the seeds' scatter.
        let (first, second): (f64, f64) = (rms_mm[..10].iter().sum(), rms_mm[10..].iter().sum());
        assert!(second < 1.25 * first, "gain {gain}: {rms_mm:?}");
    }
}

/// Beyond 2 it grows, until the limits of the law hold it.
#[test]
fn the_simulated_wall_is_unstable_beyond_a_gain_of_two() {
    for gain in ["2.1", "2.3", "3.0"] {
        let rms_mm = decay(gain);
        assert!(rms_mm[4] > 1.1 * rms_mm[0] && rms_mm[19] > 1.5 * rms_mm[0], "gain {gain}: {rms_mm:?}");
    }
}
