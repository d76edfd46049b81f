//! Bags that another program wrote.

use super::super::{Recovered, recover, salvage};
use super::*;
use crate::file::Form;
use crate::folder::Folder;
use crate::tally::Tally;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, Summary, WriteOptions};
use std::fs::File;
use std::path::PathBuf;
use std::sync::Arc;

/// Messages of each file.
const MESSAGES: u64 = 500;

/// A folder that goes with its test.
struct Scratch(PathBuf);

impl Scratch {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("bag_copy_{test}_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&path);
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn folder(&self) -> Folder {
        Folder::open(&self.0, "bag", Arc::new(Tally::new(0))).unwrap()
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.0);
    }
}

fn metadata() -> BTreeMap<String, String> {
    BTreeMap::from([("callerid".to_owned(), "/other".to_owned())])
}

/// What does not compress: the middle of a file lies in a chunk.
fn noise(state: &mut u64) -> u8 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    u8::try_from(*state >> 56).unwrap()
}

/// A file with what a recorder of ours never writes; messages of 1 kB in chunks of 64 KiB.
fn foreign(path: &Path, compression: Compression, encoding: &str, private: bool) {
    let options = WriteOptions::new().compression(Some(compression)).chunk_size(Some(1 << 16));
    let mut writer = options.create(File::create(path).unwrap()).unwrap();
    writer
        .attach(&Attachment {
            log_time: 3,
            create_time: 4,
            name: "calibration.txt".to_owned(),
            media_type: "text/plain".to_owned(),
            data: b"f = 1".as_slice().into(),
        })
        .unwrap();
    if private {
        writer.write_private_record(0x90, b"mine", Default::default()).unwrap();
    }
    let schema = writer.add_schema("a/msg/T", "ros2idl", b"module a {};").unwrap();
    let with = writer.add_channel(schema, "/a", encoding, &metadata()).unwrap();
    let without = writer.add_channel(0, "/b", encoding, &BTreeMap::new()).unwrap();
    let mut state = 1;
    for number in 0..MESSAGES {
        let channel_id = if number % 2 == 0 { with } else { without };
        let header = MessageHeader { channel_id, sequence: 0, log_time: number, publish_time: number };
        let payload: Vec<u8> = (0..1000).map(|_| noise(&mut state)).collect();
        writer.write_to_known_channel(&header, &payload).unwrap();
    }
    let note = Metadata { name: "theirs".to_owned(), metadata: metadata() };
    writer.write_metadata(&note).unwrap();
    writer.finish().unwrap();
}

/// What a damaged file of another program says of its messages, its attachments and its notes is in the mended one too, and
/// the damaged one stands beside.
#[test]
fn what_another_program_wrote_is_kept() {
    let scratch = Scratch::new("kept");
    let file = scratch.file("bag_0.mcap");
    foreign(&file, Compression::Zstd, "cdr", false);
    let mut damaged = std::fs::read(&file).unwrap();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    std::fs::write(&file, &damaged).unwrap();
    let Recovered { messages, walked } =
        salvage(&scratch.folder(), 0, &AtomicBool::new(false)).unwrap().unwrap();
    assert!(walked.damages == 1 && messages > MESSAGES / 2 && messages < MESSAGES, "{messages}: {walked:?}");
    assert_eq!(std::fs::read(scratch.file("bag_0.mcap.torn")).unwrap(), damaged);

    let bytes = std::fs::read(&file).unwrap();
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let channel = |topic| summary.channels.values().find(|channel| channel.topic == topic).unwrap();
    let (with, without) = (channel("/a"), channel("/b"));
    let schema = with.schema.as_ref().unwrap();
    assert_eq!(
        (schema.name.as_str(), schema.encoding.as_str(), &*schema.data),
        ("a/msg/T", "ros2idl", b"module a {};".as_slice())
    );
    assert_eq!((&with.metadata, without.schema.is_none(), without.metadata.len()), (&metadata(), true, 0));
    let attached = mcap::read::attachment(&bytes, &summary.attachment_indexes[0]).unwrap();
    assert_eq!(
        (attached.name.as_str(), attached.log_time, attached.create_time, &*attached.data),
        ("calibration.txt", 3, 4, b"f = 1".as_slice())
    );
    let note = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).unwrap();
    assert_eq!((note.name.as_str(), note.metadata), ("theirs", metadata()));
}

/// What could not be copied is found before anything is changed.
#[test]
fn what_a_copy_would_lose_is_refused() {
    let scratch = Scratch::new("lost");
    let file = scratch.file("bag_0.mcap");
    let told = |encoding, private| {
        foreign(&file, Compression::Zstd, encoding, private);
        look(&file).map(|walked| walked.messages).map_err(|error| error.to_string())
    };
    assert_eq!(told("cdr", false), Ok(MESSAGES));
    let json = told("json", false).unwrap_err();
    assert!(json.contains("messages of /a of encoding 'json', which would be lost"), "{json}");
    let private = told("cdr", true).unwrap_err();
    assert!(private.contains("records of private use, with operation 0x90"), "{private}");
}

