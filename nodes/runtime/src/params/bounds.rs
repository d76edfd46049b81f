//! Unit and allowed range of a value, as the comment beside it begins: `[s] in [0.05, 60]; why`, `[s] [0.05, 60] why` or
//! `[s] 0.05..60, why`. A list has one range for all of its items, or one for each: `[-] [0.1, 1], [1, 5]`.

use super::tree::Tree;
use crate::args::short;
use models::params::with_unit;
use serde_json::Value;

/// Unit and allowed range of a value.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Bounds {
    /// `-` for a number without one; empty where none is said.
    pub(super) unit: String,
    /// One for the value, or for all items of a list; or one for each of them.
    pub(super) ranges: Vec<(f64, f64)>,
}

impl Bounds {
    /// What a comment begins with.
    pub(super) fn read(comment: &str) -> Self {
        let unit = comment.strip_prefix('[').and_then(|rest| rest.split_once(']'));
        let (unit, mut rest) = unit.filter(|(unit, _)| !unit.contains(',')).unwrap_or(("", comment));
        let mut ranges = Vec::new();
        while let Some((range, behind)) = range(rest) {
            ranges.push(range);
            match behind.strip_prefix(", ") {
                Some(next) => rest = next,
                None => break,
            }
        }
        Self { unit: unit.to_owned(), ranges }
    }

    /// These, and what they leave open from others.
    pub(super) fn or(self, others: &Self) -> Self {
        let unit = if self.unit.is_empty() { others.unit.clone() } else { self.unit };
        let ranges = if self.ranges.is_empty() { others.ranges.clone() } else { self.ranges };
        Self { unit, ranges }
    }

    /// Takes in what a later file says of the same value: it may narrow a range, and never widens one.
    pub(super) fn narrow(&mut self, later: Self) {
        if self.ranges.len() == later.ranges.len() {
            for (mine, theirs) in self.ranges.iter_mut().zip(later.ranges) {
                let both = (mine.0.max(theirs.0), mine.1.min(theirs.1));
                if both.0 <= both.1 {
                    *mine = both;
                }
            }
        } else if self.ranges.is_empty() {
            self.ranges = later.ranges;
        }
        if self.unit.is_empty() {
            self.unit = later.unit;
        }
    }

    /// The range of the value itself.
    pub(super) fn range(&self) -> Option<(f64, f64)> {
        self.ranges.first().copied().filter(|_| self.ranges.len() == 1)
    }

    /// The allowed range for people: ` in [1, 2]`; nothing where none is said.
    pub(super) fn rule(&self) -> String {
        let written = |range: &(f64, f64)| format!("[{}, {}]", number(range.0), number(range.1));
        let all = self.ranges.iter().map(written).collect::<Vec<_>>();
        if all.is_empty() { String::new() } else { format!(" in {}", all.join(" and ")) }
    }

    /// `name = value unit: rule`, with the allowed range where the rule names none.
    pub(super) fn refusal(&self, name: &str, value: &str, rule: &str) -> String {
        let is_number = value.parse::<f64>().is_ok();
        let range = match self.rule() {
            allowed if rule.contains('[') || allowed.is_empty() => String::new(),
            // What is no number has no unit: that of the numbers stands behind their range.
            allowed if is_number => format!("; allowed{allowed}"),
            allowed => format!("; allowed{}", with_unit(&allowed, &self.unit)),
        };
        let value = if is_number { with_unit(value, &self.unit) } else { short(value) };
        format!("{} = {value}: {rule}{range}", short(name))
    }

    /// Why a value is refused that is not finite or outside of its range; `None` where it is not.
    pub(super) fn outside(&self, name: &str, tree: &Tree) -> Option<String> {
        match tree {
            Tree::NotFinite(value) => {
                let and = if self.ranges.is_empty() { "" } else { " and" };
                let rule = format!("must be finite{and}{}", self.rule());
                Some(self.refusal(name, &value.to_string(), &rule))
            }
            Tree::Leaf(Value::Array(items)) => {
                let of = |at| if self.ranges.len() == items.len() { self.ranges.get(at) } else { None };
                items.iter().enumerate().find_map(|(at, item)| {
                    let range = of(at).copied().or_else(|| self.range());
                    let alone = Self { unit: self.unit.clone(), ranges: range.into_iter().collect() };
                    alone.outside_of(&format!("{name}[{at}]"), item)
                })
            }
            Tree::Leaf(value) => self.outside_of(name, value),
            Tree::Block(_) => None,
        }
    }

    fn outside_of(&self, name: &str, value: &Value) -> Option<String> {
        let (value, (low, high)) = (value.as_f64()?, self.range()?);
        let rule = format!("must be{}", self.rule());
        (!(low..=high).contains(&value)).then(|| self.refusal(name, &number(value), &rule))
    }

