//! T5: files that were cut off, or of which a bit was flipped. A node refuses to be configured, with the file and the exact
//! reason, or has all of the file; nothing goes on with half of one.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests: a failure is the test's failure"
)]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use system_tests::fuzz::parameters;

/// A node that is refused ends at once; what it takes is its start, of a debug binary on a busy machine.
const PATIENCE: Duration = Duration::from_secs(20);

fn config() -> PathBuf {
    std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("../config")).unwrap()
}

/// A folder that goes with its test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("fdm_corrupt_{test}_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

/// One line that begins with the file, and says something of it.
fn names(error: &str, file: &Path) {
    let reason = error.strip_prefix(&file.display().to_string());
    let said = reason.is_some_and(|reason| reason.trim_start_matches([':', ' ']).len() > 5);
    assert!(said && error.lines().count() == 1, "{error:?} of {}", file.display());
}

/// Names of the parameters that are in force, but for the places of parts that tools draw: that block need not be there,
/// and a bridge without it tells of no place.
fn in_force(text: &str) -> Vec<&str> {
    let names = text.lines().map(|line| line.split_once(": ").unwrap().0);
    names.filter(|name| !name.starts_with("frames")).collect()
}

/// Every node's own file, cut at the end of each line and in the midst of it, and with flipped bits. A digit is a digit: a
/// number that another one has become is held to its range alone, as if a person had written it. Names say more: whatever
/// is taken has all of them, and no other.
#[test]
fn no_node_takes_half_a_parameter_file() {
    let scratch = Scratch::new("parameters");
    for node in parameters::nodes() {
        let file = scratch.0.join(format!("{node}.param.yaml"));
        let sound = std::fs::read(config().join(format!("{node}.param.yaml"))).unwrap();
        std::fs::write(&file, &sound).unwrap();
        let whole = parameters::in_force(node, &file).unwrap();
        let (mut taken, mut tried) = (0, 0);
        let mut read = |bytes: &[u8], how: &str| {
            std::fs::write(&file, bytes).unwrap();
            tried += 1;
            match parameters::in_force(node, &file) {
                Err(error) => names(&error.to_string(), &file),
                Ok(found) => {
                    taken += 1;
                    assert_eq!(in_force(&found), in_force(&whole), "{node}, {how}");
                }
            }
        };
        let ends = sound.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(place, _)| place + 1);
        let mut begin = 0;
        for end in ends {
            for cut in [begin + (end - begin) / 3, end - 1] {
                read(&sound[..cut], &format!("cut to {cut} bytes"));
            }
            begin = end;
        }
        for bit in (0..sound.len() * 8).step_by(191) {
            let mut bytes = sound.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            read(&bytes, &format!("bit {} of byte {} flipped", bit % 8, bit / 8));
        }
        println!("{node}: {taken} of {tried} taken, each with all its names");
    }
}

