//! `fdm wire` and `fdm kinematics`: the figures of both papers, the simulated wire wall, and what is refused.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

#[path = "process_models/budget.rs"]
mod budget;
#[path = "process_models/kinematics.rs"]
mod kinematics;

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

/// Printed in the paper: 3.50 and 1.68 mm/s, 2.16 mm.
#[test]
fn the_planned_process_is_the_printed_one() {
    let plan = json(&["wire", "plan"]);
    assert!((number(&plan, "wire_mm_s") - 3.50).abs() < 0.005, "{plan}");
    assert!((number(&plan, "head_mm_s") - 1.68).abs() < 0.005, "{plan}");
    assert!((number(&plan, "layer_height_mm") - 2.16).abs() < 0.005, "{plan}");
}

/// 1 kW on aluminium at 6.5 % is the nominal 65 W; every metal plans, and twice the power is twice the speed.
#[test]
fn speed_is_proportional_to_power_in_every_metal() {
    for metal in ["aluminium", "copper", "steel", "stainless_316"] {
        let speed = |power: &str| {
            number(&json(&["wire", "plan", "--material", metal, "--power", power]), "wire_mm_s")
        };
        assert!((speed("2000") / speed("1000") - 2.0).abs() < 1e-9);
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
/// seeds are the default ones; 101..200 give 2.86 and 3.74. Mean heights alone do not make it: about each
/// layer's mean the figures hold too.
#[test]
fn the_closed_loop_keeps_the_wall_straight() {
    let figures = json(&["wire", "sim", "--layers", "20", "--noise", "0.1"]);
    for (name, wanted) in
        [("ratio", 2.5), ("last_ratio", 3.5), ("roughness_ratio", 2.5), ("last_roughness_ratio", 3.5)]
    {
        assert!(number(&figures[name], "mean") >= wanted, "{name}: {}", figures[name]);
    }
    for run in list(&figures["results"][1], "runs") {
        assert_eq!(run["refused"], 0, "{run}");
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

type Corner = [f32; 3];

/// A cone of `sides` sides, 60 mm wide and 50 mm high, with or without its base.
fn cone(sides: u16, closed: bool) -> Vec<[Corner; 3]> {
    let rim = |side: u16| {
        let angle = f32::from(side % sides) / f32::from(sides) * std::f32::consts::TAU;
        [30.0 * angle.cos(), 30.0 * angle.sin(), 0.0]
    };
    let mut triangles = Vec::new();
    for side in 0..sides {
        triangles.push([rim(side), rim(side + 1), [0.0, 0.0, 50.0]]);
        if closed {
            triangles.push([rim(side + 1), rim(side), [0.0, 0.0, 0.0]]);
        }
    }
    triangles
}

fn write_stl(name: &str, triangles: &[[Corner; 3]]) -> String {
    let mut bytes = vec![b' '; 80];
    bytes.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flatten().flat_map(|value| value.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    let path = scratch(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// The machine works on the sides of a cone, and its base looks down: area 1 / (1 + r/s) of the whole.
#[test]
fn the_map_of_a_cone_is_of_its_sides() {
    let part = write_stl("cone.stl", &cone(60, true));
    let picture = scratch("cone.html");
    let map = json(&["kinematics", "map", "--stl", &part, "--picture", &picture]);
    assert_eq!(map["triangles"], 120);
    assert_eq!(map["refused"]["tilt"], 60);
    let slant = 30.0_f64.hypot(50.0);
    assert!((number(&map, "workable_share") - 1.0 / (1.0 + 30.0 / slant)).abs() < 1e-3, "{map}");
    // Looked at in even pieces, not in the triangles' middles alone: the error differs over the height.
    assert!(number(&map, "points") > 1000.0 && number(&map, "edge_mm") < 5.0, "{map}");
    assert!(number(&map, "largest_mm") >= number(&map, "p95_mm"), "{map}");
    assert!(number(&map, "p95_mm") >= number(&map, "mean_mm"), "{map}");
    let page = std::fs::read_to_string(picture).unwrap();
    assert!(
        page.starts_with("<!DOCTYPE html>")
            && page.contains("<svg")
            && page.matches("<polygon").count() >= 120
    );
}

/// Nothing within reach is no map with an error of 0.
#[test]
fn a_part_out_of_reach_is_refused() {
    let part = write_stl("far.stl", &cone(12, true));
    refused(
        &["kinematics", "map", "--stl", &part, "--unit", "1000"],
        &["can work on no point of the part", "tilt", "must be"],
    );
    refused(
        &["kinematics", "budget", "--stl", &part, "--from-height", "49.9"],
        &["--from-height 49.9 mm", "must be 30 or more", "lie below it"],
    );
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
    refused(&["kinematics", "map", "--stl", "nowhere.stl"], &["nowhere.stl"]);
}
