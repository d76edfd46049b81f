//! What a refusal says: where the value stands, its whole name, the value, its unit and what is allowed.

use super::bounds::Bounds;
use super::tree::Origin;
use super::{ParamFileError, Parameters, join};
use crate::args::ends;
use std::path::PathBuf;

/// Where a value stands of which no file says anything, for there is none.
const NO_FILE: &str = "no --params-file given";

impl Parameters {
    /// Refuses the first number that is not finite or outside of the range that stands beside it.
    pub(super) fn check_ranges(&self) -> Result<(), ParamFileError> {
        for name in self.tree.leaves() {
            let Some((tree, origin)) = self.tree.get(&name) else { continue };
            if let Some(message) = self.descriptions.of(&name).bounds.outside(&name, tree) {
                return Err(ParamFileError::Refused { at: origin.to_string(), message });
            }
        }
        Ok(())
    }

    /// Puts file and line in front of what the struct said, and the whole name in place of a block's own.
    pub(super) fn explain(&self, path: &str, said: &str) -> ParamFileError {
        let missing = said.strip_prefix("missing field `").and_then(|rest| rest.strip_suffix('`'));
        if let Some(name) = missing {
            return self.missing(&join(path, name), "");
        }
        // `models::params` begins its messages with `name = value`, the name relative to its block or to the file.
        let named = said.split_once(" = ").filter(|(name, _)| !name.contains(' '));
        if let Some((name, rest)) = named.and_then(|(name, rest)| Some((self.whole(path, name)?, rest))) {
            return self.refused((path, &name), rest);
        }
        let bounds = &self.descriptions.of(path).bounds;
        let (at, message) = match self.tree.get(path).map(|(tree, at)| (tree.leaf_text(), at.to_string())) {
            Some((Some(value), at)) => (at, bounds.mistyped(path, &value, said)),
            Some((None, at)) => (at, format!("{}: {said}", ends(path))),
            None if path.is_empty() => (self.fallback(path), said.to_owned()),
            None => (self.fallback(path), format!("{}: {said}", ends(path))),
        };
        ParamFileError::Refused { at, message }
    }

    /// The whole name of what a block calls by its own: it stands in the block, in one above, or at the root.
    fn whole(&self, block: &str, name: &str) -> Option<String> {
        let ends = block.rmatch_indices('.').map(|(end, _)| end);
        let blocks = std::iter::once(block.len()).chain(ends).map(|end| &block[..end]);
        let all = blocks.chain(std::iter::once("")).map(|block| join(block, name));
        all.into_iter().find(|name| self.tree.get(name).is_some())
    }

    /// A value that a struct refused: `rest` says what it is and what it must be. Of two that must stand in order that
    /// one is named which was set, not its neighbour.
    fn refused(&self, (block, name): (&str, &str), rest: &str) -> ParamFileError {
        let (value, rule) = rest.split_once(": ").unwrap_or((rest, "is not taken"));
        // A struct says the unit too, for those who have no file.
        let (value, unit) =
            value.split_once(' ').filter(|(value, _)| value.parse::<f64>().is_ok()).unwrap_or((value, ""));
        let own = Bounds { unit: unit.to_owned(), ranges: Vec::new() };
        let of = |name: &str| self.descriptions.of(name).bounds.clone().or(&own);
        let upper = rule.strip_prefix("must be below ").and_then(|upper| upper.split_once(" = "));
        let upper = upper.and_then(|(name, value)| Some((self.whole(block, name)?, value)));
        match upper.filter(|(upper, _)| self.rank(upper) > self.rank(name)) {
            Some((upper, high)) => ParamFileError::Refused {
                at: self.fallback(&upper),
                message: of(&upper).refusal(&upper, high, &format!("must be above {name} = {value}")),
            },
            None => ParamFileError::Refused {
                at: self.fallback(name),
                message: of(name).refusal(name, value, rule),
            },
        }
    }

    /// How late a value was set: by a file, by the last one, by an option, by a request.
    fn rank(&self, name: &str) -> u8 {
        let is_last = |file: &str| self.files.last().is_some_and(|last| last.display().to_string() == file);
        match self.tree.origin(name) {
            None => 0,
            Some(Origin::File(file, _)) => u8::from(is_last(file)),
            Some(Origin::Override(_)) => 2,
            Some(Origin::Request) => 3,
        }
    }

    /// A value, or a block, that no file gives: the block that lacks it is named, else all files, and which of them say
    /// nothing of the node.
    pub(super) fn missing(&self, name: &str, advice: &str) -> ParamFileError {
        let name = ends(name);
        let told = |file: &PathBuf| match self.silent.contains(file) {
            true => format!("{} (holds nothing for {})", file.display(), self.node),
            false => file.display().to_string(),
        };
        let in_file = |origin: &&Origin| matches!(origin, Origin::File(..));
        let at = match self.standing(&name).filter(in_file) {
            Some(origin) => origin.to_string(),
            None if self.files.is_empty() => NO_FILE.to_owned(),
            None => self.files.iter().map(told).collect::<Vec<_>>().join(", "),
        };
        ParamFileError::Refused { at, message: format!("{name}: missing{advice}") }
    }

    /// Where a path stands, or the nearest block above it.
    fn standing(&self, path: &str) -> Option<&Origin> {
        let ends = path.rmatch_indices('.').map(|(end, _)| end);
        let mut blocks = std::iter::once(path.len()).chain(ends).map(|end| &path[..end]);
        blocks.find_map(|block| self.tree.origin(block))
    }

    /// The same, or the last file.
    pub(super) fn fallback(&self, path: &str) -> String {
        let last = || self.files.last().map_or_else(|| NO_FILE.to_owned(), |file| file.display().to_string());
        self.standing(path).map_or_else(last, ToString::to_string)
    }
}
