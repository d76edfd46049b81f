//! The one writer of the command: text for people, JSON for programs, progress on standard error.

mod of_bag;
mod together;

pub use together::write_all_whole;

use anyhow::{Context, bail};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::ffi::OsString;
use std::io::Write;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::MetadataExt;
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

/// The command did what was asked, and what came of it is not as it should be: exit code 1, where a mistake of the one who
/// asks is 2.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Failed(pub String);

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
    /// A file that cannot be written, or that the command line names as something else too.
    pub fn check(&self) -> anyhow::Result<()> {
        let file = self.0.as_deref().filter(|_| !self.is_stdout());
        file.map_or(Ok(()), |file| check_writable("--json", file))
    }

    /// Writes one object.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write<T: Serialize>(&self, figures: &T) -> anyhow::Result<()> {
        let Some(path) = &self.0 else { return Ok(()) };
        self.check()?;
        let text = serde_json::to_string_pretty(figures)?;
        if self.is_stdout() { line(&text) } else { write_whole(path, &(text + "\n")) }
    }
}

/// Writes a file so that an older one of its name stands until the new one is whole: a disk may be full. What is no plain
/// file is written to as it is.
///
/// # Errors
/// A file that cannot be written, or is one of a bag.
pub fn write_whole(path: &Path, text: &str) -> anyhow::Result<()> {
    of_bag::check(path)?;
    let told = || path.display().to_string();
    if std::fs::symlink_metadata(path).is_ok_and(|found| !found.is_file()) {
        return std::fs::write(path, text).with_context(told);
    }
    let half_made = beside(path, "part");
    let written = std::fs::write(&half_made, text).and_then(|()| std::fs::rename(&half_made, path));
    if written.is_err() {
        _ = std::fs::remove_file(&half_made);
    }
    written.with_context(told)
}

/// Where a file is written before it has its name, and kept until all of them have theirs.
fn beside(path: &Path, what: &str) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.{what}", std::process::id()));
    path.with_file_name(name)
}

/// Refuses an output that this command line names a second time, as an input or as another output.
///
/// # Errors
/// The file under both names.
pub fn check_named_once(output: &Path) -> anyhow::Result<()> {
    let files: Vec<PathBuf> =
        others(output, std::env::args_os().skip(1)).into_iter().filter(|path| path.is_file()).collect();
    check_apart(output, &files)
}

/// What arguments name beside one mention of `output`: words, and values behind `--name=`.
fn others(output: &Path, arguments: impl Iterator<Item = OsString>) -> Vec<PathBuf> {
    let value = |word: OsString| {
        let bytes = word.as_bytes();
        let behind = bytes.iter().position(|byte| *byte == b'=').filter(|_| bytes.starts_with(b"--"));
        behind.map_or_else(
            || PathBuf::from(&word),
            |at| PathBuf::from(std::ffi::OsStr::from_bytes(&bytes[at + 1..])),
        )
    };
    let mut words: Vec<PathBuf> = arguments.map(value).collect();
    if let Some(own) = words.iter().position(|word| word == output) {
        words.remove(own);
    }
    words
}

/// Refuses an output that is one of `inputs`, under whatever name, or lies in a folder among them, or is a file of any bag.
///
/// # Errors
/// The output and the input.
pub fn check_apart(output: &Path, inputs: &[PathBuf]) -> anyhow::Result<()> {
    let identity = |path: &Path| std::fs::metadata(path).ok().map(|found| (found.dev(), found.ino()));
    let whole = std::fs::canonicalize(output).ok().or_else(|| {
        let absolute = std::path::absolute(output).ok()?;
        Some(std::fs::canonicalize(absolute.parent()?).ok()?.join(absolute.file_name()?))
    });
    let parts: Vec<_> = whole.iter().flat_map(|path| path.ancestors()).filter_map(identity).collect();
    match inputs.iter().find(|input| identity(input).is_some_and(|input| parts.contains(&input))) {
        None => of_bag::check(output),
        Some(input) if input.is_dir() => {
            bail!("{} lies in {}, which is read: choose another file", output.display(), input.display())
        }
        Some(input) => {
            let (output, input) = (output.display(), input.display());
            bail!("{output} would replace {input}, which this command names as well: choose another file")
        }
    }
}

