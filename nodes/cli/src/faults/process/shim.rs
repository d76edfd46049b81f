//! A graph whose disk and wall clock are in our hand: a small library between the nodes and the system (`shim.c`).

use crate::up::fleet::Recipe;
use anyhow::{Context, bail};
use rustix::io::Errno;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Source of the library.
const SOURCE: &str = include_str!("shim.c");
/// Names the file by which it is told what to do.
const CONTROL: &str = "FDM_SHIM";
/// Numbers in that file.
const NUMBERS: usize = 3;
/// Nanoseconds in a second.
const NANOS_PER_S: f64 = 1e9;

/// The library and what it is told.
pub(super) struct Shim {
    library: PathBuf,
    control: PathBuf,
    file: File,
}

impl Shim {
    /// Builds it; a C compiler links the nodes as well.
    pub(super) fn build(folder: &Path) -> anyhow::Result<Self> {
        let (source, library) = (folder.join("shim.c"), folder.join("shim.so"));
        let control = folder.join("shim");
        std::fs::write(&source, SOURCE).with_context(|| source.display().to_string())?;
        std::fs::write(&control, [0; 8 * NUMBERS]).with_context(|| control.display().to_string())?;
        let mut compiler = Command::new("cc");
        compiler.args(["-O1", "-shared", "-fPIC", "-o"]).arg(&library).arg(&source);
        let built = compiler.output().context("cc: a C compiler is needed for these trials")?;
        if !built.status.success() {
            bail!("cc: {}", String::from_utf8_lossy(&built.stderr));
        }
        let file = File::options().write(true).open(&control)?;
        Ok(Self { library, control, file })
    }

    /// Puts it between a node and the system.
    pub(super) fn wrap(&self, recipe: &mut Recipe) {
        let program = std::mem::replace(&mut recipe.program, PathBuf::from("/usr/bin/env"));
        let words = [
            format!("LD_PRELOAD={}", self.library.display()),
            format!("{CONTROL}={}", self.control.display()),
            program.display().to_string(),
        ];
        recipe.arguments.splice(0..0, words);
    }

    /// Sets the wall clock of all nodes so far from the host's `[s]`.
    pub(super) fn set_wall(&self, offset_s: f64) -> anyhow::Result<()> {
        self.tell(0, offset_s * NANOS_PER_S)
    }

    /// Each write and sync of the recorder takes so long `[s]`.
    pub(super) fn set_delay(&self, delay_s: f64) -> anyhow::Result<()> {
        self.tell(1, delay_s * NANOS_PER_S)
    }

    /// What the recorder's disk answers to each write; `None`: it writes.
    pub(super) fn set_error(&self, error: Option<Errno>) -> anyhow::Result<()> {
        self.tell(2, error.map_or(0.0, |error| f64::from(error.raw_os_error())))
    }

    fn tell(&self, number: u64, value: f64) -> anyhow::Result<()> {
        #[allow(clippy::cast_possible_truncation, reason = "hours in nanoseconds")]
        let bytes = (value as i64).to_ne_bytes();
        Ok(self.file.write_all_at(&bytes, 8 * number)?)
    }
}
