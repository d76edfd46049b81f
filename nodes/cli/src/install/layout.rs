//! What is installed where, and with which contents.

use super::{MANIFEST, PACKAGE};
use crate::config::ConfigDir;
use crate::up::recipes::NODES;
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};

/// Programs beside those of `fdm up`: the node of a real printer, and the command.
const MORE_PROGRAMS: [&str; 2] = ["printer_bridge", "fdm"];
/// A file that `fdm up` can print at once.
const EXAMPLE: &str = "prusa_cube_pla_marlin_relE.gcode";
/// Material of the nodes that `ros2 run` starts without a parameter file.
const MATERIAL: &str = "PLA";
/// What parameter files of a clone call their networks, and what they become.
const IN_A_CLONE: &str = ": config/models/";
/// The setup file of a package, as ament calls it; one text suits all three shells.
const SETUP: &str = include_str!("local_setup.sh");

/// Names of all programs.
pub(super) fn programs() -> impl Iterator<Item = &'static str> {
    NODES.into_iter().chain(MORE_PROGRAMS)
}

/// One file below the prefix.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct File {
    /// Relative to the prefix.
    pub(super) path: PathBuf,
    /// Contents.
    pub(super) contents: Contents,
}

/// Where contents come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Contents {
    /// A copy; programs may be run.
    Copy { from: PathBuf, program: bool },
    /// A text of ours.
    Text(String),
    /// A link relative to its folder, and what it leads to.
    Link { to: PathBuf, leads_to: PathBuf },
}

impl File {
    /// The bytes of a file, of a link those that it leads to.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(super) fn bytes(&self) -> anyhow::Result<Vec<u8>> {
        match &self.contents {
            Contents::Copy { from, .. } | Contents::Link { leads_to: from, .. } => {
                std::fs::read(from).with_context(|| from.display().to_string())
            }
            Contents::Text(text) => Ok(text.clone().into_bytes()),
        }
    }
}

/// Where the texts for people stand below a prefix.
const DOC: &str = "share/doc/fdm-loop";

/// Texts for people, and what they show, as they lie in a clone.
const DOCUMENTS: [&str; 9] = [
    "README.md",
    "CHANGELOG.md",
    "LICENSE",
    "nodes/README.md",
    "nodes/cli/report.png",
    "launch_scripts/README.md",
    "launch_scripts/Containerfile",
    "launch_scripts/layouts/README.md",
    "launch_scripts/systemd/README.md",
];

/// Everything that is installed.
#[derive(Debug)]
pub(super) struct Layout(Vec<File>);

impl Layout {
    /// The layout of a clone and a folder of programs for one prefix.
    ///
    /// # Errors
    /// Programs and files that are missing.
    pub(super) fn new(source: &Path, programs: &Path, prefix: &Path) -> anyhow::Result<Self> {
        let mut layout = Self(Vec::new());
        layout.programs(programs)?;
        let share = PathBuf::from("share").join(PACKAGE);
        layout.config(&source.join("config"), &share.join("config"), prefix)?;
        layout.lists_of_files(&source.join("config"), &share.join("config"))?;
        let scripts = source.join("launch_scripts");
        layout.launch_files(&scripts, &share.join("launch"))?;
        layout.copy(&scripts.join("package.xml"), share.join("package.xml"))?;
        layout.folder(&scripts.join("layouts"), &share.join("layouts"))?;
        for folder in ["msg", "srv"] {
            layout.folder(&source.join("msgs").join(folder), &share.join("msgs").join(folder))?;
        }
        for name in ["package.xml", "CMakeLists.txt"] {
            layout.copy(&source.join("msgs").join(name), share.join("msgs").join(name))?;
        }
        let example = source.join("tests/data/gcode").join(EXAMPLE);
        layout.copy(&example, share.join("gcode").join(EXAMPLE))?;
        for shell in ["sh", "bash", "zsh"] {
            let text = SETUP.replace("@PREFIX@", &prefix.to_string_lossy());
            layout.text(share.join(format!("local_setup.{shell}")), text);
        }
        let marker = PathBuf::from("share/ament_index/resource_index/packages").join(PACKAGE);
        layout.text(marker, String::new());
        for name in DOCUMENTS {
            layout.document(&source.join(name), Path::new(DOC).join(name))?;
        }
        layout.0.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(layout)
    }

