//! The functions that libFuzzer calls, with their seeds and with mutations of them: bounded, the same in every run.
//!
//! `FDM_FUZZ_CASES` multiplies the cases of a target; `FDM_FUZZ_CORPUS` names a folder to write the seeds to, for libFuzzer.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may panic and says what it did")]

use rand::rngs::StdRng;
use rand::{Rng, SeedableRng};
use std::path::PathBuf;
use system_tests::fuzz::{TARGETS, Target};

/// What breaks texts, lengths and numbers where it stands.
const TOKENS: [&[u8]; 16] = [
    b"\0",
    b"\n",
    b"\r\n",
    b" ",
    b":=",
    b"--ros-args",
    b"nan",
    b"1e999",
    b"-0",
    b"99999999999999999999",
    b"\xff\xff\xff\xff",
    b"\xff\xff\xff\x7f",
    b"\0\0\0\0\0\0\xf8\x7f",
    b"\0\0\0\0\0\0\xf0\xff",
    b"\xc3\xa9",
    b"[[[[",
];

/// One way to break sound bytes, made of a number alone so that a failure can be made again.
fn mutated(seeds: &[Vec<u8>], number: u64) -> Vec<u8> {
    let mut random = StdRng::seed_from_u64(number);
    let mut bytes = seeds[random.random_range(0..seeds.len())].clone();
    if random.random_ratio(1, 16) {
        let front: Vec<u8> = bytes.iter().take(2).copied().collect();
        bytes = front.into_iter().chain((0..random.random_range(0..200)).map(|_| random.random())).collect();
    }
    for _ in 0..random.random_range(1..6) {
        let at = random.random_range(0..=bytes.len());
        let to = (at + random.random_range(0..32)).min(bytes.len());
        match random.random_range(0..8) {
            0 => bytes.truncate(at),
            1 => _ = bytes.drain(at..to),
            2 => {
                let piece = bytes[at..to].to_vec();
                let place = random.random_range(0..=bytes.len());
                _ = bytes.splice(place..place, piece);
            }
            3 => {
                let other = &seeds[random.random_range(0..seeds.len())];
                let from = random.random_range(0..=other.len());
                bytes.truncate(at);
                bytes.extend(&other[from..]);
            }
            4 | 5 => {
                let token = TOKENS[random.random_range(0..TOKENS.len())];
                let end = if random.random() { at } else { (at + token.len()).min(bytes.len()) };
                _ = bytes.splice(at..end, token.iter().copied());
            }
            _ => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << random.random_range(0..8);
                }
            }
        }
    }
    bytes
}

/// Each seed is taken as it is, and is written out where it is asked for.
fn sow(target: &Target, seeds: &[Vec<u8>]) {
    let corpus = std::env::var_os("FDM_FUZZ_CORPUS").map(|folder| PathBuf::from(folder).join(target.name));
    for (number, seed) in seeds.iter().enumerate() {
        (target.run)(seed);
        if let Some(corpus) = &corpus {
            std::fs::create_dir_all(corpus).unwrap();
            std::fs::write(corpus.join(format!("seed_{number:03}")), seed).unwrap();
        }
    }
}

fn run(name: &str) {
    let target = TARGETS.iter().find(|target| target.name == name).unwrap();
    let seeds = (target.seeds)();
    sow(target, &seeds);
    let times = std::env::var("FDM_FUZZ_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(1_u64);
    let cases = times * u64::from(target.cases);
    for number in 0..cases {
        let bytes = mutated(&seeds, number);
        let caught = std::panic::catch_unwind(|| (target.run)(&bytes));
        assert!(caught.is_ok(), "{name}: case {number}: {:?}", String::from_utf8_lossy(&bytes));
    }
    println!("{name}: {} seeds, {cases} cases", seeds.len());
}

macro_rules! targets {
    ($($name:ident)*) => {
        $(#[test] fn $name() { run(stringify!($name)); })*

        /// A target that is in the list runs here and under libFuzzer.
        #[test]
        fn every_target_is_run_here_and_by_the_fuzzer() {
            let here = [$(stringify!($name)),*];
            let listed: Vec<&str> = TARGETS.iter().map(|target| target.name).collect();
            assert_eq!(here.to_vec(), listed);
            let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/fuzz_targets");
            let mut built: Vec<String> = std::fs::read_dir(folder)
                .unwrap()
                .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
                .collect();
            built.sort();
            assert_eq!(built, here);
            let manifest = include_str!("../fuzz/Cargo.toml");
            assert!(here.iter().all(|name| manifest.contains(&format!("name = \"{name}\""))));
        }
    };
}

targets! { arguments bag cdr gcode gcode_order jpeg parameters serial_line supervisor }
