//! A tree of parameters that remembers where each value stands.

use super::yaml::{Parsed, read_yaml, reason};
use super::{NodePath, ParamFileError, join};
use crate::args::{of_node, one_line, short};
use serde_json::{Map, Value};
use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// Where a value stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Origin {
    /// File and line from 1.
    File(Arc<str>, u64),
    /// The option `-p name:=value`.
    Override(String),
    /// A request while the node runs.
    Request,
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(file, line) => write!(f, "{file}:{line}"),
            Self::Override(name) => write!(f, "-p {name}"),
            Self::Request => f.write_str("as asked"),
        }
    }
}

/// A block of named values, or a value.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Tree {
    /// Named values in the order of the file.
    Block(Vec<(String, Self, Origin)>),
    /// A scalar or a list.
    Leaf(Value),
    /// A number that JSON has not, alone or in a list: `.nan` or `.inf`.
    NotFinite(f64),
}

impl Default for Tree {
    fn default() -> Self {
        Self::Block(Vec::new())
    }
}

impl Tree {
    /// Takes a value of the root block out.
    pub(super) fn take(&mut self, name: &str) -> Option<(Self, Origin)> {
        let Self::Block(entries) = self else { return None };
        let at = entries.iter().position(|(key, ..)| key == name)?;
        let (_, tree, origin) = entries.remove(at);
        Some((tree, origin))
    }

    /// Value and place of a dotted path; list indices end it.
    pub(super) fn get(&self, path: &str) -> Option<(&Self, &Origin)> {
        let (first, rest) = path.split_once('.').map_or((path, None), |(first, rest)| (first, Some(rest)));
        let first = first.split('[').next().unwrap_or(first);
        let Self::Block(entries) = self else { return None };
        let (_, tree, origin) = entries.iter().find(|(key, ..)| key == first)?;
        match (rest, tree) {
            (Some(rest), Self::Block(_)) => tree.get(rest),
            (Some(_), _) => None,
            (None, _) => Some((tree, origin)),
        }
    }

    /// Place of a dotted path.
    pub(super) fn origin(&self, path: &str) -> Option<&Origin> {
        self.get(path).map(|(_, origin)| origin)
    }

    /// The value as text, where it is one.
    pub(super) fn leaf_text(&self) -> Option<String> {
        match self {
            Self::Leaf(value) => Some(value.to_string()),
            Self::NotFinite(value) => Some(value.to_string()),
            Self::Block(_) => None,
        }
    }

    /// The tree without its places.
    pub(super) fn to_json(&self) -> Value {
        match self {
            Self::Leaf(value) => value.clone(),
            Self::NotFinite(_) => Value::Null,
            Self::Block(entries) => Value::Object(
                entries.iter().map(|(key, tree, _)| (key.clone(), tree.to_json())).collect::<Map<_, _>>(),
            ),
        }
    }

    /// `path: value` of every leaf.
    pub(super) fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        self.collect_lines("", &mut lines);
        lines
    }

    /// Dotted names of all values.
    pub(super) fn leaves(&self) -> Vec<String> {
        let Self::Block(entries) = self else { return Vec::new() };
        let below = |(key, tree, _): &(String, Self, Origin)| match tree {
            Self::Block(_) => tree.leaves().iter().map(|name| join(key, name)).collect(),
            Self::Leaf(_) | Self::NotFinite(_) => vec![key.clone()],
        };
        entries.iter().flat_map(below).collect()
    }

    fn collect_lines(&self, path: &str, lines: &mut Vec<String>) {
        match self {
            Self::Block(entries) => {
                for (key, tree, _) in entries {
                    tree.collect_lines(&join(path, key), lines);
                }
            }
            // A name may hold a line end, which would begin a line of its own.
            leaf => lines.extend(leaf.leaf_text().map(|text| format!("{}: {text}", one_line(path)))),
        }
    }

    /// Sets a dotted path: blocks are merged, values replaced.
    pub(super) fn set(&mut self, path: &str, value: Self, origin: Origin) {
        let (first, rest) = path.split_once('.').map_or((path, None), |(first, rest)| (first, Some(rest)));
        if !matches!(self, Self::Block(_)) {
            *self = Self::default();
        }
        let Self::Block(entries) = self else { return };
        let at = entries.iter().position(|(key, ..)| key == first).unwrap_or_else(|| {
            entries.push((first.to_owned(), Self::default(), origin.clone()));
            entries.len() - 1
        });
        let (_, slot, place) = &mut entries[at];
        match (rest, value) {
            (Some(rest), value) => slot.set(rest, value, origin),
            (None, Self::Block(children)) => {
                if !matches!(slot, Self::Block(_)) {
                    *slot = Self::default();
                }
                *place = origin;
                for (key, child, origin) in children {
                    slot.set(&key, child, origin);
                }
            }
            (None, leaf) => {
                *slot = leaf;
                *place = origin;
            }
        }
    }
}

