//! What the comment beside a value says: a parameter file carries unit, range and source of each value.

use std::collections::BTreeMap;
use std::sync::Arc;

/// Comments by file and line from 1.
#[derive(Debug, Clone, Default)]
pub(super) struct Comments(BTreeMap<(Arc<str>, u64), String>);

impl Comments {
    /// Takes the comments at the ends of a file's lines.
    pub(super) fn read(&mut self, file: &Arc<str>, text: &str) {
        for (number, line) in (1..).zip(text.lines()) {
            // YAML wants a space before a comment; whole lines belong to no value.
            if let Some((_, comment)) = line.split_once(" #")
                && !line.trim_start().starts_with('#')
            {
                self.0.insert((Arc::clone(file), number), comment.trim().to_owned());
            }
        }
    }

    /// The comment of a line.
    pub(super) fn of(&self, file: &Arc<str>, line: u64) -> Option<&str> {
        self.0.get(&(Arc::clone(file), line)).map(String::as_str)
    }
}

/// The range that a comment begins with, after its unit: `[s] in [0.05, 60]; why` or `[s] 0.05..60, why`.
pub(super) fn range(comment: &str) -> Option<(f64, f64)> {
    let said = match comment.strip_prefix('[') {
        Some(unit) => unit.split_once(']')?.1.trim_start(),
        None => comment,
    };
    let (from, to) = match said.strip_prefix("in [") {
        Some(pair) => pair.split_once(']')?.0.split_once(',')?,
        None => said.split([' ', ',', ';']).next()?.split_once("..")?,
    };
    let (from, to) = (from.trim().parse().ok()?, to.trim().parse().ok()?);
    (from <= to).then_some((from, to))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_comment_belongs_to_the_value_on_its_line() {
        let (mut comments, file) = (Comments::default(), Arc::from("a.yaml"));
        comments.read(&file, "# of the file\na: 1  # [s] in [0, 2]; why\n  # of a block\nb: 'x#y'\n");
        assert_eq!(comments.of(&file, 2), Some("[s] in [0, 2]; why"));
        for line in [1, 3, 4, 5] {
            assert_eq!(comments.of(&file, line), None);
        }
    }

    #[test]
    fn both_ways_to_write_a_range_are_read_and_nothing_else_is() {
        assert_eq!(range("[s] in [0.05, 60]; ten periods"), Some((0.05, 60.0)));
        assert_eq!(range("[m] -1..1, of the bed"), Some((-1.0, 1.0)));
        assert_eq!(range("1e-4..0.1 of it"), Some((1e-4, 0.1)));
        for none in ["[s] > 0", "[-]", "see 2 above", "[m] in [1, x]", "[m] 2..1", ""] {
            assert_eq!(range(none), None, "{none}");
        }
    }
}
