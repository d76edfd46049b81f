//! Every number that a node takes has an allowed range: the comment beside it says it, and the code holds it.

use super::*;
use crate::up::recipes::NODES;
use printer_sim::run_params::RunParams;
use runtime::FrameParams;
use runtime::params::ParamFileError;
use serde::de::IgnoredAny;
use serde_json::Value;

/// Numbers whose range stands in the files alone: the simulated printer checks the host that it is, and takes its room as it is
/// told.
const SAID: [&str; 3] = ["plant.ambient_temp_k", "simulator.moonraker.", "simulator.octoprint."];

/// Far outside of every range, also of a seed's.
const FAR: [&str; 2] = ["1e19", "-1e19"];

/// A set of files that a node may be started with.
struct Start {
    node: &'static str,
    wire: bool,
    files: Vec<PathBuf>,
}

/// All sets that are shipped: of every node, of materials and hosts what differs, and of a wire machine.
fn starts(config: &ConfigDir) -> Vec<Start> {
    let mut all = Vec::new();
    for node in NODES.into_iter().chain(["printer_bridge"]) {
        all.push(Start { node, wire: false, files: config.files_of(node, "pla") });
    }
    for material in config.names_in("materials") {
        let files = vec![config.file(&format!("materials/{material}.yaml"))];
        all.push(Start { node: "material", wire: false, files });
    }
    let looped: &[&str] = &["state_estimator", "mpc_controller", "safety_supervisor"];
    for (host, nodes) in [("moonraker", looped), ("octoprint", looped), ("marlin", &["safety_supervisor"])] {
        for &node in nodes {
            let mut files = config.files_of(node, "pla");
            files.push(config.file(&format!("hosts/{host}.param.yaml")));
            all.push(Start { node, wire: false, files });
        }
    }
    for (node, files) in crate::wire::up::FILES {
        all.push(Start { node, wire: true, files: files.iter().map(|file| config.file(file)).collect() });
    }
    all
}

