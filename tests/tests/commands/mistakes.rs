//! What a person gets wrong: the exit code and the line that says it.

use super::{gcode, root, run};
use system_tests::copy_folder;

/// Whatever a person gets wrong: exit code 2 and one line that says what and where.
#[test]
fn mistakes_end_with_code_2_and_one_line() {
    let file = gcode("prusa_cube_pla_marlin_relE.gcode");
    let no_move = std::env::temp_dir().join(format!("fdm_no_move_{}.gcode", std::process::id()));
    std::fs::write(&no_move, "; nothing\n").unwrap();
    let no_move = no_move.display().to_string();
    let cases: [(&[&str], &str); 16] = [
        (&["sim", "nowhere.gcode"], "nowhere.gcode"),
        (&["sim", &file, "--scenario", "nope"], "slip09"),
        (&["sim", &file, "--control", "pid"], "off, encoder or mpc"),
        (&["sim", &file, "--control", "mpc,off,mpc"], "'mpc' stands twice"),
        (&["sim", &file, "--without", "width,width"], "'width' stands twice"),
        (&["sim", &file, "--seeds", "5..1"], "A..B"),
        (&["sim", &file, "--material", "NYLON"], "PETG"),
        (&["gcode", "nowhere.gcode"], "nowhere.gcode"),
        (&["up", "--gcode", &file, "--speed", "0"], "[0.1, 20]"),
        (&["sim", &file, "--config", "/nowhere"], "/nowhere"),
        (&["sim", &no_move], "no move"),
        (&["sim", &file, "--json", "/nowhere/x.json"], "/nowhere/x.json"),
        (&["up", "--gcode", &file, "--control", "off,off"], "twice"),
        (&["up", "--gcode", &file, "--json", "/nowhere/x.json"], "/nowhere/x.json"),
        (&["gcode", "nowhere.gcode", "--json", "/nowhere/x.json"], "/nowhere/x.json"),
        (&["status", "--json", "/nowhere/x.json"], "/nowhere/x.json"),
    ];
    for (arguments, told) in cases {
        let output = run(arguments);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
        assert_eq!(text.trim_end().lines().count(), 1, "{arguments:?}: {text}");
        assert!(text.contains(told), "{arguments:?}: {text}");
        assert!(output.stdout.is_empty());
    }
    std::fs::remove_file(no_move).unwrap();
}

/// A benchmark takes minutes: that its figures cannot be written is told before it makes anything.
#[test]
fn a_benchmark_that_cannot_write_its_figures_begins_nothing() {
    let bags = std::env::temp_dir().join(format!("fdm_kept_{}", std::process::id()));
    let kept = bags.display().to_string();
    let output =
        run(&["bench", "recorder", "--kills", "1", "--keep", &kept, "--json", "/nowhere/figures.json"]);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!bags.exists(), "{told}");
    assert_eq!((output.status.code(), told.lines().count()), (Some(2), 1), "{told}");
    assert!(told.contains("/nowhere/figures.json"), "{told}");
}

/// A parameter out of range names file, line, field, value and range.
#[test]
fn a_bad_parameter_file_is_told_by_line() {
    let folder = std::env::temp_dir().join(format!("fdm_config_{}", std::process::id()));
    copy_folder(&root().join("config"), &folder).unwrap();
    let path = folder.join("printers/ender3.yaml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("coupling_w_k: 0.45", "coupling_w_k: -0.45")).unwrap();
    let line = text.lines().position(|line| line.contains("coupling_w_k")).unwrap() + 1;

    let file = gcode("prusa_cube_pla_marlin_relE.gcode");
    let output = run(&["sim", &file, "--config", folder.to_str().unwrap()]);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(output.status.code(), Some(2), "{told}");
    let expected =
        format!("ender3.yaml:{line}: printer.hotend.coupling_w_k = -0.45 W/K: must be in [0.0001, 100]");
    assert!(told.contains(&expected), "{told}");
}
