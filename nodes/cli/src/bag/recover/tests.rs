use super::*;
use bag_recorder::contents::Channel;
use bag_recorder::file::{BagFile, Form, Stamp};
use std::collections::BTreeMap;

/// A folder with finished files of these names that goes with its test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(test: &str, names: &[&str]) -> Self {
        let path = std::env::temp_dir().join(format!("fdm_recover_{test}_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        for name in names {
            finished(&path.join(name));
        }
        Self(path)
    }

    /// Names and bytes of all files.
    fn all(&self) -> BTreeMap<String, Vec<u8>> {
        let entries = std::fs::read_dir(&self.0).unwrap().map(|entry| entry.unwrap());
        entries
            .map(|entry| (entry.file_name().into_string().unwrap(), std::fs::read(entry.path()).unwrap()))
            .collect()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A whole file with an index.
fn finished(path: &Path) {
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    let mut file = BagFile::create(&path.with_extension("made"), Form::Indexed, 0, name).unwrap();
    let (topic, type_name) = ("/a".to_owned(), "std_msgs/msg/Empty".to_owned());
    let channel = Channel { topic, type_name, offered_qos: String::new() };
    for number in 0..100 {
        let stamp = Stamp { log_ns: number, publish_ns: number, sequence: 0 };
        file.write(&channel, "", stamp, &[7; 500]).unwrap();
    }
    file.finish().unwrap();
}

/// Files of a second bag, or of another form, would be missing in what is said of the first.
#[test]
fn a_folder_with_files_of_two_bags_is_refused_and_left_as_it_is() {
    for other in ["b_0.mcap", "a_007.mcap", "other.mcap", "a_1.db3", "a_1.mcap.zstd"] {
        let scratch = Scratch::new("two", &["a_0.mcap", other]);
        let before = scratch.all();
        let error = recover(&scratch.0).unwrap_err().to_string();
        assert!(error.contains("one bag a folder"), "{other}: {error}");
        assert_eq!(scratch.all(), before, "{other}");
    }
}

/// A sound bag of another program: not a byte of it changes. A damaged one: what it says of itself is kept beside.
#[test]
fn what_another_program_says_of_its_bag_is_kept() {
    let scratch = Scratch::new("other", &["a_0.mcap", "a_1.mcap"]);
    std::fs::write(scratch.0.join("metadata.yaml"), "custom_data: {printer: left}").unwrap();
    let before = scratch.all();
    assert_eq!(recover(&scratch.0).unwrap().messages, 200);
    assert_eq!(scratch.all(), before);

    let file = scratch.0.join("a_1.mcap");
    let length = std::fs::metadata(&file).unwrap().len();
    std::fs::OpenOptions::new().write(true).open(&file).unwrap().set_len(length / 2).unwrap();
    recover(&scratch.0).unwrap();
    let after = scratch.all();
    assert_eq!(after["metadata.yaml.before"], before["metadata.yaml"]);
    let told = String::from_utf8_lossy(&after["metadata.yaml"]);
    assert!(told.contains("a_0.mcap") && told.contains("a_1.mcap"), "{told}");
    assert_eq!(after["a_0.mcap"], before["a_0.mcap"]);
}

/// One file of encoding json among the others: it stays as it is and is named, and the damaged file of ours is mended.
#[test]
fn a_file_with_what_mending_would_lose_is_left_as_it_is() {
    let scratch = Scratch::new("json", &["a_0.mcap"]);
    let file = scratch.0.join("a_0.mcap");
    let length = std::fs::metadata(&file).unwrap().len();
    std::fs::OpenOptions::new().write(true).open(&file).unwrap().set_len(length / 2).unwrap();
    let mut writer = mcap::Writer::new(std::fs::File::create(scratch.0.join("a_1.mcap")).unwrap()).unwrap();
    let channel = writer.add_channel(0, "/j", "json", &BTreeMap::new()).unwrap();
    let header =
        mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: 1, publish_time: 1 };
    writer.write_to_known_channel(&header, b"{}").unwrap();
    writer.finish().unwrap();
    let before = scratch.all();
    let figures = recover(&scratch.0).unwrap();
    let [ours, other] = &figures.files[..] else { panic!("{figures:?}") };
    assert_eq!((ours.outcome, other.outcome, other.is_mended()), ("recovered", "foreign", false));
    let holds = "a_1.mcap: holds messages of /j of encoding 'json', which would be lost";
    assert!(other.why.contains(holds), "{}", other.why);
    let after = scratch.all();
    assert_eq!((&after["a_1.mcap"], &after["a_0.mcap.torn"]), (&before["a_1.mcap"], &before["a_0.mcap"]));
    let told = String::from_utf8_lossy(&after["metadata.yaml"]);
    assert!(told.contains("a_0.mcap") && told.contains("a_1.mcap"), "{told}");
    assert!(messages(&scratch.0).is_err(), "who asks for the bag hears of it");
}

