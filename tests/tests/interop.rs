//! An independent DDS, PyPI `cyclonedds`, in place of the ROS tools: messages, services, lifecycle, parameters, and what
//! a graph bears. The checks stand in `tests/interop/`; here they are started, in a domain of the test's own.
//!
//! `FDM_INTEROP_ROUNDS` runs all of them so many times in a row.
#![allow(clippy::unwrap_used, reason = "helpers of tests: a failure is the test's failure")]

#[path = "interop/mirror.rs"]
mod mirror;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Set in the process that mirrors messages: the domain is read from the environment.
const ROLE: &str = "FDM_INTEROP_ROLE";

fn root() -> PathBuf {
    std::fs::canonicalize(Path::new(env!("CARGO_MANIFEST_DIR")).join("..")).unwrap()
}

/// Folder of the node binaries.
fn binaries() -> PathBuf {
    std::env::current_exe().unwrap().parent().and_then(Path::parent).unwrap().to_owned()
}

fn rounds() -> u32 {
    std::env::var("FDM_INTEROP_ROUNDS").map_or(1, |rounds| rounds.parse().unwrap())
}

fn python() -> PathBuf {
    let python = root().join("target/venv/bin/python");
    assert!(python.is_file(), "{} is missing: run launch_scripts/test.sh once", python.display());
    python
}

fn run(script: &str, domain: &str) -> Output {
    Command::new(python())
        .arg(root().join("tests/interop").join(script))
        .arg(binaries())
        .arg(domain)
        .env("FDM_INTEROP_MIRROR", std::env::current_exe().unwrap())
        .env_remove("RUST_LOG")
        .output()
        .unwrap()
}

/// Every check of the scripts holds, as often as is asked for. One after another: a domain of a host without multicast
/// has room for twelve processes.
#[test]
fn an_independent_dds_and_our_nodes_understand_each_other() {
    if std::env::var_os(ROLE).is_some() {
        mirror::run();
        return;
    }
    let domain = system_tests::own_domain(0);
    for round in 1..=rounds() {
        for script in [
            "messages.py",
            "rates.py",
            "user.py",
            "order.py",
            "clients.py",
            "recorder.py",
            "frames.py",
            "peers.py",
        ] {
            let output = run(script, &domain);
            let said = String::from_utf8_lossy(&output.stdout);
            println!("round {round}, {script}:\n{said}");
            let errors = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{script} in round {round}:\n{said}{errors}");
        }
    }
}
