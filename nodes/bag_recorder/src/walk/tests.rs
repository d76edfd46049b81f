use super::*;
use crate::contents::Channel;
use crate::file::{BagFile, Form, Stamp};
use std::path::PathBuf;

/// Messages of each file; with payloads that do not compress.
const MESSAGES: u64 = 2000;
const PAYLOAD: usize = 1500;

/// A file that goes with its test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("bag_walk_{test}_{}.mcap", std::process::id()));
        Self(path)
    }

    fn write(&self, bytes: &[u8]) -> &Path {
        std::fs::write(&self.0, bytes).unwrap();
        &self.0
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        _ = std::fs::remove_file(&self.0);
    }
}

fn noise(state: &mut u64) -> u8 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    u8::try_from(*state >> 56).unwrap()
}

/// A finished file: message number `n` has the log time `n`, its topic is one of three that begin one after the other.
fn finished(form: Form) -> Vec<u8> {
    let scratch = Scratch::new(&format!("made_{form:?}_{:?}", std::thread::current().id()));
    _ = std::fs::remove_file(&scratch.0);
    let name = scratch.0.file_name().unwrap().to_string_lossy().into_owned();
    let mut file = BagFile::create(&scratch.0, form, 0, name).unwrap();
    let mut state = 1;
    for number in 0..MESSAGES {
        let topic = ["/a", "/b", "/c"][usize::try_from((number / 100).min(2)).unwrap()];
        let channel = Channel {
            topic: topic.to_owned(),
            type_name: "std_msgs/msg/Empty".to_owned(),
            offered_qos: String::new(),
        };
        let payload: Vec<u8> = (0..PAYLOAD).map(|_| noise(&mut state)).collect();
        let stamp = Stamp { log_ns: number, publish_ns: number, sequence: 0 };
        file.write(&channel, "", stamp, &payload).unwrap();
    }
    file.finish().unwrap();
    std::fs::read(&scratch.0).unwrap()
}

/// Log times of the messages that are read, topics that are described, and what the walk found.
fn read(path: &Path) -> (Vec<u64>, usize, Walked) {
    let mut walk = Walk::open(path).unwrap().unwrap();
    let (mut times, mut channels) = (Vec::new(), std::collections::BTreeSet::new());
    while let Some((opcode, fields)) = walk.next_record().unwrap() {
        match mcap::parse_record(opcode, fields).unwrap() {
            mcap::records::Record::Message { header, .. } => times.push(header.log_time),
            mcap::records::Record::Channel(channel) => _ = channels.insert(channel.topic),
            _ => {}
        }
    }
    (times, channels.len(), walk.finish())
}

#[test]
fn a_sound_file_is_read_whole_in_either_form() {
    for form in [Form::Plain, Form::Indexed] {
        let scratch = Scratch::new(&format!("sound_{form:?}"));
        let (times, channels, walked) = read(scratch.write(&finished(form)));
        assert!(times.iter().copied().eq(0..MESSAGES), "{form:?}");
        assert_eq!((channels, walked.stated, walked.sum), (3, Some(MESSAGES), Sum::Fits));
        assert!(walked.is_sound() && walked.lost_bytes == 0 && walked.lost_messages() == Some(0));
    }
}

/// A flipped bit in a chunk costs that chunk and nothing else; what the first chunk alone describes is known from the
/// summary.
#[test]
fn a_chunk_that_does_not_fit_its_checksum_is_left_out_alone() {
    let mut bytes = finished(Form::Indexed);
    for place in [1000, bytes.len() / 2] {
        let scratch = Scratch::new(&format!("chunk_{place}"));
        bytes[place] ^= 1;
        let (times, channels, walked) = read(scratch.write(&bytes));
        bytes[place] ^= 1;
        assert_eq!((channels, walked.ended, walked.damages), (3, Ended::Closed, 1), "{walked:?}");
        let lost = walked.lost_messages().unwrap();
        assert_eq!(lost + times.len() as u64, MESSAGES);
        // A chunk holds about 0.75 MiB of the 3 MB.
        assert!((1..=700).contains(&lost), "{lost}");
        assert_eq!(times.last(), Some(&(MESSAGES - 1)));
        assert!(times.windows(2).all(|pair| pair[0] < pair[1]));
    }
}

