//! Bags of other programs: `fdm recover` leaves sound ones alone and mends those that were cut.

use crate::process::{Bag, program, python};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::OpenOptions;
use std::path::PathBuf;
use std::process::{Command, Output};

/// Messages that `write.py` writes.
const MESSAGES: usize = 500;

/// Names of the finished files, in their order.
fn files(bag: &Bag) -> Vec<PathBuf> {
    let paths = std::fs::read_dir(bag.path()).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> =
        paths.filter(|path| path.extension().is_some_and(|ending| ending == "mcap")).collect();
    files.sort();
    files
}

/// Names and bytes of all files.
fn all(bag: &Bag) -> BTreeMap<PathBuf, Vec<u8>> {
    let paths = std::fs::read_dir(bag.path()).unwrap().map(|entry| entry.unwrap().path());
    paths.map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

/// The messages of all files.
fn messages(bag: &Bag) -> Vec<Vec<u8>> {
    let read = |path: &PathBuf| {
        let bytes = std::fs::read(path).unwrap();
        let messages = mcap::MessageStream::new(&bytes).unwrap();
        messages.map(|message| message.unwrap().data.into_owned()).collect::<Vec<_>>()
    };
    files(bag).iter().flat_map(read).collect()
}

/// A bag as another program writes it.
fn written(form: &str) -> Bag {
    let bag = Bag::new(&form.replace('-', "_"));
    python("write.py", &[bag.path().as_os_str(), form.as_ref()]);
    bag
}

fn recover(bag: &Bag) -> Output {
    Command::new(program("fdm")).arg("recover").arg(bag.path()).args(["--json", "-"]).output().unwrap()
}

/// What is told of a bag that was mended, or is sound.
fn recovered(bag: &Bag) -> Value {
    let output = recover(bag);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Chunks of LZ4, of zstd and none, files with and without a number, one and two of them. Sound: not a byte of what is there
/// changes. Its last file cut in the middle: what is left are the first messages as they were, at least all that an
/// independent reader finds in whole chunks, and three readers count the same.
#[test]
fn bags_of_other_programs_are_left_alone_or_mended() {
    for form in ["mcap-lz4", "mcap-zstd", "mcap-none", "ros2", "rosbags", "rosbags-zstd"] {
        let bag = written(form);
        let (before, whole) = (all(&bag), messages(&bag));
        assert_eq!(whole.len(), MESSAGES, "{form}");
        assert_eq!(recovered(&bag)["messages"], MESSAGES, "{form}");
        let after = all(&bag);
        assert!(before.iter().all(|(path, bytes)| after.get(path) == Some(bytes)), "{form}: changed");

        let last = files(&bag).pop().unwrap();
        let bytes = before[&last].len() as u64;
        OpenOptions::new().write(true).open(&last).unwrap().set_len(bytes * 3 / 5).unwrap();
        let in_whole_chunks: u64 = bag.held_by(&last).values().sum();
        let others = if form == "ros2" { MESSAGES as u64 / 2 } else { 0 };
        let told = recovered(&bag);
        let left = told["messages"].as_u64().unwrap();
        assert!(left >= others + in_whole_chunks && left > 0, "{form}: {in_whole_chunks} in chunks, {told}");
        assert_eq!(messages(&bag), whole[..usize::try_from(left).unwrap()], "{form}");
        let read = bag.read();
        assert_eq!(
            (&read["rosbags"]["total"], &read["mcap"]["counts"]["/chatter"]),
            (&left.into(), &left.into())
        );
        assert_eq!(read["rosbags"]["counts"]["/chatter"], left, "{form}: {read}");
        let torn = last.with_extension("mcap.torn");
        assert_eq!(std::fs::read(torn).unwrap(), before[&last][..usize::try_from(bytes * 3 / 5).unwrap()]);
    }
}

/// Each message compressed on its own: `metadata.yaml` alone says so, and mending would write that anew.
#[test]
fn a_bag_of_packed_messages_is_refused_and_left_as_it_is() {
    let bag = written("rosbags-message");
    let before = all(&bag);
    let output = recover(&bag);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("metadata.yaml: compression_mode is 'message'"), "{said}");
    assert_eq!(all(&bag), before);
}
