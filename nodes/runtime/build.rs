//! Puts the commit into the build, where there is one: a source archive builds without.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    for path in watched() {
        println!("cargo::rerun-if-changed={path}");
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"]);
    println!("cargo::rustc-env=FDM_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
}

/// What says which commit this checkout is at, and changes with no other one: several worktrees share their refs.
fn watched() -> Vec<String> {
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    let loose = branch.as_deref().and_then(file);
    // A branch that is packed gets a file of its own with its next commit, which the log of HEAD tells.
    let packed = if branch.is_some() && loose.is_none() { &["packed-refs", "logs/HEAD"][..] } else { &[] };
    file("HEAD").into_iter().chain(loose).chain(packed.iter().filter_map(|name| file(name))).collect()
}

/// Path of a file of git's: in a worktree some are its own and some are shared. A path that is not there would build
/// everything again each time.
fn file(name: &str) -> Option<String> {
    git(&["rev-parse", "--path-format=absolute", "--git-path", name]).filter(|path| Path::new(path).is_file())
}

/// First line of what git says, where it is there and has something to say.
fn git(arguments: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
