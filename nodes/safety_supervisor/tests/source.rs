//! Independence: of `models` the supervisor uses commands, units, parameter checks and job phases alone.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::{Path, PathBuf};

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn no_model_of_plant_or_estimator_is_used() {
    let mut files = Vec::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut files);
    assert!(files.len() > 10, "the test looks into the wrong folder");
    for file in files {
        let text = fs::read_to_string(&file).unwrap();
        for (at, _) in text.match_indices("models::") {
            let rest = &text[at + "models::".len()..];
            let allowed = ["command", "units", "params", "status"];
            assert!(
                allowed.iter().any(|module| rest.starts_with(module)),
                "{}: models::{:.20}",
                file.display(),
                rest
            );
        }
    }
}
