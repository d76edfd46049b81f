//! `ros2 launch` starts what `fdm up`, systemd and `fdm play` start. Without ROS: the launch files are evaluated against
//! stand-ins of the launch modules (`tests/readers/launch.py`), and lists of processes are compared down to every merged
//! parameter.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

#[path = "launch/meaning.rs"]
mod meaning;

use meaning::{meaning, start_after, to_owned};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn root() -> PathBuf {
    std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap()
}

/// Executables stand beside the folder of the test's own.
fn binaries() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().to_owned()
}

const GCODE: &str = "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode";

fn launched(file: &str, arguments: &[&str]) -> Output {
    let bin = format!("bin:={}", binaries().display());
    Command::new("python3")
        .current_dir(root())
        .args(["tests/readers/launch.py", &format!("launch_scripts/{file}.launch.py"), &bin])
        .args(arguments)
        .output()
        .unwrap()
}

fn processes(output: &Output) -> Vec<Value> {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// `fdm up` and `sim.launch.py` with the same wishes start the same processes.
fn same_as_fdm_up(name: &str, up: &[&str], launch: &[&str]) {
    let folder = std::env::temp_dir().join(format!("fdm_launch_{name}_{}", std::process::id()));
    let bag = folder.join("bag");
    let bag = bag.to_str().unwrap();
    let up = Command::new(binaries().join("fdm"))
        .current_dir(root())
        .args(["up", "--bag", bag, "--dry-run"])
        .args(up)
        .output()
        .unwrap();
    let ours: Vec<Value> = processes(&up)[0].as_array().unwrap().clone();
    let bag_argument = format!("bag:={bag}");
    // A former print with this bag ended paused: of another print, and nothing that this one's supervisor may find.
    let record = Path::new(&format!("{bag}_logs")).join("latch.standing.json");
    std::fs::create_dir_all(record.parent().unwrap()).unwrap();
    std::fs::write(&record, "{}").unwrap();
    let theirs = processes(&launched("sim", &[launch, &[bag_argument.as_str()]].concat()));
    assert!(!record.exists(), "{}", record.display());
    // The one parameter that only `fdm up` has: the text of the whole configuration, for the bag.
    let config_file = format!("{bag}_logs/config.txt");
    assert_eq!(ours.len(), theirs.len());
    // The printer comes last in both: `fdm up` activates in the order of its list, launch waits.
    let names: Vec<&str> = ours.iter().map(|process| process["node"].as_str().unwrap()).collect();
    let (printer, others) = names.split_last().unwrap();
    for process in &theirs {
        let wanted: &[&str] = if process["node"] == *printer { others } else { &[] };
        assert_eq!(start_after(process), to_owned(wanted), "{}", process["node"]);
    }
    for (ours, theirs) in ours.iter().zip(&theirs) {
        assert_eq!(meaning(ours).map(|part| part.replace(&config_file, "")), meaning(theirs));
        let printer = theirs["node"] == "printer_sim";
        assert_eq!((theirs["respawn"] == true, theirs["ends_all"] == true), (!printer, printer));
    }
    _ = std::fs::remove_dir_all(folder);
}

#[test]
fn the_launch_file_starts_what_fdm_up_starts() {
    let gcode = format!("gcode:={GCODE}");
    let up = ["--gcode", GCODE, "--scenario", "slip09", "--speed", "4", "--layers", "3", "--warm"];
    let more = ["--control", "encoder", "--host", "serial", "--seed", "7", "--allow-fault-injection"];
    let launch =
        ["scenario:=slip09", "speed:=4.0", "layers:=3", "warm:=true", "control:=encoder", "host:=serial"];
    same_as_fdm_up(
        "usual",
        &[&up[..], &more].concat(),
        &[&launch[..], &["seed:=7", "allow_fault_injection:=true", &gcode]].concat(),
    );
    // The file's own material, a foretold advance; then another material with its set-points.
    const PETG: &str = "tests/data/gcode/prusa_bracket_petg_klipper_fwretract_absE.gcode";
    let petg = format!("gcode:={PETG}");
    same_as_fdm_up(
        "predicted",
        &["--gcode", PETG, "--advance", "predicted", "--namespace", "/left"],
        &[&petg, "advance:=predicted", "namespace:=/left"],
    );
    same_as_fdm_up("material", &["--gcode", PETG, "--material", "ABS"], &[&petg, "material:=ABS"]);
    same_as_fdm_up("host_clock", &["--gcode", PETG, "--host-clock"], &[&petg, "host_clock:=true"]);
}

/// Arguments of a node as its unit has them: drop-ins read in, variables filled in, `/usr` and `/etc` of the package.
fn unit(node: &str, etc: &Path) -> Value {
    let units = root().join("launch_scripts/systemd");
    let template = std::fs::read_to_string(units.join("fdm_loop@.service")).unwrap();
    let dropins = std::fs::read_dir(units.join(format!("fdm_loop@{node}.service.d"))).into_iter().flatten();
    let texts: String = dropins.map(|file| std::fs::read_to_string(file.unwrap().path()).unwrap()).collect();
    let value = |text: &str, key: &str| {
        let mut words = text.lines().filter_map(|line| line.strip_prefix("Environment=")).flat_map(|line| {
            // One quoted assignment, or several without blanks.
            line.strip_prefix('"').map_or_else(
                || line.split(' ').map(str::to_owned).collect::<Vec<_>>(),
                |quoted| vec![quoted.trim_end_matches('"').to_owned()],
            )
        });
        words.find_map(|word| Some(word.strip_prefix(key)?.strip_prefix('=')?.to_owned())).unwrap_or_default()
    };
    let line = template.lines().find_map(|line| line.strip_prefix("ExecStart=")).unwrap();
    let line = line
        .replace("%i", node)
        .replace("${NAMESPACE}", &value(&template, "NAMESPACE"))
        .replace("$FILES", &value(&texts, "FILES"))
        .replace("$ARGUMENTS", &value(&texts, "ARGUMENTS"));
    let line = line
        .replace("/usr/share/fdm_loop/config", root().join("config").to_str().unwrap())
        .replace("/etc/fdm_loop", etc.to_str().unwrap());
    let mut words = line.split_whitespace();
    let program = words.next().unwrap();
    assert_eq!(program, format!("/usr/lib/fdm_loop/{node}"));
    serde_json::json!({"node": node, "program": binaries().join(node), "arguments": words.collect::<Vec<_>>()})
}

/// Beside a real printer: what the launch file starts, and what `fdm_loop.target` starts, have the same parameters but for
/// the folders that are each one's own.
#[test]
fn the_graph_beside_a_printer_is_the_same_under_launch_and_systemd() {
    let folder = std::env::temp_dir().join(format!("fdm_launch_monitor_{}", std::process::id()));
    let etc = folder.join("etc");
    std::fs::create_dir_all(&etc).unwrap();
    for (link, to) in [("printer", "printers/ender3"), ("material", "materials/pla")] {
        let to = root().join(format!("config/{to}.yaml"));
        std::os::unix::fs::symlink(to, etc.join(link).with_extension("yaml")).unwrap();
    }
    let bag = folder.join("bag");
    let bag = format!("bag:={}", bag.display());
    let latch = format!("latch_file:={}", folder.join("latch.json").display());
    let launched =
        processes(&launched("monitor", &[&bag, &latch, "advance:=predicted", "namespace:=/printer"]));
    let target = std::fs::read_to_string(root().join("launch_scripts/systemd/fdm_loop.target")).unwrap();
    for process in &launched {
        let node = process["node"].as_str().unwrap();
        assert!(target.contains(&format!("fdm_loop@{node}.service")), "{node} is not part of the target");
        std::fs::write(etc.join(format!("{node}.param.yaml")), "/**:\n  ros__parameters: {}\n").unwrap();
        // Each its own bag and latch (/var/lib is root's); the unit's networks stand in the installed files; the launch
        // argument chose the advance.
        let own = |line: &&str| {
            !["bag_dir: ", "latch_file: ", "models.", "advance.source: "]
                .iter()
                .any(|key| line.starts_with(key))
        };
        let [ours, theirs] =
            [meaning(&unit(node, &etc)), meaning(process)].map(|[node, program, namespace, remaps, text]| {
                (
                    node,
                    program,
                    namespace,
                    remaps,
                    text.lines().filter(own).map(str::to_owned).collect::<Vec<_>>(),
                )
            });
        assert_eq!(ours, theirs);
        assert!(process["respawn"] == true && process["ends_all"] == false, "{node}");
        // The printer is heard once somebody guards it.
        let wanted: &[&str] = if node == "printer_bridge" { &["safety_supervisor"] } else { &[] };
        assert_eq!(
            (start_after(process), start_after(&unit(node, &etc))),
            (to_owned(wanted), to_owned(wanted))
        );
        if node == "safety_supervisor" {
            let [.., text] = meaning(&unit(node, &etc));
            assert!(text.contains(r#"latch_file: "/var/lib/fdm_loop/"#), "the unit's own folder: {text}");
        }
    }
    assert_eq!(target.matches("fdm_loop@").count(), launched.len());
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn the_camera_of_a_printer_is_an_argument() {
    let bag = std::env::temp_dir().join(format!("fdm_launch_camera_{}", std::process::id()));
    let argument = format!("bag:={}", bag.display());
    let url = "camera_source:=http://octopi.local:8080/?action=stream";
    let nodes =
        processes(&launched("monitor", &[&argument, "latch_file:=/tmp/l.json", "camera:=mjpeg", url]));
    let camera = nodes.iter().map(meaning).find(|[node, ..]| node == "camera").unwrap();
    for line in
        ["driver: \"mjpeg\"", "mjpeg.url: \"http://octopi.local:8080/?action=stream\"", "use_sim_time: false"]
    {
        assert!(camera[4].contains(line), "{line} in {}", camera[4]);
    }
    _ = std::fs::remove_dir_all(format!("{}_logs", bag.display()));
}

#[test]
fn a_replay_is_fdm_play_with_the_clock() {
    let bag = std::env::temp_dir().join(format!("fdm_launch_replay_{}", std::process::id()));
    std::fs::create_dir_all(&bag).unwrap();
    std::fs::write(bag.join("metadata.yaml"), "").unwrap();
    let argument = format!("bag:={}", bag.display());
    let replay = processes(&launched("replay", &[&argument, "rate:=2.5"]));
    assert_eq!(replay[0]["program"], binaries().join("fdm").to_str().unwrap());
    let words =
        serde_json::json!(["play", bag, "--clock", "--rate", "2.5", "--start", "0.0", "--times", "1"]);
    assert_eq!((replay.len(), &replay[0]["arguments"]), (1, &words));
    assert_eq!(replay[0]["ends_all"], true);
    // With the brains only inputs are played: nobody says a second time what a brain says.
    let brains = processes(&launched("replay", &[&argument, "brains:=true", "control:=encoder"]));
    let (player, nodes) = brains.split_last().unwrap();
    assert!(player["arguments"].as_array().unwrap().contains(&"--inputs".into()), "{player}");
    assert_eq!(nodes.len(), 4);
    let help = Command::new(binaries().join("fdm")).args(["play", "--help"]).output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    for word in player["arguments"].as_array().unwrap().iter().filter_map(Value::as_str) {
        assert!(!word.starts_with("--") || help.contains(&format!("{word} ")), "{word} in {help}");
    }
    for node in nodes.iter().map(meaning) {
        assert!(node[4].contains("use_sim_time: true"), "{node:?}");
        assert!(node[0] != "mpc_controller" || node[4].contains("control: \"encoder\""), "{node:?}");
    }
    std::fs::remove_dir_all(bag).unwrap();
}

/// Without multicast on `lo` twelve processes see each other: ten nodes and `fdm` as ever, an eleventh where it is asked
/// for, and no more.
#[test]
fn the_predictor_is_started_where_it_is_asked_for_alone() {
    let folder = std::env::temp_dir().join(format!("fdm_launch_advance_{}", std::process::id()));
    let bag = folder.join("bag");
    let nodes = |advance: &[&str]| {
        let up = Command::new(binaries().join("fdm"))
            .current_dir(root())
            .args(["up", "--gcode", GCODE, "--bag", bag.to_str().unwrap(), "--dry-run"])
            .args(advance)
            .output()
            .unwrap();
        processes(&up)[0].as_array().unwrap().iter().map(meaning).collect::<Vec<_>>()
    };
    let source = |nodes: &[[String; 5]], name: &str| {
        let controller = nodes.iter().find(|[node, ..]| node == "mpc_controller").unwrap();
        controller[4].contains(&format!("advance.source: \"{name}\""))
    };
    let usual = nodes(&[]);
    assert_eq!(usual.len(), 10);
    assert!(usual.iter().all(|[node, ..]| node != "advance_predictor") && source(&usual, "planned"));
    let predicted = nodes(&["--advance", "predicted"]);
    assert_eq!(predicted.len(), 11);
    assert_eq!(predicted.iter().filter(|[node, ..]| node == "advance_predictor").count(), 1);
    assert!(source(&predicted, "predicted"));
}

#[test]
fn what_is_wrong_is_told_before_anything_starts() {
    let gcode = format!("gcode:={GCODE}");
    for (file, arguments, said) in [
        ("sim", &[][..], "'gcode' was not provided"),
        ("sim", &["gcode:=none.gcode"], "gcode:=none.gcode: no such file"),
        ("sim", &[&gcode, "control:=perhaps"], "control:=perhaps is not one of"),
        ("sim", &[&gcode, "bag:=config"], "the folder is there and not empty"),
        ("sim", &[&gcode, "scenario:=nope"], "scenario:=nope: no such file; there are "),
        (
            "sim",
            &[&gcode, "scenario:=/nope/mine.yaml"],
            "scenario:=/nope/mine.yaml: no such file; there are ",
        ),
        ("sim", &[&gcode, "material:=wood"], "material:=wood: there are abs, petg, pla"),
        (
            "sim",
            &[&gcode, "bag:=/tmp/fdm_never", "bin:=/tmp"],
            "build all programs with `cargo build --release",
        ),
        (
            "sim",
            &[&gcode, "bag:=/tmp/fdm_never", "speed:=abc"],
            "speed:=abc: must be a number in [0.1, 20.0]",
        ),
        ("sim", &[&gcode, "speed:=2", "host_clock:=true"], "speed:=2 beside host_clock:=true: must be 1"),
        ("sim", &[&gcode, "bag:=/tmp/fdm_never", "seed:=1.5"], "seed:=1.5: must be a whole number in [0, "),
        ("sim", &[&gcode, "namespace:=left"], "namespace:=left: begins with no /: write /left"),
        ("replay", &["bag:=config", "namespace:=/a b/1"], "begins with no digit: write /a_b/_1"),
        ("monitor", &["camera:=video"], "a driver of its own needs a source"),
        ("replay", &["bag:=config"], "no bag (metadata.yaml is missing)"),
        ("replay", &["bag:=config", "brains:=perhaps"], "brains:=perhaps is not one of"),
    ] {
        let output = launched(file, arguments);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && text.contains(said), "{arguments:?}: {text}");
    }
    assert!(!Path::new("/tmp/fdm_never_logs").exists(), "nothing is left of what was not started");
}
