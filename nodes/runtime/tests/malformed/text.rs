//! Parameter files and arguments: whatever a person, a bad disk or a script has left in them.

use proptest::prelude::*;
use runtime::Args;
use runtime::params::{NodePath, Parameters};
use serde_json::Value;
use std::path::PathBuf;

use crate::storm::{Mutation, payloads};

/// A file that goes with its test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(test: &str) -> Self {
        Self(std::env::temp_dir().join(format!("runtime_malformed_{test}_{}.yaml", std::process::id())))
    }

    /// Reads what stands in the file as any node would, and says whether it was taken.
    fn read(&self, bytes: &[u8]) -> bool {
        std::fs::write(&self.0, bytes).unwrap();
        let path = NodePath { qualified: "/printer/thermistor".to_owned(), base: "thermistor".to_owned() };
        let read = Parameters::read(std::slice::from_ref(&self.0), &[], &path);
        read.and_then(|parameters| parameters.parse::<Value>()).inspect(has_only_numbers).is_ok()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        _ = std::fs::remove_file(&self.0);
    }
}

/// JSON has no NaN: one that got through would show as null.
fn has_only_numbers(value: &Value) {
    match value {
        Value::Array(values) => values.iter().for_each(has_only_numbers),
        Value::Object(values) => values.values().for_each(has_only_numbers),
        Value::Number(number) => assert!(number.as_f64().is_some_and(f64::is_finite)),
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

/// T5: a parameter file that was flipped, cut or overwritten is read or refused with a reason.
#[test]
fn parameter_files() {
    let sound = include_bytes!("../../../../config/thermistor.param.yaml");
    let scratch = Scratch::new("files");
    assert!(scratch.read(sound));
    let number = payloads() / 10;
    let taken = (0..number).filter(|number| scratch.read(&Mutation::new(*number).apply(sound))).count();
    println!("parameter files: {taken} of {number} taken");
    assert!(taken < usize::try_from(number).unwrap());
}

/// Depth and repetition cost no stack and no memory beyond the file's own size.
#[test]
fn parameter_files_made_to_exhaust_the_reader() {
    let scratch = Scratch::new("deep");
    let head = "/**:\n  ros__parameters:\n    a: ";
    assert!(!scratch.read(format!("{head}{}", "[".repeat(100_000)).as_bytes()));
    assert!(!scratch.read(format!("{head}{}{}", "[".repeat(20_000), "]".repeat(20_000)).as_bytes()));
    assert!(!scratch.read(format!("{head}{}", "{a: ".repeat(100_000)).as_bytes()));
    let mut laughs = format!("{head}&x0 [0, 0]\n");
    for level in 1..40 {
        laughs += &format!("    a{level}: &x{level} [*x{0}, *x{0}]\n", level - 1);
    }
    assert!(!scratch.read(laughs.as_bytes()), "2^40 values");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Any words: taken apart without a loss, or refused.
    #[test]
    fn arguments(words in prop::collection::vec(
        "(--ros-args|--|-r|-p|--remap|--param|--params-file|--log-level|[a-z_/]{0,4}:=[^ ]{0,6}|__ns:=/[a-z]{0,3}|debug|.{0,6})", 0..12
    )) {
        let total = words.len();
        if let Ok(args) = Args::parse(words) {
            let kept = args.rest.len() + args.remaps.len() + args.parameters.len() + args.params_files.len();
            prop_assert!(kept <= total);
        }
    }
}
