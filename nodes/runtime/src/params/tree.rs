//! A tree of parameters that remembers where each value stands.

use super::{NodePath, ParamFileError, join};
use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};
use serde_saphyr::{NonFiniteFloatPolicy, Spanned};
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
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(file, line) => write!(f, "{file}:{line}"),
            Self::Override(name) => write!(f, "-p {name}"),
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
    /// A number that JSON has not: `.nan` or `.inf`.
    NotFinite,
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
            Self::NotFinite => Some("not finite".to_owned()),
            Self::Block(_) => None,
        }
    }

    /// First value that is not finite, with its path.
    pub(super) fn not_finite(&self) -> Option<(String, &Origin)> {
        let Self::Block(entries) = self else { return None };
        entries.iter().find_map(|(key, tree, origin)| match tree {
            Self::NotFinite => Some((key.clone(), origin)),
            _ => tree.not_finite().map(|(path, origin)| (join(key, &path), origin)),
        })
    }

    /// The tree without its places.
    pub(super) fn to_json(&self) -> Value {
        match self {
            Self::Leaf(value) => value.clone(),
            Self::NotFinite => Value::Null,
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

    fn collect_lines(&self, path: &str, lines: &mut Vec<String>) {
        match self {
            Self::Block(entries) => {
                for (key, tree, _) in entries {
                    tree.collect_lines(&join(path, key), lines);
                }
            }
            leaf => lines.extend(leaf.leaf_text().map(|text| format!("{path}: {text}"))),
        }
    }

    /// Sets a dotted path: blocks are merged, values replaced.
    fn set(&mut self, path: &str, value: Self, origin: Origin) {
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

/// Merges the blocks of a file that are meant for `node`.
pub(super) fn merge_file(
    merged: &mut Tree,
    text: &str,
    file: &Path,
    node: &NodePath,
) -> Result<(), ParamFileError> {
    let name: Arc<str> = Arc::from(file.display().to_string());
    // An empty file holds no parameters.
    if text.lines().all(|line| line.trim().is_empty() || line.trim_start().starts_with('#')) {
        return Ok(());
    }
    let parsed: Parsed = read_yaml(text).map_err(|error| {
        let line = error.location().map_or(1, |location| location.line());
        ParamFileError::Malformed { at: format!("{name}:{line}"), reason: reason(&error) }
    })?;
    let root = parsed.placed(&name);
    merge_nodes(merged, &root, "", &Target { file: &name, node })
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
) -> Result<(), ParamFileError> {
    let malformed = |line: &str, reason: &str| ParamFileError::Malformed {
        at: line.to_owned(),
        reason: format!(
            "{reason}; expected '<node>:' or '/**:', then 'ros__parameters:', then names and values"
        ),
    };
    let Tree::Block(entries) = tree else {
        return Err(malformed(target.file, "not a ROS 2 parameter file"));
    };
    for (key, child, origin) in entries {
        match (key.as_str(), child) {
            ("ros__parameters", Tree::Block(parameters)) if !path.is_empty() => {
                if is_meant(path, target.node) {
                    for (name, value, origin) in parameters {
                        merged.set(name, value.clone(), origin.clone());
                    }
                }
            }
            // `ros__parameters:` with nothing below
            ("ros__parameters", Tree::Leaf(Value::Null)) if !path.is_empty() => {}
            (_, Tree::Block(_)) if key != "ros__parameters" => {
                let path = format!("{}/{}", path.trim_end_matches('/'), key.trim_start_matches('/'));
                let path =
                    if key.starts_with('/') || path.matches('/').count() > 1 { path } else { key.clone() };
                merge_nodes(merged, child, &path, target)?;
            }
            _ => {
                return Err(malformed(
                    &origin.to_string(),
                    &format!("'{key}' stands outside of ros__parameters"),
                ));
            }
        }
    }
    Ok(())
}

/// Whether a block's node name fits: `/**`, `name`, `/ns/name`, `/**/name`.
fn is_meant(pattern: &str, node: &NodePath) -> bool {
    match pattern {
        "/**" => true,
        _ => match pattern.strip_prefix("/**/") {
            Some(base) => base == node.base,
            None => pattern == node.base || pattern == node.qualified,
        },
    }
}

/// Merges `-p name:=value`; the value is YAML.
pub(super) fn merge_override(merged: &mut Tree, name: &str, value: &str) -> Result<(), ParamFileError> {
    let origin = Origin::Override(format!("{name}:={value}"));
    let tree = if value.is_empty() {
        Tree::Leaf(Value::String(String::new()))
    } else {
        let parsed: Parsed = read_yaml(value)
            .map_err(|error| ParamFileError::Malformed { at: origin.to_string(), reason: reason(&error) })?;
        parsed.overriding(&origin)
    };
    // A node's name in front, as `ros2 run` allows, is not needed: one node a process.
    merged.set(name, tree, origin);
    Ok(())
}

/// Reads YAML; numbers that are not finite pass, to be refused with their name.
fn read_yaml(text: &str) -> Result<Parsed, serde_saphyr::Error> {
    let mut options = serde_saphyr::Options::default();
    options.non_finite_float_policy = NonFiniteFloatPolicy::PassThrough;
    serde_saphyr::from_str_with_options(text, options)
}

/// What is wrong with the text, without the place, which stands in front already.
fn reason(error: &serde_saphyr::Error) -> String {
    let text = error.to_string();
    let line = text.lines().next().unwrap_or_default();
    let line = line.strip_prefix("error: ").unwrap_or(line);
    match line.split_once(": ") {
        Some((place, reason)) if place.starts_with("line ") => reason.to_owned(),
        _ => line.to_owned(),
    }
}

/// YAML as read, each name with its line.
enum Parsed {
    Block(Vec<(Spanned<String>, Self)>),
    Leaf(Value),
    NotFinite,
}

impl Parsed {
    /// Gives every value its place in the file.
    fn placed(self, file: &Arc<str>) -> Tree {
        self.convert(&|line| Origin::File(Arc::clone(file), line))
    }

    /// Gives every value the same place.
    fn overriding(self, origin: &Origin) -> Tree {
        self.convert(&|_| origin.clone())
    }

    fn convert(self, place: &impl Fn(u64) -> Origin) -> Tree {
        match self {
            Self::Leaf(value) => Tree::Leaf(value),
            Self::NotFinite => Tree::NotFinite,
            Self::Block(entries) => Tree::Block(
                entries
                    .into_iter()
                    .map(|(key, child)| {
                        let origin = place(key.referenced.line());
                        (key.value, child.convert(place), origin)
                    })
                    .collect(),
            ),
        }
    }

    /// The value without lines, for lists; `None` where a number is not finite.
    fn into_json(self) -> Option<Value> {
        match self {
            Self::Leaf(value) => Some(value),
            Self::NotFinite => None,
            Self::Block(entries) => entries
                .into_iter()
                .map(|(key, child)| child.into_json().map(|value| (key.value, value)))
                .collect::<Option<Map<_, _>>>()
                .map(Value::Object),
        }
    }
}

impl<'de> Deserialize<'de> for Parsed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ParsedVisitor)
    }
}

