//! What a parameter file says of its values: a comment beside each carries unit, range and source.

use super::join;
use super::tree::{Origin, Tree};
use std::collections::BTreeMap;

/// What is said of a value.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Said {
    pub(super) text: String,
    /// Allowed range, where the text says it of this value alone.
    pub(super) range: Option<(f64, f64)>,
}

/// What is said of all values by their dotted names. It holds whatever takes the value's place later: a file without
/// comments, an option, a request.
#[derive(Debug, Clone, Default)]
pub(super) struct Descriptions(BTreeMap<String, Said>);

/// What is said of a value of which nothing is said.
static UNSAID: Said = Said { text: String::new(), range: None };

/// A file that is read.
struct Source<'a> {
    name: &'a str,
    /// Comments at the ends of lines, by line from 1.
    comments: BTreeMap<u64, &'a str>,
    /// Values that begin on each line.
    values: BTreeMap<u64, usize>,
}

impl Source<'_> {
    /// The line of a place in this file.
    fn line(&self, origin: &Origin) -> Option<u64> {
        match origin {
            Origin::File(file, line) if **file == *self.name => Some(*line),
            _ => None,
        }
    }

    /// Counts the values of each line.
    fn count(&mut self, tree: &Tree) {
        let Tree::Block(entries) = tree else { return };
        for (_, child, origin) in entries {
            match (child, self.line(origin)) {
                (Tree::Block(_), _) => self.count(child),
                (_, Some(line)) => *self.values.entry(line).or_default() += 1,
                _ => {}
            }
        }
    }
}

impl Descriptions {
    /// Takes in what a file says of the values of `merged` that stand in it.
    pub(super) fn read(&mut self, file: &str, text: &str, merged: &Tree) {
        let mut source = Source { name: file, comments: comments(text), values: BTreeMap::new() };
        source.count(merged);
        self.take(&source, merged, ("", ""));
    }

    /// What is said of a value.
    pub(super) fn of(&self, name: &str) -> &Said {
        self.0.get(name).unwrap_or(&UNSAID)
    }

    /// Takes in a block of this name; where nothing stands beside a value, what is said of its block holds, `above`.
    fn take(&mut self, source: &Source<'_>, tree: &Tree, (path, above): (&str, &str)) {
        let Tree::Block(entries) = tree else { return };
        for (key, child, origin) in entries {
            let (path, line) = (join(path, key), source.line(origin));
            let own = line.and_then(|line| source.comments.get(&line)).copied();
            let text = own.unwrap_or(above);
            if matches!(child, Tree::Block(_)) {
                self.take(source, child, (&path, text));
            } else if line.is_some() && !text.is_empty() {
                // Of several values on a line nothing tells whose range it is.
                let alone = line.and_then(|line| source.values.get(&line)) == Some(&1);
                let range = own.filter(|_| alone).and_then(range);
                self.0.insert(path, Said { text: text.to_owned(), range });
            }
        }
    }
}

/// The comments at the ends of a file's lines; whole lines belong to no value.
fn comments(text: &str) -> BTreeMap<u64, &str> {
    let lines = (1..).zip(text.lines()).filter(|(_, line)| !line.trim_start().starts_with('#'));
    // YAML wants a space before a comment.
    lines.filter_map(|(number, line)| Some((number, line.split_once(" #")?.1.trim()))).collect()
}

/// The range that a comment begins with, after its unit: `[s] in [0.05, 60]; why`, `[s] [0.05, 60] why` or `[s] 0.05..60,
/// why`.
fn range(comment: &str) -> Option<(f64, f64)> {
    let said = match comment.strip_prefix('[') {
        Some(unit) => unit.split_once(']')?.1.trim_start(),
        None => comment,
    };
    let (from, to) = match said.strip_prefix("in ").unwrap_or(said).strip_prefix('[') {
        Some(pair) => pair.split_once(']')?.0.split_once(',')?,
        None => said.split([' ', ',', ';']).next()?.split_once("..")?,
    };
    let (from, to) = (from.trim().parse().ok()?, to.trim().parse().ok()?);
    (from <= to).then_some((from, to))
}

