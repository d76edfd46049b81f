use super::*;
use std::path::{Path, PathBuf};

/// A folder that goes with its test.
struct Scratch(PathBuf);

impl Drop for Scratch {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

fn scratch(test: &str) -> Scratch {
    let path = std::env::temp_dir().join(format!("bag_writer_{test}_{}", std::process::id()));
    _ = std::fs::remove_dir_all(&path);
    Scratch(path)
}

const ROOM: Room = Room { bag_bytes: None, free_bytes: 0, keep_severity: 2 };

fn start(path: &Path, change: impl FnOnce(&mut Settings)) -> (Recorder, Arc<Tally>) {
    let (recorder, tally) = try_start(path, change);
    (recorder.unwrap(), tally)
}

fn try_start(
    path: &Path,
    change: impl FnOnce(&mut Settings),
) -> (Result<Recorder, RecorderError>, Arc<Tally>) {
    let tally = Arc::new(Tally::new(1));
    let channel =
        Channel { topic: "/a".into(), type_name: "std_msgs/msg/Empty".into(), offered_qos: String::new() };
    let mut settings = Settings {
        topics: vec![Recorded { channel, schema: String::new() }],
        tally: Arc::clone(&tally),
        note: BTreeMap::new(),
        queue_length: 10_000,
        sync_period: Duration::from_millis(50),
        late_max: Seconds(1.0),
        split: Split { span_ns: None, bytes: None },
        room: ROOM,
        snapshot: Snapshot { span_ns: 0, bytes: 1 << 20 },
        compact_end: Duration::from_secs(30),
    };
    change(&mut settings);
    let folder = Folder::open(path, "bag", Arc::clone(&tally)).unwrap();
    (Recorder::start(folder, settings), tally)
}

/// Hands over messages of 1 kB at 10 Hz from second `from` on.
fn send(recorder: &Recorder, from: u32, count: u32) {
    for number in 0..count {
        let received = Seconds(f64::from(from) + f64::from(number) * 0.1);
        let sample =
            Sample { topic: 0, received, publish_ns: None, sequence: number, payload: vec![0; 1000] };
        assert!(recorder.queue().offer(Item::Message(sample)));
    }
}

fn wish(recorder: &Recorder, wish: Wish) {
    assert!(recorder.queue().offer(Item::Wish(wish)));
}

/// A bag that was closed, and one that a kill left, takes no times of another clock; who does not say is taken as before.
#[test]
fn a_bag_has_one_clock() {
    let folder = scratch("one_clock");
    let on = |kind: &str| {
        let note = BTreeMap::from([(clock::CLOCK.to_owned(), kind.to_owned())]);
        try_start(&folder.0, |settings| settings.note = note).0
    };
    let first = on("simulated").unwrap();
    send(&first, 10, 5);
    first.finish().unwrap();
    let refused = on("monotonic").map(drop).unwrap_err().to_string();
    let file = folder.0.join("bag_0.mcap").display().to_string();
    assert!(refused.starts_with(&format!("{file}: its times are of the simulated clock")), "{refused}");
    assert!(refused.ends_with("(fdm record --use-sim-time=true)"), "{refused}");
    std::fs::rename(&file, format!("{file}.active")).unwrap();
    let refused = on("monotonic").map(drop).unwrap_err().to_string();
    assert!(refused.starts_with(&format!("{file}.active: ")), "{refused}");
    for kind in ["simulated", "simulated"] {
        on(kind).unwrap().finish().unwrap();
    }
    try_start(&folder.0, |_| {}).0.unwrap().finish().unwrap();
}

/// What may change while the node is active: the files that follow end by it, and nothing is lost.
#[test]
fn a_bag_is_split_by_other_limits_once_they_are_asked_for() {
    let folder = scratch("other_limits");
    let (recorder, tally) = start(&folder.0, |_| {});
    send(&recorder, 10, 60);
    wish(&recorder, Wish::SplitBy(Split { span_ns: Some(2_000_000_000), bytes: None }));
    send(&recorder, 16, 30);
    recorder.finish().unwrap();
    // The first file is over at once; then 20 messages are 2 s.
    assert_eq!(files(&folder.0), [(0, 60), (1, 20), (2, 10)]);
    assert_eq!((tally.written(), tally.dropped()), (90, 0));
}

/// Number and messages of each finished file; all are indexed where the recorder had time.
fn files(path: &Path) -> Vec<(u32, u64)> {
    let folder = Folder::open(path, "bag", Arc::new(Tally::new(0))).unwrap();
    let survey = folder.survey().unwrap();
    assert!(survey.leftover.is_empty(), "{survey:?}");
    let read = |number: &u32| {
        let finished = recovery::read_finished(&folder, *number).unwrap();
        assert!(finished.indexed, "file {number}");
        (*number, finished.contents.total())
    };
    survey.finished.iter().map(read).collect()
}

/// 95 messages, 0.1 s apart, in files of 3 s: 30, 30, 30 and 5; by size, 20 480 bytes of 1031 each: 20 a file.
#[test]
fn a_bag_is_split_by_time_and_by_size_and_loses_nothing() {
    let by_time = scratch("time");
    let (recorder, tally) = start(&by_time.0, |settings| settings.split.span_ns = Some(3_000_000_000));
    send(&recorder, 10, 95);
    recorder.finish().unwrap();
    assert_eq!(files(&by_time.0), [(0, 30), (1, 30), (2, 30), (3, 5)]);
    assert_eq!((tally.written(), tally.compacted.get()), (95, 4));

    let by_size = scratch("size");
    let (recorder, _) = start(&by_size.0, |settings| settings.split.bytes = Some(20_480));
    send(&recorder, 10, 50);
    recorder.finish().unwrap();
    assert_eq!(files(&by_size.0), [(0, 20), (1, 20), (2, 10)]);
}

/// Paused, nothing is written; an event writes the last 2 s (21 messages) to a file of their own that is kept; what comes
/// after a resume is written, what came before is not.
#[test]
fn a_snapshot_holds_the_last_seconds() {
    let folder = scratch("snapshot");
    let (recorder, tally) = start(&folder.0, |settings| settings.snapshot.span_ns = 2_000_000_000);
    wish(&recorder, Wish::Pause);
    send(&recorder, 10, 100);
    wish(&recorder, Wish::Keep);
    send(&recorder, 20, 5);
    wish(&recorder, Wish::Resume);
    send(&recorder, 21, 7);
    recorder.finish().unwrap();
    assert_eq!(files(&folder.0), [(0, 21), (1, 7)]);
    assert!(folder.0.join("bag_0.mcap.keep").exists() && !folder.0.join("bag_1.mcap.keep").exists());
    assert_eq!((tally.passed_over.get(), tally.written()), (105, 28));
}

/// Paused, with an event behind every message for 12 s: one kept file for each 2 s at most, and none of what they are about
/// is missing. What the last events asked for is written before a resume, and before the end.
#[test]
fn many_events_make_few_snapshots() {
    for resumed in [true, false] {
        let folder = scratch("events");
        let (recorder, tally) = start(&folder.0, |settings| settings.snapshot.span_ns = 2_000_000_000);
        wish(&recorder, Wish::Pause);
        send(&recorder, 10, 100);
        wish(&recorder, Wish::Keep);
        for number in 0..12 {
            for tenth in 0..10 {
                let received = Seconds(f64::from(20 + number) + f64::from(tenth) * 0.1);
                let sample =
                    Sample { topic: 0, received, publish_ns: None, sequence: 0, payload: vec![0; 1000] };
                assert!(recorder.queue().offer(Item::Message(sample)));
                wish(&recorder, Wish::Keep);
            }
        }
        if resumed {
            wish(&recorder, Wish::Resume);
        }
        recorder.finish().unwrap();
        // Behind a snapshot an empty file begins.
        let files: Vec<_> = files(&folder.0).into_iter().filter(|(_, messages)| *messages > 0).collect();
        // The first 21 messages, and 120 in files of 2 s.
        assert!((6..=8).contains(&files.len()), "{files:?}");
        assert_eq!(files.iter().map(|(_, messages)| messages).sum::<u64>(), 21 + 120, "{files:?}");
        assert_eq!(tally.kept.get(), files.len() as u64);
    }
}

/// With room for little the oldest files go, those with an event and the one before it stay, and what is written goes on.
#[test]
fn the_oldest_file_goes_and_what_an_event_marks_stays() {
    let folder = scratch("room");
    let (recorder, tally) = start(&folder.0, |settings| {
        settings.split.span_ns = Some(1_000_000_000);
        settings.room = Room { bag_bytes: Some(1), ..ROOM };
    });
    send(&recorder, 10, 25);
    wish(&recorder, Wish::Keep); // in the third file
    send(&recorder, 13, 30);
    recorder.finish().unwrap();
    let left: Vec<u32> = files(&folder.0).iter().map(|(number, _)| *number).collect();
    assert!(left.contains(&1) && left.contains(&2), "{left:?}");
    assert!(!left.contains(&0) && !left.contains(&3), "{left:?}");
    assert_eq!((tally.written(), tally.kept.get()), (55, 2));
    assert!(tally.forgotten.get() >= 2);
    let listed = std::fs::read_to_string(folder.0.join("metadata.yaml")).unwrap();
    assert!(!listed.contains("bag_0.mcap") && listed.contains("bag_1.mcap"), "{listed}");
}

/// A disk that is nearly full with nothing to drop is told at once; the writer itself goes on.
#[test]
fn a_nearly_full_disk_is_told() {
    let folder = scratch("full");
    let (recorder, tally) = start(&folder.0, |settings| settings.room.free_bytes = u64::MAX);
    send(&recorder, 10, 5);
    recorder.finish().unwrap();
    assert!(tally.full.load(Ordering::Relaxed));
    // The file that was being written may go once it is closed; then nothing of it is left, and it is counted.
    let left = files(&folder.0);
    assert_eq!(left.len() as u64 + tally.forgotten.get(), 1, "{left:?}");
    assert!(left.iter().all(|file| *file == (0, 5)), "{left:?}");
    assert_eq!((tally.written(), tally.dropped()), (5, 0));
    let listed = std::fs::read_to_string(folder.0.join("metadata.yaml")).unwrap();
    assert_eq!(listed.contains("bag_0.mcap"), !left.is_empty(), "{listed}");
}