/// A file of ours in the plain form: 50 messages.
fn ours(path: &Path) {
    let mut file =
        BagFile::create(&path.with_extension("made"), Form::Plain, 0, "bag_0.mcap".into()).unwrap();
    file.note(&Metadata { name: NOTE.to_owned(), metadata: metadata() }).unwrap();
    let (topic, type_name) = ("/a".to_owned(), "a/msg/T".to_owned());
    let channel = Channel { topic, type_name, offered_qos: String::new() };
    for number in 0..50 {
        let stamp = Stamp { log_ns: number, publish_ns: number, sequence: 0 };
        file.write(&channel, "", stamp, &[7; 40]).unwrap();
    }
    file.finish().unwrap();
    std::fs::rename(path.with_file_name("bag_0.mcap"), path).unwrap();
}

/// Where the messages of a file of [`ours`] begin: operation, and a length of 22 and 40 bytes.
fn places(bytes: &[u8]) -> Vec<usize> {
    let head = [5, 62, 0, 0, 0, 0, 0, 0, 0];
    (0..bytes.len()).filter(|at| bytes[*at..].starts_with(&head)).collect()
}

/// One bit of a file of ours that makes a message a record of private use, or one of a channel that there is not: all
/// others are saved, and the damage is seen before anything is done.
#[test]
fn a_flipped_bit_costs_a_message_and_not_the_file() {
    let scratch = Scratch::new("bit");
    let file = scratch.file("bag_0.mcap");
    for (offset, bit) in [(0, 0x80), (10, 0x40)] {
        ours(&file);
        let mut bytes = std::fs::read(&file).unwrap();
        let messages = places(&bytes);
        assert_eq!(messages.len(), 50);
        bytes[messages[20] + offset] ^= bit;
        std::fs::write(&file, &bytes).unwrap();
        let walked = look(&file).unwrap();
        assert!(!walked.is_sound() && walked.damages == 1 && walked.messages == 49, "{walked:?}");
        let made = salvage(&scratch.folder(), 0, &AtomicBool::new(false)).unwrap().unwrap();
        assert_eq!((made.messages, made.walked.lost_messages()), (49, Some(1)), "{:?}", made.walked);
        std::fs::remove_file(scratch.file("bag_0.mcap.torn")).unwrap();
    }
}

/// Both compressions that files have are read; another one is named, and is no damage.
#[test]
fn chunks_of_either_compression_are_read_and_others_are_named() {
    let scratch = Scratch::new("compression");
    let file = scratch.file("bag_0.mcap");
    for compression in [Compression::Lz4, Compression::Zstd] {
        foreign(&file, compression, "cdr", false);
        assert_eq!(look(&file).unwrap().messages, MESSAGES, "{compression:?}");
    }
    let mut bytes = std::fs::read(&file).unwrap();
    for at in 0..bytes.len() - 4 {
        if &bytes[at..at + 4] == b"zstd" {
            bytes[at..at + 4].copy_from_slice(b"zstx");
        }
    }
    std::fs::write(&file, &bytes).unwrap();
    let error = look(&file).unwrap_err().to_string();
    assert!(error.contains("chunks compressed by 'zstx'"), "{error}");
}

/// A file that was being written and has a damage in its middle is kept as it was; where one is kept from an earlier damage,
/// nothing is changed, and no later look at the folder takes the file for one that is done with.
#[test]
fn an_active_file_with_a_damage_is_never_lost() {
    let scratch = Scratch::new("active");
    let active = scratch.file("bag_0.mcap.active");
    foreign(&active, Compression::Zstd, "cdr", false);
    let mut damaged = std::fs::read(&active).unwrap();
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    std::fs::write(&active, &damaged).unwrap();
    let torn = scratch.file("bag_0.mcap.torn");
    std::fs::write(&torn, "of an earlier damage").unwrap();
    let go_on = AtomicBool::new(false);
    recover(&scratch.folder(), 0, &go_on).unwrap_err();
    assert_eq!(scratch.folder().survey().unwrap().leftover, [0]);
    assert_eq!(std::fs::read(&active).unwrap(), damaged);

    // Killed behind the second name: the next one goes on.
    std::fs::remove_file(&torn).unwrap();
    std::fs::hard_link(&active, &torn).unwrap();
    assert!(recover(&scratch.folder(), 0, &go_on).unwrap().unwrap().messages > MESSAGES / 2);
    assert_eq!(std::fs::read(&torn).unwrap(), damaged);
    assert!(!active.exists() && scratch.folder().survey().unwrap().finished == [0]);
}
