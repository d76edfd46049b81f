//! A bag that is being written, as who waits for it sees it: its newest file, record by record, from where it was seen last.

use mcap::records::op;
use runtime::topics;
use std::collections::BTreeSet;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

/// Where the first record begins `[byte]`.
const FIRST: u64 = 8;
/// Operation and length in front of a record `[byte]`.
const HEAD: usize = 9;
/// As much of a channel's record as holds its topic's name `[byte]`.
const CHANNEL_MAX: u64 = 4096;
/// Ending of the file that is being written.
const ACTIVE: &str = ".mcap.active";
/// What a recorder hears of itself.
const OWN: [&str; 5] = [
    topics::HEARTBEAT.name(),
    topics::DIAGNOSTICS.name(),
    topics::ROSOUT.name(),
    topics::PARAMETER_EVENTS.name(),
    "transition_event",
];

/// What a recorder has written since it was started.
#[derive(Debug, Default)]
pub(super) struct Watched {
    file: Option<(PathBuf, File)>,
    /// Where the next record begins.
    at: u64,
    /// Bytes of the files before.
    before: u64,
    /// Channels of the file of which a recorder hears its own words alone.
    own: BTreeSet<[u8; 2]>,
    pub(super) messages: u64,
    /// Those of others.
    pub(super) others: u64,
}

impl Watched {
    /// Takes in what was written since the last look. What cannot be read yet is read the next time.
    pub(super) fn look(&mut self, bag: &Path) {
        let newest = newest(bag);
        self.read();
        if let Some(newest) =
            newest.filter(|newest| self.file.as_ref().is_none_or(|(path, _)| path != newest))
            && let Ok(file) = File::open(&newest)
        {
            (self.before, self.at) = (self.bytes(), FIRST);
            self.own.clear();
            self.file = Some((newest, file));
            self.read();
        }
    }

    pub(super) fn bytes(&self) -> u64 {
        self.before + self.at
    }

    fn read(&mut self) {
        let Some((_, file)) = &self.file else { return };
        // A file that was finished meanwhile is still open here.
        let size = file.metadata().map_or(0, |found| found.len());
        let mut head = [0; HEAD];
        while file.read_exact_at(&mut head, self.at).is_ok() {
            let [opcode, length @ ..] = head;
            let fields = self.at + HEAD as u64;
            let Some(next) = fields.checked_add(u64::from_le_bytes(length)).filter(|next| *next <= size)
            else {
                break;
            };
            let mut id = [0; 2];
            match opcode {
                op::DATA_END => break,
                op::MESSAGE if file.read_exact_at(&mut id, fields).is_ok() => {
                    self.messages += 1;
                    self.others += u64::from(!self.own.contains(&id));
                }
                op::CHANNEL if is_own(file, fields..next.min(fields + CHANNEL_MAX), &mut id) => {
                    self.own.insert(id);
                }
                _ => {}
            }
            self.at = next;
        }
    }
}

/// Whether a recorder hears itself on a channel; and the channel's number.
fn is_own(file: &File, fields: std::ops::Range<u64>, id: &mut [u8; 2]) -> bool {
    let mut bytes = vec![0; usize::try_from(fields.end - fields.start).unwrap_or(0)];
    if file.read_exact_at(&mut bytes, fields.start).is_err() {
        return false;
    }
    // Number, number of its schema, and its topic behind a length.
    let topic = (|| {
        *id = *bytes.first_chunk()?;
        let length = u32::from_le_bytes(*bytes.get(4..)?.first_chunk()?);
        bytes.get(8..8 + usize::try_from(length).ok()?)
    })();
    topic.is_some_and(|topic| OWN.iter().any(|own| topic.ends_with(own.as_bytes())))
}

/// The file that is being written: that of the highest number, where a kill has left others.
fn newest(bag: &Path) -> Option<PathBuf> {
    let files = std::fs::read_dir(bag).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    let number = |path: &PathBuf| {
        let name = path.file_name()?.to_str()?.strip_suffix(ACTIVE)?;
        name.rsplit_once('_')?.1.parse::<u32>().ok()
    };
    files.filter_map(|path| Some((number(&path)?, path))).max().map(|(_, path)| path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use mcap::records::MessageHeader;
    use std::collections::BTreeMap;

    /// Written on while it is looked at, begun anew, and closed: each message is counted once, and a recorder's own words tell
    /// of nobody else.
    #[test]
    fn messages_are_counted_as_they_are_written() {
        let folder = std::env::temp_dir().join(format!("fdm_watched_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let path = |number: u32| folder.join(format!("bag_{number}.mcap.active"));
        let write = |number: u32, topics: &[&str]| {
            let options = mcap::WriteOptions::new().use_chunks(false);
            let mut writer = options.create(File::create(path(number)).unwrap()).unwrap();
            for topic in topics {
                let channel_id = writer.add_channel(0, topic, "cdr", &BTreeMap::new()).unwrap();
                let header = MessageHeader { channel_id, sequence: 0, log_time: 1, publish_time: 1 };
                writer.write_to_known_channel(&header, &[0; 50]).unwrap();
            }
            writer.finish().unwrap();
        };
        let mut watched = Watched::default();
        watched.look(&folder);
        assert_eq!((watched.messages, watched.bytes()), (0, 0));
        write(9, &["/printer/heartbeat", "/diagnostics", "/rosout"]);
        let whole = std::fs::read(path(9)).unwrap();
        // In the midst of the second message.
        std::fs::write(path(9), &whole[..whole.len() * 2 / 5]).unwrap();
        watched.look(&folder);
        let begun = watched.messages;
        std::fs::write(path(9), &whole).unwrap();
        watched.look(&folder);
        assert!(begun < 3 && (watched.messages, watched.others) == (3, 0), "{begun}, {watched:?}");
        std::fs::rename(path(9), folder.join("bag_9.mcap")).unwrap();
        write(10, &["/printer/printer/state", "/printer/heartbeat"]);
        watched.look(&folder);
        assert_eq!((watched.messages, watched.others), (5, 1));
        watched.look(&folder);
        assert_eq!(watched.messages, 5);
        std::fs::remove_dir_all(folder).unwrap();
    }
}
