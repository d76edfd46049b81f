//! Parameter files: several ROS 2 files merged, later wins, then `-p` overrides; parsed into a checked struct.
//!
//! ```yaml
//! /**:                       # or the node's name, or /namespace/node
//!   ros__parameters:
//!     limits:
//!       flow_max: 1.2        # nested or dotted (limits.flow_max) keys
//! ```
//! An error is one line: `config/mpc.yaml:12: limits.flow_max = 3 (no unit): must be in [1, 2]`. The range that a file
//! says of a value holds, whoever sets it; what the structs demand beside comes on top. Unknown keys are refused by them
//! (`deny_unknown_fields`). `use_sim_time` and `autostart` belong to the runtime and are taken out.
//!
//! What the six parameter services say and change stands in `params/store.rs`; a value that somebody asks for passes
//! through the same `Deserialize`.

mod addressed;
mod bounds;
mod comments;
mod own;
mod refusal;
pub(crate) mod services;
pub(crate) mod store;
mod tree;
mod values;
mod yaml;

pub use addressed::addressed;

use crate::args::ends;
use comments::Descriptions;
use own::{AUTOSTART, OWN, START_AFTER, USE_SIM_TIME, flag, names};

use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use tree::Tree;

/// Why parameters were refused; one line that says where, what and why.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ParamFileError {
    /// A file cannot be read.
    #[error("{}", ends(&format!("{}: {reason}", file.display())))]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Why not.
        reason: String,
    },
    /// Text that is not YAML, or not a ROS 2 parameter file.
    #[error("{}", ends(&format!("{at}: {reason}")))]
    Malformed {
        /// File and line, or the option `-p`.
        at: String,
        /// What is wrong.
        reason: String,
    },
    /// A value, or a set of them, was refused.
    #[error("{}", ends(&format!("{at}: {message}")))]
    Refused {
        /// File and line, or the option `-p`.
        at: String,
        /// Field, value and allowed range.
        message: String,
    },
}

/// Name of the node that files are read for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NodePath {
    /// Namespace and name: `/printer/thermistor`.
    pub qualified: String,
    /// Name alone: `thermistor`.
    pub base: String,
}

/// Parameters in force, before they are parsed into a struct.
#[derive(Debug, Clone, Default)]
pub struct Parameters {
    tree: Tree,
    descriptions: Descriptions,
    use_sim_time: bool,
    autostart: bool,
    start_after: Vec<String>,
    files: Vec<PathBuf>,
    /// Those of them that say nothing of the node, and its name.
    silent: Vec<PathBuf>,
    node: String,
}

impl Parameters {
    /// Reads `files` in order and then the overrides (`name`, YAML value); a later one wins.
    ///
    /// # Errors
    /// [`ParamFileError`] for a file that cannot be read or is no parameter file.
    pub fn read(
        files: &[PathBuf],
        overrides: &[(String, String)],
        node: &NodePath,
    ) -> Result<Self, ParamFileError> {
        let (mut merged, mut descriptions) = (Tree::default(), Descriptions::default());
        let mut silent = Vec::new();
        for file in files {
            let text = crate::input::text(file).map_err(|error| ParamFileError::Unreadable {
                file: file.clone(),
                reason: error.to_string(),
            })?;
            let said = tree::merge_file(&mut merged, &text, file, node)?;
            silent.extend((!said).then(|| file.clone()));
            descriptions.read(&file.display().to_string(), &text, &merged);
        }
        for (name, value) in overrides {
            tree::merge_override(&mut merged, (name, value), node)?;
        }
        let use_sim_time = flag(&mut merged, USE_SIM_TIME, false)?;
        let autostart = flag(&mut merged, AUTOSTART, true)?;
        let start_after = names(&mut merged, START_AFTER)?;
        let (files, node) = (files.to_vec(), node.base.clone());
        Ok(Self { tree: merged, descriptions, use_sim_time, autostart, start_after, files, silent, node })
    }

    /// Whether the node's time comes from `/clock`.
    #[must_use]
    pub fn use_sim_time(&self) -> bool {
        self.use_sim_time
    }

    /// Whether the node goes to active by itself.
    pub(crate) fn autostart(&self) -> bool {
        self.autostart
    }

    /// Nodes that have to be active before.
    pub(crate) fn start_after(&self) -> &[String] {
        &self.start_after
    }