    /// As [`Bounds::refusal`], of what a struct does not take; `said` is what its parser says.
    pub(super) fn mistyped(&self, name: &str, value: &str, said: &str) -> String {
        let wanted = said.starts_with("invalid ").then(|| said.rsplit_once("expected ")).flatten();
        let kind = match wanted.map(|(_, wanted)| wanted) {
            Some("f64") => "a number",
            Some("u8" | "u16" | "u32" | "u64" | "usize") if self.ranges.is_empty() => {
                "a whole number, 0 or more"
            }
            Some("u8" | "u16" | "u32" | "u64" | "usize" | "i64" | "i32") => "a whole number",
            Some("a boolean") => "true or false",
            Some(kind) if kind.starts_with("struct ") => "a block of names and values",
            _ => return self.refusal(name, value, said),
        };
        self.refusal(name, value, &format!("must be {kind}"))
    }
}

/// A number for people: without the zeros of a large or a small one.
pub(super) fn number(value: f64) -> String {
    let plain = value == 0.0 || (1e-4..1e7).contains(&value.abs());
    if plain { value.to_string() } else { format!("{value:e}") }
}

/// The range that a text begins with, and what stands behind it.
fn range(text: &str) -> Option<((f64, f64), &str)> {
    let text = text.trim_start();
    let text = text.strip_prefix("in ").unwrap_or(text);
    let ((from, to), behind) = if let Some(pair) = text.strip_prefix('[') {
        let (pair, behind) = pair.split_once(']')?;
        (pair.split_once(',')?, behind)
    } else {
        let end = text.find([' ', ',', ';']).unwrap_or(text.len());
        (text[..end].split_once("..")?, &text[end..])
    };
    let (from, to) = (from.trim().parse().ok()?, to.trim().parse().ok()?);
    (from <= to).then_some(((from, to), behind))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn all_ways_to_write_a_range_are_read_and_nothing_else_is() {
        let ranges = |comment: &str| Bounds::read(comment).ranges;
        assert_eq!(ranges("[s] in [0.05, 60]; ten periods"), [(0.05, 60.0)]);
        assert_eq!(ranges("[s] [0.05, 60] ten periods"), [(0.05, 60.0)]);
        assert_eq!(ranges("[m] -1..1, of the bed"), [(-1.0, 1.0)]);
        assert_eq!(ranges("1e-4..0.1 of it"), [(1e-4, 0.1)]);
        assert_eq!(ranges("[-] [0.1, 1], [1, 5] least and most"), [(0.1, 1.0), (1.0, 5.0)]);
        assert_eq!(ranges("[-] 1..20, 0.2 s"), [(1.0, 20.0)]);
        for none in ["[s] > 0", "[-]", "see 2 above", "[m] in [1, x]", "[m] 2..1", "all [s] in [0, 1]", ""] {
            assert_eq!(ranges(none), [], "{none}");
        }
        for (comment, unit) in
            [("[J/(kg K)] 0..1", "J/(kg K)"), ("[-] why", "-"), ("[0, 1]", ""), ("why", "")]
        {
            assert_eq!(Bounds::read(comment).unit, unit, "{comment}");
        }
    }

    /// Who lays a file over ours says what he means by a value, and cannot take its limits away.
    #[test]
    fn a_later_file_narrows_a_range_and_never_widens_it() {
        let after = |later: &str| {
            let mut bounds = Bounds::read("[s] in [1, 5]");
            bounds.narrow(Bounds::read(later));
            (bounds.unit, bounds.ranges)
        };
        for (later, range) in
            [("[s] 2..9", (2.0, 5.0)), ("mine", (1.0, 5.0)), ("[s] 7..9", (1.0, 5.0)), ("0..3", (1.0, 3.0))]
        {
            assert_eq!(after(later), ("s".to_owned(), vec![range]), "{later}");
        }
    }

    #[test]
    fn every_number_of_a_list_has_its_range() {
        let outside = |comment: &str, value: Value| Bounds::read(comment).outside("a", &Tree::Leaf(value));
        let said = |comment: &str, value: Value| outside(comment, value).unwrap_or_default();
        assert_eq!(said("[m] 0..1", json!([0.5, 2])), "a[1] = 2 m: must be in [0, 1]");
        assert_eq!(said("[-] [0.1, 1], [1, 5]", json!([0.5, 6.0])), "a[1] = 6 (no unit): must be in [1, 5]");
        assert_eq!(outside("[-] [0.1, 1], [1, 5]", json!([0.5, 2.0])), None);
        assert_eq!(said("[s] 0..1", json!(1e12)), "a = 1e12 s: must be in [0, 1]");
    }
}