struct ParsedVisitor;

impl<'de> Visitor<'de> for ParsedVisitor {
    type Value = Parsed;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value, a list or a block")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Parsed, E> {
        Ok(Parsed::Leaf(Value::Bool(value)))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Parsed, E> {
        Ok(Parsed::Leaf(Value::from(value)))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Parsed, E> {
        Ok(Parsed::Leaf(Value::from(value)))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Parsed, E> {
        Ok(Number::from_f64(value).map_or(Parsed::NotFinite, |number| Parsed::Leaf(Value::Number(number))))
    }

    fn visit_str<E>(self, value: &str) -> Result<Parsed, E> {
        Ok(Parsed::Leaf(Value::String(value.to_owned())))
    }

    fn visit_unit<E>(self) -> Result<Parsed, E> {
        Ok(Parsed::Leaf(Value::Null))
    }

    fn visit_none<E>(self) -> Result<Parsed, E> {
        Ok(Parsed::Leaf(Value::Null))
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Parsed, D::Error> {
        Parsed::deserialize(deserializer)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Parsed, A::Error> {
        let mut values = Vec::new();
        while let Some(item) = list.next_element::<Parsed>()? {
            match item.into_json() {
                Some(value) => values.push(value),
                None => return Ok(Parsed::NotFinite),
            }
        }
        Ok(Parsed::Leaf(Value::Array(values)))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Parsed, A::Error> {
        let mut entries: Vec<(Spanned<String>, Parsed)> = Vec::new();
        while let Some(key) = map.next_key::<Spanned<String>>()? {
            if entries.iter().any(|(known, _)| known.value == key.value) {
                return Err(de::Error::custom(format!("'{}' stands twice in the same block", key.value)));
            }
            entries.push((key, map.next_value()?));
        }
        Ok(Parsed::Block(entries))
    }
}