    /// Names of the parameters of which their files say nothing.
    #[must_use]
    pub fn undescribed(&self) -> Vec<String> {
        let unsaid = |name: &String| self.descriptions.of(name).text.is_empty();
        self.tree.leaves().into_iter().filter(unsaid).collect()
    }

    /// Parses the parameters into a checked struct.
    ///
    /// # Errors
    /// [`ParamFileError::Refused`] with file, line, field, value and range.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, ParamFileError> {
        self.check_ranges()?;
        let json = self.tree.to_json();
        serde_path_to_error::deserialize(&json).map_err(|error| {
            let path = error.path().to_string();
            let path = if path == "." { String::new() } else { path };
            // It says a refused value again as a whole.
            self.explain(&path, &ends(&error.inner().to_string()))
        })
    }

    /// Parses one block of the root alone: files that several nodes share hold a block of their own.
    ///
    /// # Errors
    /// As [`Parameters::parse`]; a block that is not there is named.
    pub fn block<T: DeserializeOwned>(&self, name: &str) -> Result<T, ParamFileError> {
        let mut alone = Self { tree: Tree::default(), ..self.clone() };
        if let Some((tree, origin)) = self.tree.clone().take(name) {
            alone.tree = Tree::Block(vec![(name.to_owned(), tree, origin)]);
        }
        let mut blocks: BTreeMap<String, T> = alone.parse()?;
        blocks
            .remove(name)
            .ok_or_else(|| self.missing(name, "; a parameter file is lacking, or a name in one is misspelt"))
    }

    /// As [`Parameters::block`] for what need not be there.
    ///
    /// # Errors
    /// As [`Parameters::parse`].
    pub fn optional<T: DeserializeOwned>(&self, name: &str) -> Result<Option<T>, ParamFileError> {
        if self.tree.get(name).is_none() { Ok(None) } else { self.block(name).map(Some) }
    }

    /// The parameters without these blocks of the root.
    #[must_use]
    pub fn without(&self, names: &[&str]) -> Self {
        let mut rest = self.clone();
        for name in names {
            _ = rest.tree.take(name);
        }
        rest
    }

    /// Canonical text of what is in force: one `name: value` per line, sorted, values as JSON.
    #[must_use]
    pub fn text(&self) -> String {
        let mut lines = self.tree.lines();
        lines.push(format!("{USE_SIM_TIME}: {}", self.use_sim_time));
        lines.sort();
        lines.join("\n") + "\n"
    }

    /// SHA-256 of [`Parameters::text`], lower-case hexadecimal.
    #[must_use]
    pub fn sha256(&self) -> String {
        sha256_hex(self.text().as_bytes())
    }
}

/// Reads files and overrides and parses them in one go.
///
/// # Errors
/// As [`Parameters::read`] and [`Parameters::parse`].
pub fn load<T: DeserializeOwned>(
    files: &[PathBuf],
    overrides: &[(String, String)],
    node: &NodePath,
) -> Result<T, ParamFileError> {
    Parameters::read(files, overrides, node)?.parse()
}

/// Parses a YAML file that is no parameter file: a scenario, say.
///
/// # Errors
/// One line with file, line and reason.
pub fn from_yaml<T: DeserializeOwned>(file: &Path) -> Result<T, ParamFileError> {
    let text = crate::input::text(file).map_err(|error| ParamFileError::Unreadable {
        file: file.to_path_buf(),
        reason: error.to_string(),
    })?;
    serde_saphyr::from_str(&text).map_err(|error| {
        let at = error.location().map_or_else(
            || file.display().to_string(),
            |location| format!("{}:{}", file.display(), location.line()),
        );
        // A name that stands twice is told in our own words, with both lines.
        let twice = yaml::read_yaml(&text).err().as_ref().map(yaml::reason);
        let reason = twice.unwrap_or_else(|| {
            let reason = error.without_snippet().to_string();
            let reason = reason.lines().next().unwrap_or_default();
            // The place stands in front already.
            let place = error.location().map(|at| format!(" at line {}, column {}", at.line(), at.column()));
            place.and_then(|place| reason.strip_suffix(&place)).unwrap_or(reason).to_owned()
        });
        ParamFileError::Malformed { at, reason }
    })
}

/// SHA-256 as lower-case hexadecimal.
#[must_use]
pub fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().fold(String::with_capacity(64), |mut text, byte| {
        // Writing to a string cannot fail.
        _ = write!(text, "{byte:02x}");
        text
    })
}

/// Appends a name to a dotted path.
fn join(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

#[cfg(test)]
mod tests;