/// Merges the blocks of a file that are meant for `node`, and tells whether it says anything of it.
pub(super) fn merge_file(
    merged: &mut Tree,
    text: &str,
    file: &Path,
    node: &NodePath,
) -> Result<bool, ParamFileError> {
    let Some(root) = root_of(text, file)? else { return Ok(false) };
    let name: Arc<str> = Arc::from(file.display().to_string());
    merge_nodes(merged, &root, "", &Target { file: &name, node })
}

/// What a file says, each value with its place; `None` for an empty one, which holds no parameters.
pub(super) fn root_of(text: &str, file: &Path) -> Result<Option<Tree>, ParamFileError> {
    let name: Arc<str> = Arc::from(file.display().to_string());
    if text.lines().all(|line| line.trim().is_empty() || line.trim_start().starts_with('#')) {
        return Ok(None);
    }
    let parsed: Parsed = read_yaml(text).map_err(|error| {
        let line = error.location().map_or(1, |location| location.line());
        ParamFileError::Malformed { at: format!("{name}:{line}"), reason: reason(&error) }
    })?;
    Ok(Some(parsed.placed(&name)))
}

/// Whom a file is read for.
struct Target<'a> {
    file: &'a Arc<str>,
    node: &'a NodePath,
}

/// Walks node names down to their `ros__parameters`.
fn merge_nodes(
    merged: &mut Tree,
    tree: &Tree,
    path: &str,
    target: &Target<'_>,
) -> Result<bool, ParamFileError> {
    let malformed = |line: &str, reason: &str| ParamFileError::Malformed {
        at: line.to_owned(),
        reason: format!(
            "{reason}; expected '<node>:' or '/**:', then 'ros__parameters:', then names and values"
        ),
    };
    let Tree::Block(entries) = tree else {
        return Err(malformed(target.file, "not a ROS 2 parameter file"));
    };
    let mut said = false;
    for (key, child, origin) in entries {
        match (key.as_str(), child) {
            ("ros__parameters", Tree::Block(parameters)) if !path.is_empty() => {
                if is_meant(path, target.node) {
                    said |= !parameters.is_empty();
                    for (name, value, origin) in parameters {
                        merged.set(name, value.clone(), origin.clone());
                    }
                }
            }
            // `ros__parameters:` with nothing below
            ("ros__parameters", Tree::Leaf(Value::Null)) if !path.is_empty() => {}
            (_, Tree::Block(_)) if key != "ros__parameters" => {
                // A name alone is that of a node, what stands above another name that of its namespace.
                let path = match path {
                    "" => key.clone(),
                    above => format!("/{}/{}", above.trim_matches('/'), key.trim_start_matches('/')),
                };
                said |= merge_nodes(merged, child, &path, target)?;
            }
            _ => {
                return Err(malformed(
                    &origin.to_string(),
                    &format!("'{key}' stands outside of ros__parameters"),
                ));
            }
        }
    }
    Ok(said)
}

/// Whether a block's node name fits: `name`, `/ns/name`, with `*` for one part and `**` for any number of them.
fn is_meant(pattern: &str, node: &NodePath) -> bool {
    let parts = |name: &str| name.trim_matches('/').split('/').map(str::to_owned).collect::<Vec<_>>();
    pattern == node.base || fits(&parts(pattern), &parts(&node.qualified))
}

fn fits(pattern: &[String], name: &[String]) -> bool {
    match (pattern, name) {
        ([], []) => true,
        ([any, rest @ ..], _) if any == "**" => {
            fits(rest, name) || name.split_first().is_some_and(|(_, name)| fits(pattern, name))
        }
        ([one, rest @ ..], [part, parts @ ..]) => (one == "*" || one == part) && fits(rest, parts),
        _ => false,
    }
}

/// Merges `-p name:=value`; the value is YAML. With a node's name in front, as in a file, it is for that one alone.
pub(super) fn merge_override(
    merged: &mut Tree,
    (name, value): (&str, &str),
    node: &NodePath,
) -> Result<(), ParamFileError> {
    let origin = Origin::Override(short(&format!("{name}:={value}")));
    let Some(name) = of_node(name, |pattern| is_meant(pattern, node)) else { return Ok(()) };
    if name.is_empty() || name.contains(':') {
        let reason = "expected name:=value or node:name:=value".to_owned();
        return Err(ParamFileError::Malformed { at: origin.to_string(), reason });
    }
    let tree = if value.is_empty() {
        Tree::Leaf(Value::String(String::new()))
    } else {
        let parsed: Parsed = read_yaml(value)
            .map_err(|error| ParamFileError::Malformed { at: origin.to_string(), reason: reason(&error) })?;
        parsed.overriding(&origin)
    };
    merged.set(name, tree, origin);
    Ok(())
}
