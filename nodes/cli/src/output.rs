//! The one writer of the command: text for people, JSON for programs, progress on standard error.

use anyhow::Context;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes a line, or several, to standard output.
///
/// # Errors
/// A closed pipe.
pub fn line(text: &str) -> anyhow::Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.trim_end().as_bytes())?;
    out.write_all(b"\n")?;
    Ok(())
}

/// A progress bar on standard error; nothing where that is no terminal.
#[must_use]
pub fn bar(length: u64, unit: &str) -> ProgressBar {
    let bar = ProgressBar::new(length);
    let template = format!("{{bar:40}} {{pos}}/{{len}} {unit}, {{elapsed}} of about {{duration}} {{msg}}");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    bar
}

/// Where figures for programs go.
#[derive(Debug, Clone)]
pub struct Json(Option<PathBuf>);

impl Json {
    /// `None`: nowhere; `-`: standard output.
    #[must_use]
    pub fn new(path: Option<&Path>) -> Self {
        Self(path.map(Path::to_path_buf))
    }

    /// Standard output belongs to the figures alone.
    #[must_use]
    pub fn is_stdout(&self) -> bool {
        self.0.as_deref() == Some(Path::new("-"))
    }

    /// Tells before long work that its figures could not be written.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn check(&self) -> anyhow::Result<()> {
        self.0.as_deref().filter(|_| !self.is_stdout()).map_or(Ok(()), check_writable)
    }

    /// Writes one object.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write<T: Serialize>(&self, figures: &T) -> anyhow::Result<()> {
        let Some(path) = &self.0 else { return Ok(()) };
        let text = serde_json::to_string_pretty(figures)?;
        if self.is_stdout() {
            line(&text)
        } else {
            std::fs::write(path, text + "\n").with_context(|| path.display().to_string())
        }
    }
}

/// Tells before long work that a file could not be written.
///
/// # Errors
/// The file, and what the system says.
pub fn check_writable(path: &Path) -> anyhow::Result<()> {
    let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
    file.map(drop).with_context(|| path.display().to_string())
}

/// One line on standard error: what is wrong, where, and why.
pub fn complain(error: &anyhow::Error) {
    // A closed standard error leaves nobody to tell.
    _ = writeln!(std::io::stderr().lock(), "fdm: {error:#}");
}

/// One line on standard error: what happens meanwhile.
pub fn note(text: &str) {
    _ = writeln!(std::io::stderr().lock(), "{text}");
}
