use super::*;
use crate::file::Stamp;
use crate::layout::Layout;
use crate::metadata::RunCounts;
use std::path::PathBuf;
use std::sync::Arc;

/// A folder that goes with its test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("bag_recorder_{test}_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&path);
        Self(path)
    }

    fn folder(&self) -> Folder {
        Folder::open(&self.0, "bag", Arc::new(Tally::new(0))).unwrap()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

fn channel() -> Channel {
    Channel { topic: "/a".into(), type_name: "std_msgs/msg/Empty".into(), offered_qos: "- depth: 1".into() }
}

fn stamp(log_ns: u64) -> Stamp {
    Stamp { log_ns, publish_ns: log_ns, sequence: 0 }
}

/// An active file as a killed recorder leaves it: `whole` messages and, of one more, all but `missing` bytes.
fn killed(folder: &Folder, whole: u64, missing: u64) {
    let path = folder.path(&Layout::new("bag").active(0));
    let mut file = BagFile::create(&path, Form::Plain, 0, "bag_0.mcap".into()).unwrap();
    for number in 0..=whole {
        file.write(&channel(), "", stamp(10 + number), &[0; 40]).unwrap();
        file.flush().unwrap();
    }
    let length = std::fs::metadata(&path).unwrap().len();
    std::mem::forget(file); // a killed process writes no footer
    let file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
    file.set_len(length - missing).unwrap();
}

/// Messages of the finished file that is made of the leftover.
fn recovered(folder: &Folder) -> Option<u64> {
    recover(folder, 0, &AtomicBool::new(false)).unwrap().map(|made| made.messages)
}

/// Whatever the byte at which the last record was cut, the whole ones before it are kept: all 5 of 5, never 4.
#[test]
fn every_whole_record_survives_a_cut_anywhere() {
    let record = 1 + 8 + 22 + 40; // operation, length, header of a message, payload
    for missing in 1..=record {
        let scratch = Scratch::new("cut");
        let folder = scratch.folder();
        killed(&folder, 5, missing);
        assert_eq!(recovered(&folder), Some(5), "{missing} bytes missing");
        let contents = read_finished(&folder, 0).unwrap().contents;
        assert_eq!((contents.total(), contents.span_ns), (5, Some((10, 14))));
        assert_eq!(contents.messages.keys().next(), Some(&channel()));
        assert!(!folder.path("bag_0.mcap.active").exists());
    }
}

/// A recovery that is stopped leaves the active file for the next start, and nothing half-made.
#[test]
fn a_stopped_recovery_changes_nothing() {
    let scratch = Scratch::new("stopped");
    let folder = scratch.folder();
    killed(&folder, 5, 1);
    assert_eq!(recover(&folder, 0, &AtomicBool::new(true)).unwrap(), None);
    let survey = folder.survey().unwrap();
    assert_eq!((survey.leftover, survey.finished, survey.stale), (vec![0], vec![], vec![]));
}

/// Killed before the first byte, or in the first ones: an empty file comes out, and recording goes on.
#[test]
fn a_file_of_a_few_bytes_becomes_an_empty_one() {
    for length in [0, 4, 20] {
        let scratch = Scratch::new("short");
        let folder = scratch.folder();
        killed(&folder, 0, 0);
        let file = std::fs::OpenOptions::new().write(true).open(folder.path("bag_0.mcap.active")).unwrap();
        file.set_len(length).unwrap();
        assert_eq!(recovered(&folder), Some(0), "{length} bytes");
    }
}

/// Two recorders in one folder would mend each other's open files.
#[test]
fn a_folder_has_one_recorder() {
    let scratch = Scratch::new("locked");
    let first = scratch.folder();
    let second = Folder::open(&scratch.0, "bag", Arc::new(Tally::new(0)));
    assert!(matches!(second, Err(RecorderError::InUse(_))));
    drop(first);
    scratch.folder();
}

/// T2: an active file that a bad disk has changed anywhere: what comes out is a bag that can be read, or an error; and
/// never more messages than were written. `FDM_MALFORMED_PAYLOADS` sets thirty times how many files are changed.
#[test]
fn a_file_changed_anywhere_becomes_a_sound_one_or_an_error() {
    let wanted = std::env::var("FDM_MALFORMED_PAYLOADS").ok().and_then(|text| text.parse().ok());
    let scratch = Scratch::new("changed");
    let folder = scratch.folder();
    killed(&folder, 5, 0);
    let active = folder.path("bag_0.mcap.active");
    let sound = std::fs::read(&active).unwrap();
    drop(folder);
    let (mut recovered, mut refused, mut messages) = (0_u64, 0_u64, 0_u64);
    for number in 0..wanted.unwrap_or(3000_u64) / 30 {
        let scratch = Scratch::new("changed_copy");
        let folder = scratch.folder();
        std::fs::write(folder.path("bag_0.mcap.active"), changed(&sound, number)).unwrap();
        match recover(&folder, 0, &AtomicBool::new(false)) {
            Ok(made) => {
                recovered += 1;
                let contents = read_finished(&folder, 0).unwrap().contents;
                assert_eq!(Some(contents.total()), made.map(|made| made.messages), "file {number}");
                assert!(contents.total() <= 6, "file {number}");
                messages += contents.total();
            }
            Err(_) => refused += 1,
        }
    }
    println!("{recovered} recovered, {refused} refused");
    // Most changes lie in one message of six, and the file's own beginning is 8 bytes of some 700.
    assert!(recovered > 9 * refused && messages > 4 * recovered, "{recovered}, {refused}, {messages}");
}

/// Flipped bits, lengths that cannot be, or a piece of noise; the same for the same number.
fn changed(sound: &[u8], number: u64) -> Vec<u8> {
    let mut state = number;
    let mut random = move |end: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        usize::try_from(state >> 33).unwrap() % end
    };
    let mut bytes = sound.to_vec();
    let at = random(bytes.len());
    match random(3) {
        0 => (0..=random(6)).for_each(|_| bytes[random(sound.len())] ^= 1 << random(8)),
        1 => {
            let length = [0_u64, 1, 1 << 20, 1 << 40, u64::MAX][random(5)].to_le_bytes();
            bytes.iter_mut().skip(at).zip(length).for_each(|(place, byte)| *place = byte);
        }
        _ => bytes
            .iter_mut()
            .skip(at)
            .take(random(40))
            .for_each(|place| *place = u8::try_from(random(256)).unwrap()),
    }
    bytes
}