/// A page of nothing, of noise, or a wrong length in the midst of plain records: what stands before and behind is read,
/// and at most the records that the damage touches are missing.
#[test]
fn plain_records_are_read_on_both_sides_of_a_damage() {
    let sound = finished(Form::Plain);
    let half = sound.len() / 2;
    // the record around the middle begins with its operation and this length
    let length = (22 + PAYLOAD as u64).to_le_bytes();
    let record = (half..).find(|at| sound[*at] == op::MESSAGE && sound[at + 1..at + 9] == length).unwrap();
    let mut state = 7;
    let page: Vec<u8> = (0..4096).map(|_| noise(&mut state)).collect();
    let huge = u64::MAX.to_le_bytes();
    let longer = (22 + PAYLOAD as u64 + 5000).to_le_bytes();
    for (what, at, piece, most) in [
        ("zeros", half, [0; 4096].as_slice(), 5),
        ("noise", half, page.as_slice(), 5),
        ("no operation", record, [0].as_slice(), 1),
        ("a length beyond the file", record + 1, huge.as_slice(), 1),
        ("a length over other records", record + 1, longer.as_slice(), 1),
        ("a footer", record, [op::FOOTER].as_slice(), 1),
    ] {
        let mut bytes = sound.clone();
        bytes[at..at + piece.len()].copy_from_slice(piece);
        let scratch = Scratch::new(&format!("plain_{}", what.replace(' ', "_")));
        let (times, _, walked) = read(scratch.write(&bytes));
        assert_eq!((walked.ended, walked.sum), (Ended::Closed, Sum::Differs), "{what}: {walked:?}");
        let lost = walked.lost_messages().unwrap();
        assert!((1..=most).contains(&lost) && lost + times.len() as u64 == MESSAGES, "{what}: {walked:?}");
        assert!((1..=2).contains(&walked.damages) && walked.lost_bytes <= 5 * 1600, "{what}: {walked:?}");
        assert_eq!((times[0], times.last()), (0, Some(&(MESSAGES - 1))), "{what}");
    }
}

/// A payload that was changed breaks no record: the checksum of the data alone knows.
#[test]
fn a_changed_payload_is_read_and_told() {
    let mut bytes = finished(Form::Plain);
    let half = bytes.len() / 2;
    let length = (22 + PAYLOAD as u64).to_le_bytes();
    let record = (half..).find(|at| bytes[at + 1..at + 9] == length).unwrap();
    bytes[record + 500] ^= 1;
    let scratch = Scratch::new("payload");
    let (times, _, walked) = read(scratch.write(&bytes));
    assert_eq!((times.len() as u64, walked.damages, walked.sum), (MESSAGES, 0, Sum::Differs));
    assert!(!walked.is_sound());
}

/// The summary alone is damaged: all messages are there, and the file is not sound.
#[test]
fn a_damaged_summary_costs_no_message() {
    for form in [Form::Plain, Form::Indexed] {
        let mut bytes = finished(form);
        let place = bytes.len() - 100;
        bytes[place] ^= 1;
        let scratch = Scratch::new(&format!("summary_{form:?}"));
        let (times, _, walked) = read(scratch.write(&bytes));
        assert_eq!((times.len() as u64, walked.damages, walked.stated), (MESSAGES, 1, None), "{walked:?}");
        assert!(!walked.is_sound());
    }
}

/// Cut anywhere: no damage is told, and no record behind the cut.
#[test]
fn a_cut_file_is_read_up_to_the_cut() {
    for form in [Form::Plain, Form::Indexed] {
        let bytes = finished(form);
        for share in [1, 3, 5, 7] {
            let scratch = Scratch::new(&format!("cut_{form:?}_{share}"));
            let (times, _, walked) = read(scratch.write(&bytes[..bytes.len() * share / 8]));
            assert_eq!((walked.ended, walked.damages, walked.stated), (Ended::Cut, 0, None), "{walked:?}");
            assert!(times.iter().copied().eq(0..times.len() as u64) && walked.lost_bytes > 0);
        }
    }
}

#[test]
fn what_is_no_mcap_file_is_not_walked() {
    let scratch = Scratch::new("none");
    assert!(Walk::open(scratch.write(b"\x89PNG nothing")).unwrap().is_none());
    let (times, _, walked) = read(scratch.write(&MAGIC[..4]));
    assert_eq!((times.len(), walked.ended), (0, Ended::Cut));
}

/// 64 GiB that were never written between two halves of a bag, as a disk leaves them that lost its tables: they are stepped
/// over, at once, and what stands behind them is read.
#[test]
fn what_was_never_written_is_stepped_over() {
    use std::os::unix::fs::FileExt;
    const HOLE: u64 = 64 << 30;
    let bytes = finished(Form::Plain);
    let half = bytes.len() / 2;
    let scratch = Scratch::new("hole");
    scratch.write(&bytes[..half]);
    let file = std::fs::OpenOptions::new().write(true).open(&scratch.0).unwrap();
    file.write_all_at(&bytes[half..], half as u64 + HOLE).unwrap();
    let mut walk = Walk::open(&scratch.0).unwrap().unwrap();
    while walk.next_record().unwrap().is_some() {}
    let walked = walk.finish();
    assert!(walked.messages >= MESSAGES - 2, "{walked:?}");
    assert!(walked.lost_bytes >= HOLE && walked.damages >= 1, "{walked:?}");
}