fn config() -> ConfigDir {
    ConfigDir::find(Some(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config"))).unwrap()
}

fn read(start: &Start, files: &[PathBuf], overrides: &[(String, String)]) -> Parameters {
    let path = NodePath { qualified: format!("/printer/{}", start.node), base: start.node.to_owned() };
    Parameters::read(files, overrides, &path).unwrap()
}

/// Names of the numbers and of the lists of numbers, each with how many there are.
fn numbers(parameters: &Parameters) -> Vec<(String, Option<usize>)> {
    let text = parameters.text();
    let pairs = text.lines().filter_map(|line| line.split_once(": "));
    pairs
        .filter_map(|(name, value)| match serde_json::from_str(value).ok()? {
            Value::Number(_) => Some((name.to_owned(), None)),
            Value::Array(list) if !list.is_empty() && list.iter().all(Value::is_number) => {
                Some((name.to_owned(), Some(list.len())))
            }
            _ => None,
        })
        .collect()
}

/// A value in place of each number of a parameter.
fn all_of(value: &str, count: Option<usize>) -> String {
    count.map_or_else(|| value.to_owned(), |count| format!("[{}]", vec![value; count].join(", ")))
}

/// Parses all parameters as the node does.
fn check(start: &Start, parameters: &Parameters) -> Result<(), ParamFileError> {
    let nominal = ["printer", "material", "quality", "advance_physics"];
    let own = parameters.without(&nominal);
    if start.wire {
        let own = own.without(&["wire_controller", "wire_process"]);
        return match start.node {
            "safety_supervisor" => own.parse::<safety_supervisor::Params>().map(drop),
            "mpc_controller" => {
                _ = own.parse::<mpc_controller::wire::LoopParams>()?;
                _ = parameters.block::<models::wire::Process>("wire_process")?;
                parameters.block::<mpc_controller::wire::Params>("wire_controller").map(drop)
            }
            _ => printer_sim::load::wall::machine_params(parameters).map(drop),
        };
    }
    _ = parameters.optional::<Printer>("printer")?;
    _ = parameters.optional::<Material>("material")?;
    _ = parameters.optional::<models::quality::Quality>("quality")?;
    match start.node {
        "thermistor" => own.parse::<thermistor::Params>().map(drop),
        "imu" => own.parse::<imu::Params>().map(drop),
        "camera" => own.parse::<camera::Params>().map(drop),
        "filament_encoder" => own.parse::<filament_encoder::Params>().map(drop),
        "state_estimator" => own.parse::<state_estimator::Params>().map(drop),
        "mpc_controller" => own.parse::<mpc_controller::Params>().map(drop),
        "safety_supervisor" => own.parse::<safety_supervisor::Params>().map(drop),
        "bag_recorder" => own.parse::<bag_recorder::params::Params>().map(drop),
        "printer_bridge" => {
            _ = parameters.block::<FrameParams>("frames")?;
            own.without(&["frames"]).parse::<printer_bridge::Params>().map(drop)
        }
        "defect_classifier" => own.parse::<defect_classifier::Params>().map(drop),
        "advance_predictor" => {
            _ = parameters.block::<models::advance::Physics>("advance_physics")?;
            own.parse::<advance_predictor::Params>().map(drop)
        }
        "printer_sim" => {
            _ = parameters.block::<RunParams>("run")?;
            _ = parameters.block::<FrameParams>("frames")?;
            printer_sim::load::check(parameters)
        }
        "material" => Ok(()),
        other => panic!("{other} has no check here"),
    }
}

/// What is far outside is refused with name, value, unit and range: there is no number without.
#[test]
fn every_number_of_every_node_is_refused_far_outside_with_unit_and_range() {
    let config = config();
    let (mut refused, mut open) = (0, std::collections::BTreeSet::new());
    for start in starts(&config) {
        for (name, count) in numbers(&read(&start, &start.files, &[])) {
            for far in FAR {
                let changed = [(name.clone(), all_of(far, count))];
                let answer = read(&start, &start.files, &changed).parse::<IgnoredAny>();
                let said = answer.err().map(|error| error.to_string()).unwrap_or_default();
                let index = if count.is_some() { "[0]" } else { "" };
                let (place, value) = (format!(": {name}{index} = {far} "), ": must be in [");
                match said.split_once(&place).and_then(|(_, rest)| rest.split_once(value)) {
                    Some((unit, _)) if !unit.is_empty() => refused += 1,
                    _ => _ = open.insert(format!("{} {name}: {said}", start.node)),
                }
            }
        }
    }
    assert_eq!(open, std::collections::BTreeSet::new());
    assert!(refused > 2000, "{refused}");
}

/// A file without comments does not open what ours says: the code holds its ranges alone.
#[test]
fn every_number_of_every_node_is_refused_far_outside_by_the_code_alone() {
    let config = config();
    let folder = std::env::temp_dir().join(format!("fdm_bare_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mut open = std::collections::BTreeSet::new();
    for start in starts(&config) {
        let bare = |(at, file): (usize, &PathBuf)| {
            let text = std::fs::read_to_string(file).unwrap();
            let lines = text.lines().map(|line| line.split_once(" #").map_or(line, |(value, _)| value));
            let file = folder.join(format!("{at}.yaml"));
            std::fs::write(&file, lines.collect::<Vec<_>>().join("\n")).unwrap();
            file
        };
        let files: Vec<_> = start.files.iter().enumerate().map(bare).collect();
        let shipped = read(&start, &files, &[]);
        check(&start, &shipped).unwrap();
        let held = |name: &str| !SAID.iter().any(|said| name.starts_with(said));
        for (name, count) in numbers(&shipped).into_iter().filter(|(name, _)| held(name)) {
            for far in FAR {
                let changed = [(name.clone(), all_of(far, count))];
                if check(&start, &read(&start, &files, &changed)).is_ok() {
                    open.insert(format!("{} {name} = {far}", start.node));
                }
            }
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
    assert_eq!(open, std::collections::BTreeSet::new());
}
