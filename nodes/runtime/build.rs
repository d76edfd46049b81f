//! Puts the commit into the build, where there is one: a source archive builds without.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // In a worktree `.git` is a file: a path that is not there would build everything again each time.
    for (folder, watched) in [("--absolute-git-dir", "HEAD"), ("--git-common-dir", "refs/heads")] {
        if let Some(folder) = git(&["rev-parse", "--path-format=absolute", folder]) {
            println!("cargo::rerun-if-changed={folder}/{watched}");
        }
    }
    let commit = git(&["rev-parse", "--short=12", "HEAD"]);
    println!("cargo::rustc-env=FDM_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
}

/// First line of what git says, where it is there and has something to say.
fn git(arguments: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
