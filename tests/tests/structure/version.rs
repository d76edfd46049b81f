//! What a build says it was built of: the build script of `runtime`, run in repositories of the tests' own.

use super::root;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Runs to the end; standard output.
fn done(folder: &Path, program: impl AsRef<std::ffi::OsStr>, words: &[&str]) -> String {
    let program = program.as_ref();
    let output = Command::new(program)
        .args(words)
        .current_dir(folder)
        .envs([("GIT_CONFIG_GLOBAL", "/dev/null"), ("GIT_CONFIG_SYSTEM", "/dev/null")])
        .envs([("GIT_AUTHOR_NAME", "a"), ("GIT_AUTHOR_EMAIL", "a@b"), ("GIT_COMMITTER_NAME", "a")])
        .env("GIT_COMMITTER_EMAIL", "a@b")
        .output()
        .unwrap();
    assert!(output.status.success(), "{program:?} {words:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// A repository with two worktrees, and the build script.
struct Checkouts {
    folder: PathBuf,
}

impl Checkouts {
    fn new() -> Self {
        let folder = std::env::temp_dir().join(format!("fdm_version_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(folder.join("main")).unwrap();
        let script = root().join("nodes/runtime/build.rs");
        let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        done(&folder, rustc, &["--edition", "2024", "-o", "script", script.to_str().unwrap()]);
        let checkouts = Self { folder };
        checkouts.git("main", &["init", "--quiet", "--initial-branch", "main"]);
        checkouts.commit("main");
        for name in ["ours", "theirs"] {
            checkouts.git("main", &["worktree", "add", "--quiet", "-b", name, &format!("../{name}")]);
        }
        checkouts
    }

    fn git(&self, checkout: &str, words: &[&str]) -> String {
        done(&self.folder.join(checkout), "git", words)
    }

    fn commit(&self, checkout: &str) {
        self.git(checkout, &["commit", "--quiet", "--allow-empty", "-m", "a"]);
    }

    /// The commit that a build of a checkout names, and the files that it watches with what is in them.
    fn built(&self, checkout: &str) -> (String, BTreeMap<PathBuf, Option<Vec<u8>>>) {
        let said = done(&self.folder.join(checkout), self.folder.join("script"), &[]);
        let commit = said.lines().find_map(|line| line.strip_prefix("cargo::rustc-env=FDM_COMMIT=")).unwrap();
        let watched = said.lines().filter_map(|line| line.strip_prefix("cargo::rerun-if-changed="));
        let watched = watched.map(PathBuf::from).filter(|path| path.is_absolute());
        (commit.to_owned(), watched.map(|path| (path.clone(), std::fs::read(path).ok())).collect())
    }
}

impl Drop for Checkouts {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// A commit is built anew, one in another worktree builds nothing; with branches that are packed as well, and without any.
#[test]
fn a_build_follows_the_commits_of_its_own_checkout_alone() {
    let checkouts = Checkouts::new();
    for state in ["loose", "packed", "detached"] {
        match state {
            "packed" => checkouts.git("main", &["pack-refs", "--all"]),
            "detached" => checkouts.git("ours", &["checkout", "--quiet", "--detach"]),
            _ => String::new(),
        };
        let (before, watched) = checkouts.built("ours");
        assert!(!watched.is_empty() && watched.values().all(Option::is_some), "{state}: {watched:?}");
        let changed = || watched.iter().any(|(path, held)| std::fs::read(path).ok() != *held);
        checkouts.commit("theirs");
        assert!(!changed(), "{state}: {:?} tell of a commit elsewhere", watched.keys());
        checkouts.commit("ours");
        assert!(changed(), "{state}: {:?} do not tell of a commit", watched.keys());
        let (after, _) = checkouts.built("ours");
        assert_ne!(before, after, "{state}");
        assert!(checkouts.git("ours", &["rev-parse", "HEAD"]).starts_with(&after), "{state}");
    }
}
