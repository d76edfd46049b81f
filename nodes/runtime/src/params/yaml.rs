//! YAML with the line of each name.

use super::tree::{Origin, Tree};
use crate::args::{NAME_MAX, short};
use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};
use serde_saphyr::{DuplicateKeyPolicy, NonFiniteFloatPolicy, Spanned};
use std::fmt;
use std::sync::Arc;

/// Reads YAML; numbers that are not finite pass, to be refused with their name.
pub(super) fn read_yaml(text: &str) -> Result<Parsed, serde_saphyr::Error> {
    let mut options = serde_saphyr::Options::default();
    options.non_finite_float_policy = NonFiniteFloatPolicy::PassThrough;
    // A name that stands twice is refused below, in our own words.
    options.duplicate_keys = DuplicateKeyPolicy::LastWins;
    serde_saphyr::from_str_with_options(text, options)
}

/// What is wrong with the text, without the place, which stands in front already.
pub(super) fn reason(error: &serde_saphyr::Error) -> String {
    let text = error.to_string();
    let line = text.lines().next().unwrap_or_default();
    let line = line.strip_prefix("error: ").unwrap_or(line);
    match line.split_once(": ") {
        Some((place, reason)) if place.starts_with("line ") => reason.to_owned(),
        _ => line.to_owned(),
    }
}

/// YAML as read, each name with its line.
pub(super) enum Parsed {
    Block(Vec<(Spanned<String>, Self)>),
    Leaf(Value),
    /// A number that JSON has not, alone or in a list.
    NotFinite(f64),
}

impl Parsed {
    /// Gives every value its place in the file.
    pub(super) fn placed(self, file: &Arc<str>) -> Tree {
        self.convert(&|line| Origin::File(Arc::clone(file), line))
    }

    /// Gives every value the same place.
    pub(super) fn overriding(self, origin: &Origin) -> Tree {
        self.convert(&|_| origin.clone())
    }

    fn convert(self, place: &impl Fn(u64) -> Origin) -> Tree {
        match self {
            Self::Leaf(value) => Tree::Leaf(value),
            Self::NotFinite(value) => Tree::NotFinite(value),
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

    /// The value without lines, for lists; a number that is not finite is the error.
    fn into_json(self) -> Result<Value, f64> {
        match self {
            Self::Leaf(value) => Ok(value),
            Self::NotFinite(value) => Err(value),
            Self::Block(entries) => entries
                .into_iter()
                .map(|(key, child)| child.into_json().map(|value| (key.value, value)))
                .collect::<Result<Map<_, _>, _>>()
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
        Ok(Number::from_f64(value)
            .map_or(Parsed::NotFinite(value), |number| Parsed::Leaf(Value::Number(number))))
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
                Ok(value) => values.push(value),
                Err(value) => return Ok(Parsed::NotFinite(value)),
            }
        }
        Ok(Parsed::Leaf(Value::Array(values)))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Parsed, A::Error> {
        let mut entries: Vec<(Spanned<String>, Parsed)> = Vec::new();
        while let Some(key) = map.next_key::<Spanned<String>>()? {
            // Each dot of a name is a block, and each block a step down the stack.
            if key.value.len() > NAME_MAX {
                return Err(de::Error::custom(format!(
                    "'{}': a name has 255 bytes at most",
                    short(&key.value)
                )));
            }
            if let Some((first, _)) = entries.iter().find(|(known, _)| known.value == key.value) {
                let (name, lines) = (short(&key.value), [first.referenced.line(), key.referenced.line()]);
                let reason =
                    format!("'{name}' stands twice in the same block: lines {} and {}", lines[0], lines[1]);
                return Err(de::Error::custom(reason));
            }
            entries.push((key, map.next_value()?));
        }
        Ok(Parsed::Block(entries))
    }
}