/// A bag's counts: of the run that wrote it, and of each file.
fn counts(scratch: &Scratch, files: &str) {
    let run = "{\"received\": 210, \"dropped\": 7, \"missed\": 3, \"log_time_raised\": 1}";
    let text = format!("{{\"state\": \"closed\", \"messages\": 200, \"files\": {files}, \"run\": {run}}}");
    std::fs::write(scratch.0.join("counts.json"), text).unwrap();
}

/// What the recorder dropped and missed is not made unseen by a recovery, neither of a sound bag nor of one that is mended.
#[test]
fn the_counts_of_the_run_stay() {
    for length in [None, Some(2)] {
        let scratch = Scratch::new("run", &["a_0.mcap"]);
        counts(&scratch, "{\"a_0.mcap\": 100}");
        if let Some(part) = length {
            let file = std::fs::OpenOptions::new().write(true).open(scratch.0.join("a_0.mcap")).unwrap();
            file.set_len(file.metadata().unwrap().len() / part).unwrap();
        }
        recover(&scratch.0).unwrap();
        let run = Stated::of(&scratch.0).counts.unwrap().run;
        let told = (run.received, run.dropped, run.missed, run.log_time_raised);
        assert_eq!(told, (210, 7, 3, 1), "{length:?}");
    }
}

/// A file that was cut off, down to its first bytes, does not say itself how many messages it had: the bag's description does.
#[test]
fn what_a_torn_end_has_lost_is_told() {
    for length in [8, 60] {
        let scratch = Scratch::new("lost", &["a_0.mcap", "a_1.mcap"]);
        counts(&scratch, "{\"a_0.mcap\": 100, \"a_1.mcap\": 100}");
        let file = std::fs::OpenOptions::new().write(true).open(scratch.0.join("a_1.mcap")).unwrap();
        file.set_len(length).unwrap();
        let figures = recover(&scratch.0).unwrap();
        let left = figures.files[1].messages.unwrap();
        assert!(left < 100 && figures.messages == 100 + left, "{figures:?}");
        assert_eq!((figures.lost_messages, figures.files[1].lost_messages), (100 - left, Some(100 - left)));
        assert!(figures.files[1].why.contains("told of 100 messages"), "{}", figures.files[1].why);
        assert_eq!(figures.files[0].lost_messages, Some(0));
    }
}

/// A full disk says nothing of the file.
#[test]
fn what_cannot_be_written_is_not_called_unreadable() {
    let scratch = Scratch::new("full", &["a_0.mcap"]);
    let folder = Folder::open(&scratch.0, "a", Arc::new(Tally::new(0))).unwrap();
    let sources = [scratch.0.join("a_0.mcap")];
    let full = std::io::Error::from_raw_os_error(28);
    let error = RecorderError::mcap("write to", &sources[0])(mcap::McapError::Io(full));
    let File { outcome, why, .. } = failed_of(&error, &folder, &sources);
    assert_eq!(outcome, "unwritten");
    for part in
        ["cannot write to", "No space left on device", "up to 1 MiB are needed", "are free", "as it was"]
    {
        assert!(why.contains(part), "{part}: {why}");
    }
    let unread = RecorderError::mcap("read", &sources[0])(mcap::McapError::BadMagic);
    assert_eq!(failed_of(&unread, &folder, &sources).outcome, "unreadable");
}