/// A plain file becomes an indexed one with the same messages; stopped on the way it stays as it was.
#[test]
fn a_file_is_compacted_as_a_whole_or_not_at_all() {
    let scratch = Scratch::new("compacted");
    let folder = scratch.folder();
    let active = folder.path("bag_0.mcap.active");
    let mut file = BagFile::create(&active, Form::Plain, 0, "bag_0.mcap".into()).unwrap();
    (0..50).for_each(|number| file.write(&channel(), "", stamp(number), &[0; 4000]).unwrap());
    folder.add(file.finish().unwrap()).unwrap();
    let before = read_finished(&folder, 0).unwrap();
    assert!(!before.indexed);
    assert!(!compact(&folder, 0, &AtomicBool::new(true)).unwrap());
    assert_eq!(read_finished(&folder, 0).unwrap(), before);
    assert!(compact(&folder, 0, &AtomicBool::new(false)).unwrap());
    let after = read_finished(&folder, 0).unwrap();
    assert_eq!((after.contents, after.indexed), (before.contents, true));
    assert!(folder.held()[0].bytes < 50 * 4000 / 10, "zeros take little room");
    assert!(folder.survey().unwrap().stale.is_empty());
}

/// What is dropped for room is in no list and on no disk.
#[test]
fn a_dropped_file_is_gone_everywhere() {
    let scratch = Scratch::new("dropped");
    let folder = scratch.folder();
    for number in 0..2 {
        let path = folder.path(&folder.layout().active(number));
        let name = folder.layout().finished(number);
        let mut file = BagFile::create(&path, Form::Plain, number, name).unwrap();
        file.write(&channel(), "", stamp(1), &[0; 40]).unwrap();
        folder.add(file.finish().unwrap()).unwrap();
    }
    folder.keep(1).unwrap();
    assert_eq!(folder.held().iter().map(|file| file.kept).collect::<Vec<_>>(), [false, true]);
    folder.forget(0).unwrap();
    assert!(!folder.path("bag_0.mcap").exists());
    let listed = std::fs::read_to_string(folder.path("metadata.yaml")).unwrap();
    assert!(!listed.contains("bag_0.mcap") && listed.contains("bag_1.mcap"), "{listed}");
    assert_eq!(folder.survey().unwrap().finished, [1]);
}

/// What an earlier run has counted stands in what is described without one.
#[test]
fn counts_of_the_run_outlive_a_recovery() {
    let scratch = Scratch::new("run");
    let run = RunCounts { received: 90, dropped: 7, missed: 3, raised: 2 };
    let folder = Folder::open(&scratch.0, "bag", Arc::new(Tally::after(run))).unwrap();
    killed(&folder, 5, 1);
    assert_eq!(recovered(&folder), Some(5));
    let told = std::fs::read_to_string(folder.path("counts.json")).unwrap();
    let wanted = "\"run\": {\"received\": 90, \"dropped\": 7, \"missed\": 3, \"log_time_raised\": 2}";
    assert!(told.contains(wanted), "{told}");
}

/// A disk that is full is told as such, with what was tried and without what a library says of streams.
#[test]
fn a_full_disk_is_no_fault_of_the_file() {
    let full = || std::io::Error::from(std::io::ErrorKind::StorageFull);
    let path = Path::new("/bags/a_0.mcap.recovering");
    let error = RecorderError::mcap("write to", path)(McapError::Io(full()));
    assert_eq!(error.in_words(), "cannot write to /bags/a_0.mcap.recovering: no storage space");
    assert!(error.is_full_disk() && !error.is_of_source());
    let error = RecorderError::mcap("read", path)(McapError::BadMagic);
    assert!(error.is_of_source() && !error.is_full_disk());
    assert!(RecorderError::file("sync", path)(full()).is_full_disk());
}
