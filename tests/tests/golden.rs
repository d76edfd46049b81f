//! Golden vectors: reference values computed apart from this code, each with its own tolerance.
//!
//! Every `*.json` of the folder that `GOLDEN_DIR` names (default: `tests/data/golden`) is read. A function that is not
//! known here is reported by name and count; where its system is built, that is a failure.

#![cfg(test)]

mod golden {
    pub(crate) mod advance;
    pub(crate) mod control;
    pub(crate) mod estimation;
    pub(crate) mod hybrid;
    pub(crate) mod physics;
    pub(crate) mod safety;
    pub(crate) mod vector;
    pub(crate) mod wire;
}

use std::collections::BTreeMap;
use std::path::PathBuf;

use golden::vector::{Handler, Outcome, Set, check};
use golden::{advance, control, estimation, hybrid, physics, safety, wire};
use serde_json::json;

/// Systems whose every function must be known.
const BUILT: [&str; 4] = ["s1_closed_loop", "s2_advance", "s3_metal_wire", "s4_hybrid_machine"];

fn handler(system: &str, function: &str) -> Option<Handler> {
    match system {
        "s1_closed_loop" => physics::handler(function)
            .or_else(|| estimation::handler(function))
            .or_else(|| control::handler(function))
            .or_else(|| safety::handler(function)),
        "s2_advance" => advance::handler(function),
        "s3_metal_wire" => wire::handler(function),
        "s4_hybrid_machine" => hybrid::handler(function),
        _ => None,
    }
}

fn folder() -> PathBuf {
    std::env::var_os("GOLDEN_DIR")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/golden"), PathBuf::from)
}

fn sets() -> Result<Vec<Set>, String> {
    let folder = folder();
    let listing = std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut paths: Vec<PathBuf> = listing
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()
        .map_err(|error| format!("{}: {error}", folder.display()))?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "json"));
    paths.sort();
    paths.iter().map(|path| Set::read(path)).collect()
}

/// What became of the vectors.
#[derive(Default)]
struct Tally {
    passed: BTreeMap<String, usize>,
    pending: BTreeMap<String, usize>,
    failures: Vec<String>,
}

impl Tally {
    fn take(&mut self, set: &Set) {
        for vector in &set.vectors {
            let name = format!("{}: {}", set.system, vector.function);
            let outcome = match handler(&set.system, &vector.function) {
                Some(handler) => check(set, vector, handler),
                None if BUILT.contains(&set.system.as_str()) => {
                    Outcome::Failed("the system is built, but its function is not known here".into())
                }
                None => Outcome::Pending,
            };
            match outcome {
                Outcome::Passed => *self.passed.entry(name).or_default() += 1,
                Outcome::Pending => *self.pending.entry(name).or_default() += 1,
                Outcome::Failed(reason) => {
                    self.failures.push(format!("{}: {}: {reason}", set.path.display(), vector.id));
                }
            }
        }
    }
}

#[test]
fn every_vector_of_a_built_system_is_met() {
    let mut tally = Tally::default();
    for set in sets().unwrap() {
        tally.take(&set);
    }
    for (name, count) in &tally.passed {
        println!("passed   {count:3}  {name}");
    }
    for (name, count) in &tally.pending {
        println!("pending  {count:3}  {name} (its system is not built yet)");
    }
    assert!(tally.failures.is_empty(), "{} failures:\n{}", tally.failures.len(), tally.failures.join("\n"));
    assert!(!tally.passed.is_empty(), "no vector in {} was checked", folder().display());
}

/// The judge itself: a wrong figure, a missing one, and an unknown function of a built system must not pass.
#[test]
fn a_wrong_a_missing_and_an_unknown_figure_fail() {
    let set = |function: &str, expected: serde_json::Value| {
        Set::parse(
            "made-up".into(),
            json!({"system": "s1_closed_loop", "vectors": [{
                "id": "x-1", "function": function, "inputs": {"t_bond_s": 1.0, "tau_s": 1.0},
                "expected": expected, "tol": {"rel": 1e-6, "abs": 1e-12},
            }]}),
        )
        .unwrap()
    };
    let failures = |set: &Set| {
        let mut tally = Tally::default();
        tally.take(set);
        tally.failures.len()
    };
    assert_eq!(failures(&set("adhesion", json!({"alpha": 0.632_120_558_828_557_7}))), 0);
    assert_eq!(failures(&set("adhesion", json!({"alpha": 0.632_119}))), 1);
    assert_eq!(failures(&set("adhesion", json!({"alpha": [0.632_120_558_828_557_7]}))), 1);
    assert_eq!(failures(&set("adhesion", json!({"alpha": null}))), 1);
    assert_eq!(failures(&set("adhesion", json!({"beta": 0.5}))), 1);
    assert_eq!(failures(&set("adhesion", json!({}))), 1);
    assert_eq!(failures(&set("no_such_function", json!({"alpha": 0.5}))), 1);
}
