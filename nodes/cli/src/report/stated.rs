//! What stands beside the files of a bag and describes them: `counts.json` of our recorder, `metadata.yaml` of any.

use super::bag::Counts;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

/// What a folder says of its bag.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Stated {
    /// What our recorder counted, where it left `counts.json`.
    pub(crate) counts: Option<Counts>,
    /// Messages of all files by `metadata.yaml`.
    pub(crate) messages: Option<u64>,
    /// Messages of each file by `metadata.yaml`.
    files: BTreeMap<String, u64>,
    /// What of it cannot be read, and why.
    pub(crate) broken: Vec<String>,
}

/// `metadata.yaml` as rosbag2 writes it, as far as it counts.
#[derive(serde::Deserialize)]
struct Metadata {
    rosbag2_bagfile_information: Information,
}

#[derive(serde::Deserialize)]
struct Information {
    message_count: u64,
    #[serde(default)]
    files: Vec<File>,
}

#[derive(serde::Deserialize)]
struct File {
    path: String,
    message_count: u64,
}

/// Longest reason that is told `[character]`: it may hold what stands in the file.
const REASON_MAX: usize = 200;

impl Stated {
    /// Reads what stands in a folder.
    pub(crate) fn of(folder: &Path) -> Self {
        let mut stated = Self::default();
        match runtime::input::text(&folder.join("counts.json")) {
            Ok(text) => match serde_json::from_str(&text) {
                Ok(counts) => stated.counts = Some(counts),
                Err(error) => stated.cannot_read("counts.json", &error.to_string()),
            },
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => stated.cannot_read("counts.json", &error.to_string()),
        }
        let metadata = folder.join("metadata.yaml");
        if std::fs::symlink_metadata(&metadata).is_err() {
            return stated;
        }
        match runtime::params::from_yaml::<Metadata>(&metadata) {
            Ok(Metadata { rosbag2_bagfile_information: Information { message_count, files } }) => {
                stated.messages = Some(message_count);
                stated.files = files.into_iter().map(|file| (file.path, file.message_count)).collect();
            }
            Err(error) => stated.cannot_read("metadata.yaml", &error.to_string()),
        }
        stated
    }

    /// Messages that a finished file had when it was described.
    pub(crate) fn of_file(&self, name: &str) -> Option<u64> {
        let counted = self.counts.as_ref().and_then(|counts| counts.files.get(name));
        counted.or_else(|| self.files.get(name)).copied()
    }

    fn cannot_read(&mut self, name: &str, reason: &str) {
        // The name stands in front already.
        let reason = reason.rsplit_once(&format!("{name}:")).map_or(reason, |(_, rest)| rest.trim_start());
        let line = if reason.starts_with(|first: char| first.is_ascii_digit()) { "line " } else { "" };
        let letter = |letter: char| if letter.is_control() { ' ' } else { letter };
        let reason: String = reason.chars().map(letter).take(REASON_MAX).collect();
        self.broken.push(format!("{name} cannot be read: {line}{reason}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Garbage, nothing, depth and repetition: each is told in one line, and nothing is believed of it.
    #[test]
    fn a_description_that_cannot_be_read_is_told() {
        let folder = std::env::temp_dir().join(format!("fdm_stated_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        assert_eq!(Stated::of(&folder), Stated::default(), "nothing stands there");
        let mut bomb = "a0: &x0 [0, 0]\n".to_owned();
        for level in 1..40 {
            bomb += &format!("a{level}: &x{level} [*x{0}, *x{0}]\n", level - 1);
        }
        let deep = "[".repeat(200_000);
        let wrong = "rosbag2_bagfile_information: {message_count: many}";
        for name in ["metadata.yaml", "counts.json"] {
            for text in
                ["", "\u{1b}[31m\n]", deep.as_str(), bomb.as_str(), wrong, "rosbag2_bagfile_information:"]
            {
                // Whatever a JSON object says, missing counts are none.
                std::fs::write(folder.join(name), text).unwrap();
                let stated = Stated::of(&folder);
                let [told] = &stated.broken[..] else { panic!("{name} {text:.40}: {stated:?}") };
                assert!(told.starts_with(&format!("{name} cannot be read: ")), "{told}");
                assert!(told.len() < 400 && !told.contains(char::is_control), "{told}");
                assert_eq!((&stated.counts, stated.messages), (&None, None));
            }
            std::fs::remove_file(folder.join(name)).unwrap();
        }
        std::fs::remove_dir_all(folder).unwrap();
    }

    /// A file's count by our recorder counts before the one by `metadata.yaml`.
    #[test]
    fn what_is_described_is_read() {
        let folder = std::env::temp_dir().join(format!("fdm_described_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let metadata = "rosbag2_bagfile_information:\n  version: 9\n  message_count: 12\n  files:\n    - path: \"a_0.mcap\"\n      message_count: 12\n";
        std::fs::write(folder.join("metadata.yaml"), metadata).unwrap();
        let stated = Stated::of(&folder);
        assert_eq!(
            (stated.messages, stated.of_file("a_0.mcap"), stated.broken.len()),
            (Some(12), Some(12), 0)
        );
        let counts = "{\"messages\": 10, \"files\": {\"a_0.mcap\": 10}, \"run\": {\"dropped\": 7}}";
        std::fs::write(folder.join("counts.json"), counts).unwrap();
        let stated = Stated::of(&folder);
        assert_eq!((stated.of_file("a_0.mcap"), stated.of_file("a_1.mcap")), (Some(10), None));
        assert_eq!(stated.counts.unwrap().run.dropped, 7);
        std::fs::remove_dir_all(folder).unwrap();
    }
}