    /// Files in the order of their paths.
    pub(super) fn files(&self) -> &[File] {
        &self.0
    }

    fn programs(&mut self, folder: &Path) -> anyhow::Result<()> {
        let library = PathBuf::from("lib").join(PACKAGE);
        for name in programs() {
            let contents = Contents::Copy { from: folder.join(name), program: true };
            self.0.push(File { path: library.join(name), contents });
        }
        let (to, leads_to) = (Path::new("..").join(&library).join("fdm"), folder.join("fdm"));
        self.0.push(File { path: "bin/fdm".into(), contents: Contents::Link { to, leads_to } });
        Ok(())
    }

    /// Parameter files name networks relative to a clone: here by the path at which they will stand.
    fn config(&mut self, from: &Path, to: &Path, prefix: &Path) -> anyhow::Result<()> {
        let first = self.0.len();
        self.folder(from, to)?;
        let here = format!(": {}/", prefix.join(to).join("models").display());
        for file in &mut self.0[first..] {
            let Contents::Copy { from, .. } = &file.contents else { continue };
            if !from.to_string_lossy().ends_with(".param.yaml") {
                continue;
            }
            let text = std::fs::read_to_string(from).with_context(|| from.display().to_string())?;
            if text.contains(IN_A_CLONE) {
                file.contents = Contents::Text(text.replace(IN_A_CLONE, &here));
            }
        }
        Ok(())
    }

    /// A text for people. Its links into the clone's other folders lead to where those are installed.
    fn document(&mut self, from: &Path, path: PathBuf) -> anyhow::Result<()> {
        if path != Path::new(DOC).join("README.md") {
            return self.copy(from, path);
        }
        let text = std::fs::read_to_string(from).with_context(|| format!("{} is missing", from.display()))?;
        let text = ["config/", "msgs/"].into_iter().fold(text, |text, folder| {
            text.replace(&format!("]({folder}"), &format!("](../../{PACKAGE}/{folder}"))
        });
        self.text(path, text);
        Ok(())
    }

    /// What a node reads that is started without a parameter file, see `runtime/src/installed.rs`.
    fn lists_of_files(&mut self, from: &Path, to: &Path) -> anyhow::Result<()> {
        let config = ConfigDir::find(Some(from))?;
        for node in NODES.into_iter().chain(["printer_bridge"]) {
            let mut list = String::new();
            for file in config.files_of(node, MATERIAL) {
                let name = file.strip_prefix(from)?.display().to_string();
                list.push_str(&name);
                list.push('\n');
            }
            self.text(to.join(format!("{node}.files")), list);
        }
        Ok(())
    }

    /// A folder with all below it; neither hidden files nor what Python and editors leave behind.
    fn folder(&mut self, from: &Path, to: &Path) -> anyhow::Result<()> {
        for entry in std::fs::read_dir(from).with_context(|| from.display().to_string())? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            if name.starts_with('.') || name.ends_with('~') || name == "__pycache__" {
                continue;
            }
            let (from, to) = (entry.path(), to.join(&name));
            if entry.file_type()?.is_dir() { self.folder(&from, &to)? } else { self.copy(&from, to)? }
        }
        Ok(())
    }

    /// Launch files, what they share, and parameters of tools.
    fn launch_files(&mut self, from: &Path, to: &Path) -> anyhow::Result<()> {
        for entry in std::fs::read_dir(from).with_context(|| from.display().to_string())? {
            let name = entry?.file_name();
            if [".py", ".yaml"].iter().any(|ending| name.to_string_lossy().ends_with(ending)) {
                self.copy(&from.join(&name), to.join(&name))?;
            }
        }
        Ok(())
    }

    fn copy(&mut self, from: &Path, path: PathBuf) -> anyhow::Result<()> {
        if !from.is_file() {
            bail!("{} is missing", from.display());
        }
        self.0.push(File { path, contents: Contents::Copy { from: from.to_path_buf(), program: false } });
        Ok(())
    }

    fn text(&mut self, path: PathBuf, text: String) {
        debug_assert!(path != Path::new(MANIFEST), "the list is written last, by itself");
        self.0.push(File { path, contents: Contents::Text(text) });
    }
}
