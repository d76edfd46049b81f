//! Messages by topic, and what could not be read of them.

use super::super::decode::short;
use std::collections::{BTreeMap, BTreeSet};

/// Topics that are told apart; a bag may name any number.
const TOPICS_MAX: usize = 400;
/// Namespaces that are named.
const NAMESPACES_MAX: usize = 20;
/// Longest name that is kept.
pub(super) const NAME_MAX: usize = 120;

/// Counts of one topic.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) type_name: String,
    pub(crate) messages: u64,
    /// Bytes that are no message of the type.
    pub(crate) undecodable: u64,
    /// Messages of another type than the topic's.
    pub(crate) other_type: u64,
    /// Messages whose stamp does not fit to the others.
    pub(crate) misplaced: u64,
}

/// Counts of all topics.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) topics: BTreeMap<String, Counts>,
    /// Messages of topics beyond the ones told apart.
    pub(crate) beyond: u64,
    pub(crate) messages: u64,
    /// A message of a topic and type that a printer's graph has, and not every graph.
    pub(crate) of_a_printer: bool,
    /// Files whose data fit their checksum.
    pub(crate) sums_fit: u64,
    /// Namespaces with a topic that a printer has.
    pub(crate) namespaces: BTreeSet<String>,
    /// Topics that are none of this printer's.
    pub(crate) foreign: BTreeSet<String>,
}

impl Tally {
    /// A message of a topic.
    pub(crate) fn count(&mut self, topic: &str, type_name: &str) {
        self.messages += 1;
        if let Some(counts) = self.topics.get_mut(topic) {
            counts.messages += 1;
        } else if self.topics.len() < TOPICS_MAX && topic.len() <= NAME_MAX {
            let counts = Counts { type_name: short(type_name, NAME_MAX), messages: 1, ..Counts::default() };
            self.topics.insert(topic.to_owned(), counts);
        } else {
            self.beyond += 1;
        }
    }

    /// A topic that the report does not know.
    pub(crate) fn foreign(&mut self, topic: &str) {
        if self.foreign.len() < TOPICS_MAX && !self.foreign.contains(topic) {
            self.foreign.insert(short(topic, NAME_MAX));
        }
    }

    /// A namespace with a printer's topic.
    pub(crate) fn namespace(&mut self, name: &str) {
        if self.namespaces.len() < NAMESPACES_MAX && !self.namespaces.contains(name) {
            self.namespaces.insert(short(name, NAME_MAX));
        }
    }

    /// A message that is none of its type.
    pub(crate) fn undecodable(&mut self, topic: &str) {
        self.change(topic, |counts| counts.undecodable += 1);
    }

    /// A message of another type.
    pub(crate) fn other_type(&mut self, topic: &str) {
        self.change(topic, |counts| counts.other_type += 1);
    }

    /// A message whose time does not fit.
    pub(crate) fn misplaced(&mut self, topic: &str) {
        self.change(topic, |counts| counts.misplaced += 1);
    }

    fn change(&mut self, topic: &str, how: impl FnOnce(&mut Counts)) {
        if let Some(counts) = self.topics.get_mut(topic) {
            how(counts);
        }
    }

    /// Whether messages of a topic came and none could be read.
    pub(crate) fn unreadable(&self, ending: &str) -> bool {
        let mut of_it = self.topics.iter().filter(|(topic, _)| topic.ends_with(ending)).peekable();
        of_it.peek().is_some()
            && of_it.all(|(_, counts)| counts.undecodable + counts.other_type == counts.messages)
    }

    /// Messages that could not be read.
    pub(crate) fn unread(&self) -> u64 {
        self.topics.values().map(|counts| counts.undecodable + counts.other_type).sum()
    }
}
