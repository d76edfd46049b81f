//! Pressure advance foretold instead of measured, in closed loop over `fdm sim`.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Corner width RMS and print time of a file's first layers, on a firmware that knows four moves ahead.
fn printed(file: &str, advance: &str) -> (f64, f64) {
    let fdm = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("fdm");
    assert!(fdm.is_file(), "{} is missing: cargo build --workspace --bins", fdm.display());
    let gcode = format!("tests/data/gcode/{file}");
    // The slip's compensation alone: nothing but the advance differs.
    let arguments = [
        "sim",
        &gcode,
        "--layers",
        "4",
        "--buffer",
        "4",
        "--control",
        "encoder",
        "--seed",
        "11",
        "--json",
        "-",
    ];
    let output = Command::new(fdm)
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
        .args(arguments)
        .args(["--advance", advance])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let run: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(run["ended"], "done", "{run}");
    (run["corner_width_rms_rel"].as_f64().unwrap(), run["print_time_s"].as_f64().unwrap())
}

/// Corners' errors at most half of those without a prediction, and with the material's constant, and at most 1.9 times those
/// with the melt model of the file's own material, whose factor may be learnt as well; no print takes longer.
#[test]
fn a_foretold_advance_makes_corners_truer_and_no_print_longer() {
    for file in ["prusa_ring_pla_marlin_arcfit_G2G3.gcode", "prusa_cube_pla_marlin_relE.gcode"] {
        let (foretold, foretold_s) = printed(file, "predicted");
        for other in ["none", "material"] {
            let (rms, time_s) = printed(file, other);
            assert!(foretold <= 0.5 * rms, "{file}: {foretold} with the prediction, {rms} with {other}");
            assert!(foretold_s <= time_s + 1e-3, "{file}: {foretold_s} s, {time_s} s with {other}");
        }
        let (planned, _) = printed(file, "planned");
        assert!(foretold <= 1.9 * planned, "{file}: {foretold} with the prediction, {planned} planned");
    }
}
