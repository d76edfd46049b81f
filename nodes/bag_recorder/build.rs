//! Hands the git commit to the program, where there is one: a build from a source archive has none.
#![allow(clippy::print_stdout)] // how a build script speaks to cargo

use std::path::Path;
use std::process::Command;

/// Output of a git command, `None` where git or the repository is missing.
fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    (output.status.success() && !text.trim().is_empty()).then(|| text.trim().to_owned())
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // A commit moves the branch that HEAD names; a path that is not there would rebuild each time.
    for reference in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--git-path", reference])
            && Path::new(&path).exists()
        {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    if let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) {
        println!("cargo::rustc-env=FDM_LOOP_COMMIT={commit}");
    }
}