/// What is done to a file.
#[derive(Debug, Clone, Copy)]
enum Damage {
    /// Only so many bytes of a hundred are left.
    Cut(usize),
    /// The lowest bit of the digit behind a word.
    Flipped(&'static str),
}

impl Damage {
    fn apply(self, sound: &str) -> Vec<u8> {
        let mut bytes = sound.as_bytes().to_vec();
        match self {
            Self::Cut(percent) => bytes.truncate(sound.len() * percent / 100),
            Self::Flipped(word) => {
                let from = sound.find(word).unwrap() + word.len();
                let digit = from + sound[from..].find(|c: char| c.is_ascii_digit()).unwrap();
                bytes[digit] ^= 1;
            }
        }
        bytes
    }
}

/// Starts a node in a domain of the test's own; its exit code and what it said.
fn started(node: &str, files: &[PathBuf], overrides: &[String]) -> (Option<i32>, String) {
    let deps = std::env::current_exe().unwrap();
    let program = deps.parent().and_then(Path::parent).unwrap().join(node);
    assert!(program.is_file(), "{} is missing: cargo build --workspace --bins", program.display());
    let mut command = Command::new(program);
    command.arg("--ros-args").env("ROS_DOMAIN_ID", system_tests::own_domain(0)).env_remove("RUST_LOG");
    files.iter().for_each(|file| _ = command.arg("--params-file").arg(file));
    overrides.iter().for_each(|value| _ = command.args(["-p", value]));
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let begin = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begin.elapsed() > PATIENCE {
            _ = child.kill();
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let output = child.wait_with_output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Node, its other files, and which of them or of its models is damaged how.
type Case = (&'static str, &'static [&'static str], &'static str, Option<&'static str>);

const SHARED: &[&str] = &["printers/ender3.yaml", "materials/pla.yaml"];
const SEEN: &[&str] = &["quality.yaml", "printers/ender3.yaml", "materials/pla.yaml"];
const PHYSICS: &[&str] = &["advance/physics.yaml"];

/// The file of each that is damaged, and the parameter that names it where it is a model.
const CASES: [Case; 9] = [
    ("thermistor", &[], "thermistor.param.yaml", None),
    ("safety_supervisor", &[], "safety_supervisor.param.yaml", None),
    ("state_estimator", SHARED, "printers/ender3.yaml", None),
    ("mpc_controller", SHARED, "materials/pla.yaml", None),
    ("defect_classifier", SEEN, "quality.yaml", None),
    ("defect_classifier", SEEN, "models/toolhead.json", Some("models.network")),
    ("defect_classifier", SEEN, "models/road_edge.json", Some("models.edge")),
    ("advance_predictor", PHYSICS, "models/turn.json", Some("models.turn")),
    ("advance_predictor", PHYSICS, "models/advance_bowden.json", Some("models.bowden")),
];

/// Processes, as `fdm up`, a launch file and systemd start them: code 2, the file, and why, before anything is published.
#[test]
fn a_corrupt_file_is_refused_by_its_node_with_file_and_reason() {
    let scratch = Scratch::new("nodes");
    for (node, shared, damaged, model) in CASES {
        let damages = match model {
            // In a file that people write, a number that became another one is theirs; a name is not.
            None => vec![Damage::Cut(20), Damage::Cut(37), Damage::Cut(80)],
            Some(_) => {
                let digits =
                    [Damage::Flipped("weights"), Damage::Flipped("bias"), Damage::Flipped("trained")];
                let digits = digits.into_iter().filter(|_| !damaged.contains("edge"));
                let edge = [Damage::Flipped("hidden\""), Damage::Flipped("contrast_min")];
                let edge = edge.into_iter().filter(|_| damaged.contains("edge"));
                [Damage::Cut(0), Damage::Cut(50)].into_iter().chain(digits).chain(edge).collect()
            }
        };
        let sound = std::fs::read_to_string(config().join(damaged)).unwrap();
        let file = scratch.0.join(Path::new(damaged).file_name().unwrap());
        let own = format!("{node}.param.yaml");
        let files = [own.as_str()].into_iter().chain(shared.iter().copied());
        let files: Vec<PathBuf> =
            files.map(|name| if name == damaged { file.clone() } else { config().join(name) }).collect();
        let mut overrides = models(node);
        overrides.extend(model.map(|name| format!("{name}:={:?}", file)));
        for damage in damages {
            std::fs::write(&file, damage.apply(&sound)).unwrap();
            let (code, said) = started(node, &files, &overrides);
            println!("{node}, {damaged} {damage:?}: {said}");
            assert_eq!(code, Some(2), "{node}, {damaged} {damage:?}: {said}");
            let at = said.find(&file.display().to_string());
            let at = at.unwrap_or_else(|| panic!("{node}, {damaged} {damage:?} names no file: {said}"));
            names(said[at..].trim_end().lines().next().unwrap(), &file);
        }
    }
}

/// Where the sound models of a node stand, whatever folder the test runs in.
fn models(node: &str) -> Vec<String> {
    let named: &[(&str, &str)] = match node {
        "defect_classifier" => &[("network", "toolhead.json"), ("edge", "road_edge.json")],
        "advance_predictor" => {
            &[("turn", "turn.json"), ("direct", "advance_direct.json"), ("bowden", "advance_bowden.json")]
        }
        _ => &[],
    };
    let path =
        |(name, file): &(&str, &str)| format!("models.{name}:={:?}", config().join("models").join(file));
    named.iter().map(path).collect()
}
