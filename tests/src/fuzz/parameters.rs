//! Parameter files, read and checked as the node that they are of does at its start.

use super::laws::{is_finite, is_one_line};
use super::shipped;
use runtime::{ParamFileError, Parameters};
use serde::de::DeserializeOwned;
use std::fmt::Debug;
use std::path::{Path, PathBuf};

/// A node, and what checks its parameters.
type Check = fn(&Parameters) -> Result<(), ParamFileError>;

const NODES: [(&str, Check); 10] = [
    ("thermistor", |read| parsed::<thermistor::Params>(read)),
    ("filament_encoder", |read| parsed::<filament_encoder::Params>(read)),
    ("imu", |read| parsed::<imu::Params>(read)),
    ("camera", |read| parsed::<camera::Params>(read)),
    ("state_estimator", |read| parsed::<state_estimator::Params>(&read.without(&["printer", "material"]))),
    ("mpc_controller", |read| parsed::<mpc_controller::Params>(&read.without(&["printer", "material"]))),
    ("advance_predictor", |read| parsed::<advance_predictor::Params>(&read.without(&["advance_physics"]))),
    ("safety_supervisor", |read| parsed::<safety_supervisor::Params>(&read.without(&["latch_file"]))),
    ("printer_bridge", |read| parsed::<printer_bridge::Params>(&read.without(&["frames"]))),
    ("bag_recorder", |read| parsed::<bag_recorder::params::Params>(read)),
];

fn parsed<T: DeserializeOwned + Debug>(read: &Parameters) -> Result<(), ParamFileError> {
    read.parse::<T>().map(|params| is_finite(&params))
}

/// The first byte says of which node the file is.
pub fn parameters(bytes: &[u8]) {
    let Some((node, text)) = bytes.split_first() else { return };
    let (name, check) = NODES[usize::from(*node) % NODES.len()];
    let file = file();
    std::fs::write(&file, text).unwrap();
    let read = || Parameters::read(std::slice::from_ref(&file), &[], &shipped::node(name));
    match read() {
        Err(error) => is_one_line(&error.to_string()),
        Ok(found) => {
            assert_eq!(found.sha256(), read().unwrap().sha256(), "read twice");
            if let Err(error) = check(&found) {
                is_one_line(&error.to_string());
            }
            _ = found.undescribed();
        }
    }
}

/// Every node whose parameters are checked here.
pub fn nodes() -> impl Iterator<Item = &'static str> {
    NODES.iter().map(|(name, _)| *name)
}

/// What is in force after a node has read and checked a file at its start: a line for each value.
///
/// # Errors
/// As the node itself would say it.
pub fn in_force(name: &str, file: &Path) -> Result<String, ParamFileError> {
    let found = Parameters::read(&[file.to_path_buf()], &[], &shipped::node(name))?;
    let checks = NODES.iter().filter(|(node, _)| *node == name).map(|(_, check)| check(&found));
    checks.collect::<Result<(), _>>()?;
    Ok(found.text())
}

/// A file of this thread alone.
fn file() -> PathBuf {
    let thread = format!("{:?}", std::thread::current().id());
    std::env::temp_dir().join(format!("fuzz_parameters_{}_{thread}.yaml", std::process::id()))
}

/// The shipped files, each of which its node takes.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let seed = |(index, (name, check)): (usize, &(&str, Check))| {
        check(&shipped::parameters(name)).unwrap();
        [
            vec![u8::try_from(index).unwrap()],
            std::fs::read(shipped::file(&format!("{name}.param.yaml"))).unwrap(),
        ]
        .concat()
    };
    NODES.iter().enumerate().map(seed).collect()
}
