//! `fdm install`: programs, configuration and launch files where `ros2 run` and `ros2 launch` look for them.
//!
//! ```text
//! PREFIX/bin/fdm                                                  -> ../lib/fdm_loop/fdm
//! PREFIX/lib/fdm_loop/<program>                                   what `ros2 pkg executables fdm_loop` lists
//! PREFIX/share/ament_index/resource_index/packages/fdm_loop       the marker of ament's index, empty
//! PREFIX/share/fdm_loop/{package.xml,config,launch,layouts,msgs,gcode,local_setup.*,manifest.sha256}
//! PREFIX/share/doc/fdm-loop/{README.md,CHANGELOG.md,LICENSE,nodes/README.md,launch_scripts/README.md,...}
//! ```
//! What is put there is written down with its checksum: `cd PREFIX && sha256sum -c share/fdm_loop/manifest.sha256`.
//! What is not written down there is somebody else's: it is neither replaced nor removed.

mod bare;
mod layout;
mod manifest;
mod place;

use crate::config::ConfigDir;
use crate::output::{self, Json};
use anyhow::{Context, bail};
use bare::Bare;
use clap::Args;
use layout::Layout;
use place::Target;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Name of the package.
const PACKAGE: &str = "fdm_loop";
/// List of what was installed, below the prefix.
const MANIFEST: &str = "share/fdm_loop/manifest.sha256";

/// Lays out programs, configuration and launch files so that `ros2 run` and `ros2 launch` find them.
#[derive(Debug, Args)]
pub struct InstallArgs {
    /// Folder below which bin/, lib/ and share/ are made: a new or empty one, or one that has them.
    #[arg(long)]
    pub prefix: PathBuf,
    /// Put everything below this folder in place of /, as for a package; what is written still names --prefix.
    #[arg(long)]
    pub root: Option<PathBuf>,
    /// Clone of the repository; the one that the configuration folder stands in by default.
    #[arg(long)]
    pub source: Option<PathBuf>,
    /// Folder with the programs; that of this one by default.
    #[arg(long)]
    pub programs: Option<PathBuf>,
    /// Take away what was installed; what was changed since stays.
    #[arg(long)]
    pub uninstall: bool,
    /// Replace, or take away, what was changed since it was installed.
    #[arg(long)]
    pub overwrite: bool,
    /// Say what would be done and do nothing.
    #[arg(long)]
    pub dry_run: bool,
    /// Write the list to a file, or to standard output with `-`.
    #[arg(long)]
    pub json: Option<PathBuf>,
}

/// What was done, or would be.
#[derive(Debug, Serialize)]
struct Done {
    prefix: PathBuf,
    installed: Vec<PathBuf>,
    removed: Vec<PathBuf>,
    kept: Vec<PathBuf>,
    bytes: u64,
    dry_run: bool,
}

/// Runs the command.
///
/// # Errors
/// A folder that is not ours, programs that are missing, files that cannot be written.
pub fn run(args: &InstallArgs) -> anyhow::Result<()> {
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let done = perform(args)?;
    if !json.is_stdout() {
        output::line(&said(&done, args))?;
    }
    json.write(&done)
}

/// Does what is asked, and says nothing.
fn perform(args: &InstallArgs) -> anyhow::Result<Done> {
    let prefix = checked_prefix(args)?;
    let target = Target::new(args.root.as_deref(), &prefix);
    if args.uninstall { uninstall(args, &target, prefix) } else { install(args, &target, prefix) }
}

/// The prefix as it is written into files.
fn checked_prefix(args: &InstallArgs) -> anyhow::Result<PathBuf> {
    let prefix = std::path::absolute(&args.prefix).with_context(|| args.prefix.display().to_string())?;
    let text = prefix.to_string_lossy();
    // A setup file quotes it, a list of paths is parted by colons, and a parameter file holds it as it stands.
    if let Some(bad) = text.chars().find(|c| !(c.is_alphanumeric() || "/._+-".contains(*c))) {
        bail!("--prefix {text}: must be made of letters, digits and / . _ + -, not {bad:?}");
    }
    if prefix.parent().is_none() || text.contains("/../") || text.ends_with("/..") {
        bail!("--prefix {text}: must be a folder below /, named without ..");
    }
    Ok(prefix)
}

