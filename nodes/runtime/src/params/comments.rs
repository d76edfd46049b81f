//! What a parameter file says of its values: a comment beside each carries unit, range and source.

use super::bounds::Bounds;
use super::join;
use super::tree::{Origin, Tree};
use std::collections::BTreeMap;

/// What is said of a value.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Said {
    pub(super) text: String,
    /// Unit and allowed range, where the text says them of this value alone.
    pub(super) bounds: Bounds,
}

/// What is said of all values by their dotted names. It holds whatever takes the value's place later: a file without
/// comments, an option, a request.
#[derive(Debug, Clone, Default)]
pub(super) struct Descriptions(BTreeMap<String, Said>);

/// What is said of a value of which nothing is said.
static UNSAID: Said =
    Said { text: String::new(), bounds: Bounds { unit: String::new(), ranges: Vec::new() } };

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
        self.take(&source, merged, ("", &UNSAID));
    }

    /// What is said of a value.
    pub(super) fn of(&self, name: &str) -> &Said {
        self.0.get(name).unwrap_or(&UNSAID)
    }

    /// Takes in a block of this name. Where nothing stands beside a value the text of its block holds; a range of a
    /// block is that of its values where its text begins with `all`.
    fn take(&mut self, source: &Source<'_>, tree: &Tree, (path, above): (&str, &Said)) {
        let Tree::Block(entries) = tree else { return };
        for (key, child, origin) in entries {
            let (path, line) = (join(path, key), source.line(origin));
            let own = line.and_then(|line| source.comments.get(&line)).copied();
            let text = own.unwrap_or(&above.text).to_owned();
            if matches!(child, Tree::Block(_)) {
                let all = own.and_then(|own| own.strip_prefix("all ")).map(Bounds::read);
                let bounds = all.unwrap_or_else(|| above.bounds.clone());
                self.take(source, child, (&path, &Said { text, bounds }));
            } else if line.is_some() && !text.is_empty() {
                // Of several values on a line nothing tells whose range it is.
                let alone = line.and_then(|line| source.values.get(&line)) == Some(&1);
                let own = own.filter(|_| alone).map(Bounds::read).unwrap_or_default();
                let said = self.0.entry(path).or_default();
                said.text = text;
                said.bounds.narrow(own.or(&above.bounds));
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

    /// A text with what it begins with.
    fn said_as(text: &str) -> Said {
        Said { text: text.to_owned(), bounds: Bounds::read(text) }
    }

    #[test]
    fn a_comment_belongs_to_the_value_on_its_line() {
        let said =
            read(&["    # of the file\n    a: 1  # [s] in [0, 2]; why\n    # of nothing\n    b: 'x#y'\n"]);
        assert_eq!(said.of("a"), &said_as("[s] in [0, 2]; why"));
        assert_eq!((said.of("b"), said.of("c")), (&UNSAID, &UNSAID));
    }

    /// One comment for several values describes all of them, and its range is none's.
    #[test]
    fn values_on_one_line_share_their_comment_and_no_range() {
        let said = read(&[
            "    l: {n: 3, s: 1.0} # [-] in [1, 8], [s] in [0.01, 60]\n    k: {n: 3} # [-] in [1, 9]\n",
        ]);
        for name in ["l.n", "l.s"] {
            assert_eq!(said.of(name).text, "[-] in [1, 8], [s] in [0.01, 60]");
            assert_eq!(said.of(name).bounds, Bounds::default());
        }
        assert_eq!(said.of("k.n").bounds.range(), Some((1.0, 9.0)));
    }

    /// What is said of a block is said of its values that have nothing of their own; its range where it is that of all.
    #[test]
    fn a_value_without_a_comment_has_that_of_its_block() {
        let said = read(&[
            "    w: # all [-] [0, 1e3]\n      a: 1\n      b: 2 # [-] [0, 5] own\n      c: {d: 1, e: 2} # why\n\
                    \x20   v: # [-] [0, 1]\n      a: 1\n",
        ]);
        let all = Bounds::read("[-] [0, 1e3]");
        assert_eq!(said.of("w.a"), &Said { text: "all [-] [0, 1e3]".into(), bounds: all.clone() });
        assert_eq!(said.of("w.b"), &said_as("[-] [0, 5] own"));
        assert_eq!(said.of("w.c.d"), &Said { text: "why".into(), bounds: all });
        assert_eq!(said.of("v.a"), &Said { text: "[-] [0, 1]".into(), bounds: Bounds::default() });
    }

    /// `-p` and the files that launch_ros writes have no comments.
    #[test]
    fn what_takes_a_values_place_does_not_take_its_description() {
        let said = read(&["    a: 1 # [s] in [0, 2]\n    b: 1 # old\n", "    a: 2\n    b: 2 # new\n"]);
        assert_eq!(said.of("a"), &said_as("[s] in [0, 2]"));
        assert_eq!(said.of("b").text, "new");
    }
}
