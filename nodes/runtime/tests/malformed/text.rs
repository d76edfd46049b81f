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

    /// Reads what stands in the file as any node would, and says whether it was taken; who refuses it names it, and why.
    fn read(&self, bytes: &[u8]) -> bool {
        std::fs::write(&self.0, bytes).unwrap();
        let path = NodePath { qualified: "/printer/thermistor".to_owned(), base: "thermistor".to_owned() };
        let read = Parameters::read(std::slice::from_ref(&self.0), &[], &path);
        let Err(error) = read.and_then(|parameters| parameters.parse::<Value>()) else { return true };
        let told = error.to_string();
        let reason = told.strip_prefix(&self.0.display().to_string()).unwrap_or_default();
        assert!(reason.trim_start_matches([':', ' ']).len() > 5 && told.lines().count() == 1, "{told:?}");
        false
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        _ = std::fs::remove_file(&self.0);
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
    let parts = format!("/**:\n  ros__parameters:\n    {}a: 1\n", "a.".repeat(500_000));
    assert!(!scratch.read(parts.as_bytes()), "a name of 500000 parts");
    let mut laughs = format!("{head}&x0 [0, 0]\n");
    for level in 1..40 {
        laughs += &format!("    a{level}: &x{level} [*x{0}, *x{0}]\n", level - 1);
    }
    assert!(!scratch.read(laughs.as_bytes()), "2^40 values");
}

/// Numbers that are not finite are refused wherever they stand: JSON, in which values go on, would have nothing for them.
#[test]
fn parameter_files_with_numbers_that_are_none() {
    let scratch = Scratch::new("nan");
    let head = "/**:\n  ros__parameters:\n    a: ";
    for word in [".nan", ".NaN", ".inf", "-.inf", "[1.0, .nan]", "{b: .inf}", "[[.nan]]", "1e999"] {
        assert!(!scratch.read(format!("{head}{word}\n").as_bytes()), "{word}");
    }
    assert!(scratch.read(format!("{head}1.5\n").as_bytes()));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    /// Any words: taken apart without a loss, or refused.
    #[test]
    fn arguments(words in prop::collection::vec(
        "(--ros-args|--|-r|-p|--remap|--param|--params-file|--log-level|[a-z_/]{0,4}:=[^ ]{0,6}|__ns:=/[a-z]{0,3}|debug|.{0,6})", 0..12
    )) {
        if let Ok(args) = Args::parse(words.clone()) {
            let (mut rest, mut pairs, mut files, mut levels) = (Vec::new(), [Vec::new(), Vec::new()], Vec::new(), 0);
            let (mut ros, mut words) = (false, words.into_iter());
            while let Some(word) = words.next() {
                let pair = |text: &str| text.split_once(":=").map(|(from, to)| (from.to_owned(), to.to_owned()));
                match (ros, word.as_str()) {
                    (_, "--ros-args") => ros = true,
                    (true, "--") => ros = false,
                    (false, _) => rest.push(word),
                    (true, "-r" | "--remap") => pairs[0].extend(words.next().as_deref().and_then(pair)),
                    (true, "-p" | "--param") => pairs[1].extend(words.next().as_deref().and_then(pair)),
                    (true, "--params-file") => files.extend(words.next().map(PathBuf::from)),
                    (true, "--log-level") => levels += usize::from(words.next().is_some()),
                    (true, other) => prop_assert!(false, "'{other}' was taken"),
                }
            }
            let own = |(from, _): &&(String, String)| from == "__ns";
            let namespace = pairs[0].iter().rfind(own).map(|(_, to)| to.clone());
            pairs[0].retain(|pair| !own(&pair));
            prop_assert_eq!(args.rest, rest);
            prop_assert_eq!(args.namespace, namespace);
            prop_assert_eq!([args.remaps, args.parameters], pairs);
            prop_assert_eq!((args.params_files, args.log_levels.len()), (files, levels));
        }
    }
}
