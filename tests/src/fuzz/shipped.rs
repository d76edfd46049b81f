//! Parameters as they are shipped.

use runtime::{NodePath, Parameters};
use serde::de::DeserializeOwned;
use std::path::PathBuf;

/// A file of `config/`.
pub(crate) fn file(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../config")).join(name)
}

/// What a node is called when its files are read.
pub(crate) fn node(name: &str) -> NodePath {
    NodePath { qualified: format!("/printer/{name}"), base: name.to_owned() }
}

/// A node's own file.
pub(crate) fn parameters(name: &str) -> Parameters {
    Parameters::read(&[file(&format!("{name}.param.yaml"))], &[], &node(name)).unwrap()
}

/// A block of a file that nodes share.
pub(crate) fn block<T: DeserializeOwned>(of: &str, name: &str) -> T {
    Parameters::read(&[file(of)], &[], &node("any")).unwrap().block(name).unwrap()
}

/// The files of a folder of `tests/data`, the smallest first.
pub(crate) fn data(folder: &str) -> Vec<Vec<u8>> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/data")).join(folder);
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<Vec<u8>> =
        paths.filter(|path| path.is_file()).map(|path| std::fs::read(path).unwrap()).collect();
    files.sort_by_key(|bytes| (bytes.len(), bytes.clone()));
    files
}