fn install(args: &InstallArgs, target: &Target, prefix: PathBuf) -> anyhow::Result<Done> {
    let programs = Bare::of(&programs(args)?)?;
    let layout = Layout::new(&source(args)?, programs.folder(), &prefix)?;
    let installed: Vec<PathBuf> = layout.files().iter().map(|file| file.path.clone()).collect();
    let before = target.manifest()?;
    target.refuse_foreign(&layout, &before)?;
    let changed = target.changed(&before)?;
    let replaced: Vec<&PathBuf> = changed.iter().filter(|path| installed.contains(*path)).collect();
    if let (Some(first), false) = (replaced.first(), args.overwrite) {
        bail!(
            "{} files were changed since they were installed, first {}: copy what is yours elsewhere (nodes take \
             several --params-file), then --overwrite replaces them",
            replaced.len(),
            target.at(first).display()
        );
    }
    // What an earlier version brought and this one does not.
    let stale = before.paths().filter(|path| !installed.contains(path));
    let (kept, removed): (Vec<PathBuf>, Vec<PathBuf>) =
        stale.cloned().partition(|path| changed.contains(path) && !args.overwrite);
    let mut bytes = 0;
    if !args.dry_run {
        bytes = target.write(&layout)?;
        target.remove(&removed)?;
    }
    Ok(Done { prefix, installed, removed, kept, bytes, dry_run: args.dry_run })
}

fn uninstall(args: &InstallArgs, target: &Target, prefix: PathBuf) -> anyhow::Result<Done> {
    let before = target.manifest()?;
    if before.is_empty() {
        bail!("--prefix {}: nothing is installed there ({MANIFEST} is missing)", prefix.display());
    }
    let changed = if args.overwrite { Vec::new() } else { target.changed(&before)? };
    let (kept, removed): (Vec<PathBuf>, Vec<PathBuf>) =
        before.paths().cloned().partition(|path| changed.contains(path));
    if !args.dry_run {
        target.remove(&removed)?;
        // What stays is known as ours still.
        match kept.is_empty() {
            true => target.remove(&[PathBuf::from(MANIFEST)])?,
            false => target.list(&before.only(&kept))?,
        }
    }
    Ok(Done { prefix, installed: Vec::new(), removed, kept, bytes: 0, dry_run: args.dry_run })
}

/// The clone: launch files, definitions and documents stand in it beside the configuration.
fn source(args: &InstallArgs) -> anyhow::Result<PathBuf> {
    let given = match &args.source {
        Some(source) => source.clone(),
        None => ConfigDir::find(None)?.file("..").canonicalize()?,
    };
    if !given.join("launch_scripts/package.xml").is_file() {
        bail!(
            "{}: no clone of the repository (launch_scripts/package.xml is missing): give one with --source",
            given.display()
        );
    }
    Ok(given)
}

fn programs(args: &InstallArgs) -> anyhow::Result<PathBuf> {
    if let Some(programs) = &args.programs {
        return Ok(programs.clone());
    }
    let own = std::env::current_exe()?;
    Ok(own.parent().map(Path::to_path_buf).unwrap_or_default())
}

/// The result for a person.
fn said(done: &Done, args: &InstallArgs) -> String {
    let prefix = done.prefix.display();
    let would = if done.dry_run { "would be " } else { "" };
    let mut lines = Vec::new();
    if done.dry_run {
        lines.extend(done.installed.iter().map(|path| format!("+ {}", done.prefix.join(path).display())));
        lines.extend(done.removed.iter().map(|path| format!("- {}", done.prefix.join(path).display())));
    }
    if args.uninstall {
        lines.push(format!("{} files {would}removed from {prefix}", done.removed.len()));
    } else {
        let size = if done.dry_run { String::new() } else { format!(", {:.0} MB", done.bytes as f64 / 1e6) };
        lines.push(format!("{} files {would}installed to {prefix}{size}", done.installed.len()));
        lines.push(format!(". {prefix}/share/{PACKAGE}/local_setup.sh   # then: ros2 run {PACKAGE}, ros2 launch {PACKAGE}, fdm"));
    }
    lines.extend(
        done.kept.iter().map(|path| format!("kept, as it was changed: {}", done.prefix.join(path).display())),
    );
    lines.join("\n")
}

#[cfg(test)]
mod tests;
