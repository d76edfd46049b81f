//! Programs without what only a debugger reads: six sevenths of their size.

use anyhow::{Context, bail};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

/// Copies made so far by this process.
static COUNT: AtomicU32 = AtomicU32::new(0);

/// Copies of all programs of a folder; they go with it.
#[derive(Debug)]
pub(super) struct Bare(PathBuf);

impl Bare {
    /// Makes the copies with `strip`; names of functions stay, for a backtrace. What it cannot read, and all where it is
    /// not there, is copied as it is.
    ///
    /// # Errors
    /// Programs that are missing or cannot be read, a disk that is full.
    pub(super) fn of(programs: &Path) -> anyhow::Result<Self> {
        let missing: Vec<&str> =
            super::layout::programs().filter(|name| !programs.join(name).is_file()).collect();
        if !missing.is_empty() {
            bail!(
                "missing in {}: {}: build all programs with `cargo build --release --workspace --bins`",
                programs.display(),
                missing.join(", ")
            );
        }
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let bare = Self(std::env::temp_dir().join(format!("fdm_bare_{}_{number}", std::process::id())));
        std::fs::create_dir_all(&bare.0).with_context(|| bare.0.display().to_string())?;
        for name in super::layout::programs() {
            let (from, to) = (programs.join(name), bare.0.join(name));
            let mut strip = Command::new("strip");
            strip.arg("--strip-debug").arg("-o").args([&to, &from]);
            let done = strip.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status();
            if !done.is_ok_and(|status| status.success()) {
                std::fs::copy(&from, &to).with_context(|| from.display().to_string())?;
            }
        }
        Ok(bare)
    }

    /// Where the copies lie.
    pub(super) fn folder(&self) -> &Path {
        &self.0
    }
}

impl Drop for Bare {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}