/// Tells before long work that the file that `option` names could not be written, or that it is an input.
///
/// # Errors
/// Option and file, and what the system says; a file that the command line names as something else too.
pub fn check_writable(option: &str, path: &Path) -> anyhow::Result<()> {
    check_named_once(path)?;
    let told = || format!("{option} {}", path.display());
    let is_new = !path.exists();
    let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
    file.map(drop).with_context(told)?;
    // Whoever interrupts the work finds no empty file; a link that leads nowhere stays one.
    match is_new {
        true => std::fs::canonicalize(path).and_then(std::fs::remove_file).with_context(told),
        false => Ok(()),
    }
}

/// Whether who reads the output has gone, as `head` does after ten lines: nothing is wrong with the command.
#[must_use]
pub fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let closed = |cause: &std::io::Error| cause.kind() == std::io::ErrorKind::BrokenPipe;
    error.downcast_ref::<std::io::Error>().is_some_and(closed)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("fdm-output-{name}-{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(folder.join("bag")).unwrap();
        std::fs::write(folder.join("bag/a.mcap"), "x").unwrap();
        std::fs::write(folder.join("other"), "x").unwrap();
        folder
    }

    /// By its name, by a detour, through a link of either kind, in a folder that is read; what stands beside is free.
    #[test]
    fn an_output_that_is_read_is_refused_under_any_name() {
        let folder = folder("apart");
        let (bag, file) = (folder.join("bag"), folder.join("bag/a.mcap"));
        std::os::unix::fs::symlink(&file, folder.join("soft")).unwrap();
        std::os::unix::fs::symlink(&bag, folder.join("door")).unwrap();
        std::fs::hard_link(&file, folder.join("hard")).unwrap();
        let clashes = |output: &str, input: &Path| {
            check_apart(&folder.join(output), &[folder.join("other"), input.to_path_buf()]).is_err()
        };
        for output in ["bag/a.mcap", "bag/../bag/a.mcap", "soft", "hard", "door/a.mcap"] {
            assert!(clashes(output, &file), "{output}");
        }
        for output in ["bag/new.html", "bag/a.mcap", "soft", "door/new.html"] {
            assert!(clashes(output, &bag), "{output}");
        }
        assert!(!clashes("bag/new.html", &file) && !clashes("new.html", &bag) && !clashes("bag.html", &bag));
        assert_eq!(std::fs::read(&file).unwrap(), b"x");
        std::fs::remove_dir_all(folder).unwrap();
    }

    /// What is asked before the work leaves nothing behind, should the work be interrupted, and changes nothing.
    #[test]
    fn a_check_leaves_no_file() {
        let folder = folder("check");
        let (new, link, old) = (folder.join("new.json"), folder.join("link.json"), folder.join("other"));
        std::os::unix::fs::symlink(folder.join("target.json"), &link).unwrap();
        let names = || {
            let entries = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name());
            entries.collect::<std::collections::BTreeSet<_>>()
        };
        let before = names();
        for path in [&new, &link, &old] {
            check_writable("--json", path).unwrap();
        }
        assert_eq!(names(), before);
        assert!(std::fs::read(&old).unwrap() == b"x" && link.is_symlink());
        let nowhere = folder.join("nowhere/new.json");
        let told = check_writable("--json", &nowhere).unwrap_err().to_string();
        assert_eq!(told, format!("--json {}", nowhere.display()));
        std::fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_file_named_twice_is_found_among_the_arguments() {
        let words = |line: &str| others(Path::new("a.stl"), line.split(' ').map(OsString::from)).len();
        let named = |line: &str| {
            others(Path::new("a.stl"), line.split(' ').map(OsString::from)).contains(&PathBuf::from("a.stl"))
        };
        assert!(named("map --stl a.stl --json a.stl") && named("map --stl=a.stl --json=a.stl"));
        assert!(!named("map --stl b.stl --json a.stl") && !named("map --stl b.stl --json=a.stl"));
        assert_eq!(words("map --stl b.stl --json a.stl"), 4);
    }
}
