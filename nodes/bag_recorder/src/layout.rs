//! Names of the files of a bag, and what a folder needs before recording goes on in it.

use std::collections::BTreeSet;

/// Ending of a finished file.
const FINISHED: &str = ".mcap";
/// Ending of the file that is being written.
const ACTIVE: &str = ".mcap.active";
/// Ending of the mark that a file is kept.
const KEEP: &str = ".mcap.keep";
/// Ending of a finished file in the making, out of an active one that a kill left.
const RECOVERING: &str = ".mcap.recovering";

/// The names in one bag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    bag: String,
    /// The first file has no number.
    lone: bool,
}

/// What stands in a folder.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Survey {
    /// Numbers of the finished files, ascending.
    pub finished: Vec<u32>,
    /// Numbers of the active files that a kill left, ascending: to be recovered.
    pub leftover: Vec<u32>,
    /// Names of files whose content is in a finished or an active one: to be removed.
    pub stale: Vec<String>,
    /// Number of the next file; no name with it is taken.
    pub next: u32,
}

impl Layout {
    /// Names in the folder `bag` (its last component).
    #[must_use]
    pub fn new(bag: impl Into<String>) -> Self {
        Self { bag: bag.into(), lone: false }
    }

    /// Names of a bag whose one file has no number, as some programs write it: it counts as number 0.
    #[must_use]
    pub fn lone(file: impl Into<String>) -> Self {
        Self { bag: file.into(), lone: true }
    }

    /// Names of the bag that a file belongs to, finished or active; `None` for any other file.
    #[must_use]
    pub fn of_file(name: &str) -> Option<Self> {
        let stem = [ACTIVE, FINISHED].iter().find_map(|ending| name.strip_suffix(ending))?;
        let numbered = stem.rsplit_once('_').map(|(bag, _)| Self::new(bag));
        let fits = |layout: &Self| [ACTIVE, FINISHED].iter().any(|end| layout.number(name, end).is_some());
        Some(numbered.filter(fits).unwrap_or_else(|| Self::lone(stem)))
    }

    /// What the names of its files begin with.
    #[must_use]
    pub fn bag(&self) -> &str {
        &self.bag
    }

    /// Name of a finished file.
    #[must_use]
    pub fn finished(&self, number: u32) -> String {
        self.name(number, FINISHED)
    }

    /// Name of the file while it is written.
    #[must_use]
    pub fn active(&self, number: u32) -> String {
        self.name(number, ACTIVE)
    }

    /// Name of the finished file while it is made out of a leftover.
    #[must_use]
    pub fn recovering(&self, number: u32) -> String {
        self.name(number, RECOVERING)
    }

    /// Name of the empty file beside a finished one that must not be dropped; a person may make it too.
    #[must_use]
    pub fn keep(&self, number: u32) -> String {
        self.name(number, KEEP)
    }

    /// Sorts the names of a folder; foreign files are passed over.
    #[must_use]
    pub fn survey<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Survey {
        let (mut finished, mut active, mut recovering) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
        for name in names {
            let kinds = [(FINISHED, &mut finished), (ACTIVE, &mut active), (RECOVERING, &mut recovering)];
            for (ending, numbers) in kinds {
                numbers.extend(self.number(name, ending));
            }
        }
        // A finished file gets its name when it is whole and on disk: its active twin holds nothing more.
        let twins = active.intersection(&finished).map(|number| self.active(*number));
        let halves = recovering.iter().map(|number| self.recovering(*number));
        Survey {
            stale: twins.chain(halves).collect(),
            leftover: active.difference(&finished).copied().collect(),
            next: finished.iter().chain(&active).max().map_or(0, |last| last + 1),
            finished: finished.into_iter().collect(),
        }
    }

    fn name(&self, number: u32, ending: &str) -> String {
        match (self.lone, number) {
            (true, 0) => format!("{}{ending}", self.bag),
            _ => format!("{}_{number}{ending}", self.bag),
        }
    }

    /// Number of a file with this ending; a number written otherwise (`007`) is a foreign file.
    fn number(&self, name: &str, ending: &str) -> Option<u32> {
        let behind = name.strip_prefix(&self.bag)?.strip_suffix(ending)?;
        let number =
            if self.lone && behind.is_empty() { 0 } else { behind.strip_prefix('_')?.parse().ok()? };
        (self.name(number, ending) == name).then_some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_folder_begins_at_zero_as_rosbag2_does() {
        let layout = Layout::new("print");
        assert_eq!(layout.survey([]), Survey::default());
        assert_eq!(layout.finished(0), "print_0.mcap");
        assert_eq!(layout.active(0), "print_0.mcap.active");
    }

    /// A second run never writes over the first, whether that ended in order or not.
    #[test]
    fn the_next_number_is_above_every_finished_and_active_one() {
        let survey = Layout::new("print").survey([
            "print_0.mcap",
            "print_1.mcap.active",
            "print_10.mcap",
            "metadata.yaml",
            "counts.json",
        ]);
        assert_eq!((survey.finished, survey.leftover, survey.next), (vec![0, 10], vec![1], 11));
        assert!(survey.stale.is_empty());
    }

    /// Killed between the renaming of the recovered file and the removal of the active one; and in the middle of the
    /// copy.
    #[test]
    fn what_a_kill_during_recovery_leaves_is_stale() {
        let survey = Layout::new("p").survey([
            "p_0.mcap",
            "p_0.mcap.active",
            "p_1.mcap.active",
            "p_1.mcap.recovering",
        ]);
        assert_eq!(survey.stale, ["p_0.mcap.active", "p_1.mcap.recovering"]);
        assert_eq!((survey.leftover, survey.next), (vec![1], 2));
    }

    /// Other programs write one file, without a number.
    #[test]
    fn a_file_without_a_number_is_the_first_of_its_bag() {
        let layout = Layout::of_file("walk.mcap").unwrap();
        assert_eq!((layout.finished(0), layout.finished(1)), ("walk.mcap".into(), "walk_1.mcap".into()));
        let survey = layout.survey(["walk.mcap", "walk_0.mcap", "walk.mcap.torn"]);
        assert_eq!((survey.finished, survey.next), (vec![0], 1));
        assert_eq!(layout.survey(["walk.mcap.active"]).leftover, [0]);
        assert_eq!(Layout::of_file("p_3.mcap.active"), Some(Layout::new("p")));
        assert_eq!(Layout::of_file("p_03.mcap"), Some(Layout::lone("p_03")));
        assert_eq!(Layout::of_file("p_3.db3"), None);
    }

    #[test]
    fn foreign_names_are_passed_over() {
        let survey = Layout::new("p").survey([
            "p_007.mcap",
            "q_1.mcap",
            "p_.mcap",
            "p_-1.mcap",
            "p_1.db3",
            "p_99999999999.mcap",
        ]);
        assert_eq!(survey, Survey::default());
    }
}