#[cfg(test)]
mod tests {
    use super::super::{NodePath, tree};
    use super::*;
    use std::path::Path;

    /// What files say one after the other; below `/**: ros__parameters:`.
    fn read(files: &[&str]) -> Descriptions {
        let node = NodePath { qualified: "/printer/mpc".into(), base: "mpc".into() };
        let (mut merged, mut said) = (Tree::default(), Descriptions::default());
        for (number, text) in files.iter().enumerate() {
            let (name, text) = (format!("{number}.yaml"), format!("/**:\n  ros__parameters:\n{text}"));
            tree::merge_file(&mut merged, &text, Path::new(&name), &node).unwrap();
            said.read(&name, &text, &merged);
        }
        tree::merge_override(&mut merged, ("a", "7"), &node).unwrap();
        said
    }

    #[test]
    fn a_comment_belongs_to_the_value_on_its_line() {
        let said =
            read(&["    # of the file\n    a: 1  # [s] in [0, 2]; why\n    # of nothing\n    b: 'x#y'\n"]);
        assert_eq!(said.of("a"), &Said { text: "[s] in [0, 2]; why".into(), range: Some((0.0, 2.0)) });
        assert_eq!((said.of("b"), said.of("c")), (&UNSAID, &UNSAID));
    }

    /// One comment for several values describes all of them, and its range is none's.
    #[test]
    fn values_on_one_line_share_their_comment_and_no_range() {
        let said = read(&[
            "    l: {n: 3, s: 1.0} # [-] in [1, 8], [s] in [0.01, 60]\n    k: {n: 3} # [-] in [1, 9]\n",
        ]);
        for name in ["l.n", "l.s"] {
            assert_eq!(said.of(name), &Said { text: "[-] in [1, 8], [s] in [0.01, 60]".into(), range: None });
        }
        assert_eq!(said.of("k.n").range, Some((1.0, 9.0)));
    }

    /// What is said of a block is said of its values that have nothing of their own.
    #[test]
    fn a_value_without_a_comment_has_that_of_its_block() {
        let said =
            read(&["    w: # all [-] [0, 1e3]\n      a: 1\n      b: 2 # [-] [0, 5] own\n      c: {d: 1}\n"]);
        assert_eq!(said.of("w.a"), &Said { text: "all [-] [0, 1e3]".into(), range: None });
        assert_eq!(said.of("w.b"), &Said { text: "[-] [0, 5] own".into(), range: Some((0.0, 5.0)) });
        assert_eq!(said.of("w.c.d").text, "all [-] [0, 1e3]");
    }

    /// `-p` and the files that launch_ros writes have no comments.
    #[test]
    fn what_takes_a_values_place_does_not_take_its_description() {
        let said = read(&["    a: 1 # [s] in [0, 2]\n    b: 1 # old\n", "    a: 2\n    b: 2 # new\n"]);
        assert_eq!((said.of("a").text.as_str(), said.of("a").range), ("[s] in [0, 2]", Some((0.0, 2.0))));
        assert_eq!(said.of("b").text, "new");
    }

    #[test]
    fn all_ways_to_write_a_range_are_read_and_nothing_else_is() {
        assert_eq!(range("[s] in [0.05, 60]; ten periods"), Some((0.05, 60.0)));
        assert_eq!(range("[s] [0.05, 60] ten periods"), Some((0.05, 60.0)));
        assert_eq!(range("[m] -1..1, of the bed"), Some((-1.0, 1.0)));
        assert_eq!(range("1e-4..0.1 of it"), Some((1e-4, 0.1)));
        for none in ["[s] > 0", "[-]", "see 2 above", "[m] in [1, x]", "[m] 2..1", "all [s] in [0, 1]", ""] {
            assert_eq!(range(none), None, "{none}");
        }
    }
}
