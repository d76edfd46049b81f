//! A file of a bag as a kill, a bad disk or another program may leave it: walked through, mended, and read again.

use super::laws::is_one_line;
use bag_recorder::contents::Channel;
use bag_recorder::error::RecorderError;
use bag_recorder::file::{BagFile, Form, Stamp};
use bag_recorder::folder::Folder;
use bag_recorder::layout::Layout;
use bag_recorder::record;
use bag_recorder::recovery::{compact, look, read_finished, recover, salvage};
use bag_recorder::tally::Tally;
use bag_recorder::walk::{Walk, Walked};
use mcap::records::op;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// A folder that goes with its case.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Self {
        let thread = format!("{:?}", std::thread::current().id());
        let path = std::env::temp_dir().join(format!("fuzz_bag_{}_{thread}", std::process::id()));
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

/// A file that a recorder was writing; an odd number of bytes stands for one that had been finished.
pub fn bag(bytes: &[u8]) {
    let scratch = Scratch::new();
    let folder = scratch.folder();
    let finished = bytes.len() % 2 == 1;
    let layout = Layout::new("bag");
    let file = folder.path(&if finished { layout.finished(0) } else { layout.active(0) });
    std::fs::write(&file, bytes).unwrap();
    let Some(walked) = walk(&file, bytes.len()) else { return };
    let looked = look(&file);
    // `fdm recover` leaves such a file as it is; a recorder copies what it finds of one.
    let foreign = matches!(looked, Err(RecorderError::Foreign { .. }));
    is_told(looked.map(drop));
    if finished {
        is_told(read_finished(&folder, 0).map(drop));
    }
    let stop = AtomicBool::new(false);
    let made = if finished { salvage(&folder, 0, &stop) } else { recover(&folder, 0, &stop) };
    match made {
        Err(error) => is_told(Err(error)),
        Ok(made) => {
            let made = made.unwrap();
            assert!(made.messages <= walked.messages, "{made:?} of {walked:?}");
            if !foreign {
                is_whole(&folder, &folder.path(&layout.finished(0)), made.messages);
            }
        }
    }
}

/// Every record once, none beyond the file; `None` where it is no bag.
fn walk(file: &Path, bytes: usize) -> Option<Walked> {
    let mut walk = Walk::open(file).unwrap()?;
    let (mut records, mut messages) = (0_usize, 0);
    while let Some((opcode, fields)) = walk.next_record().unwrap() {
        records += 1;
        messages += u64::from(opcode == op::MESSAGE);
        _ = record::parse(opcode, fields);
        assert!(records <= 2 * bytes.max(1) * 1100, "{records} records in {bytes} bytes");
    }
    let walked = walk.finish();
    assert_eq!(walked.messages, messages);
    walked.damage_in_words().iter().for_each(|words| is_one_line(words));
    Some(walked)
}

/// What was mended is sound, and needs it no more.
fn is_whole(folder: &Folder, file: &Path, messages: u64) {
    let read = read_finished(folder, 0).unwrap();
    assert_eq!(read.contents.total(), messages);
    let walked = look(file).unwrap();
    assert!(walked.is_sound() && walked.messages == messages, "{walked:?}");
    assert!(compact(folder, 0, &AtomicBool::new(false)).unwrap());
    assert_eq!(read_finished(folder, 0).unwrap().contents.total(), messages);
}

/// An error is one line.
fn is_told(result: Result<(), RecorderError>) {
    if let Err(error) = result {
        is_one_line(&error.to_string());
    }
}

/// The same few messages in chunks and record after record, finished and not.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    let scratch = Scratch::new();
    let folder = scratch.folder();
    let mut seeds = Vec::new();
    for form in [Form::Plain, Form::Indexed] {
        let path = folder.path("seed");
        let mut file = BagFile::create(&path, form, 0, "bag_0.mcap".to_owned()).unwrap();
        for number in 0..6_u8 {
            let channel = Channel {
                topic: format!("/{}", number % 2),
                type_name: "std_msgs/msg/Empty".to_owned(),
                offered_qos: "- depth: 1".to_owned(),
            };
            let log_ns = 10 + u64::from(number);
            let stamp = Stamp { log_ns, publish_ns: log_ns, sequence: number.into() };
            file.write(&channel, "", stamp, &[number; 8]).unwrap();
        }
        file.finish().unwrap();
        let finished = folder.path("bag_0.mcap");
        let bytes = std::fs::read(&finished).unwrap();
        std::fs::remove_file(&finished).unwrap();
        // One byte less or more stands for the other kind of file.
        seeds.extend([bytes.clone(), bytes[..bytes.len() - 1].to_vec(), bytes[..bytes.len() / 2].to_vec()]);
    }
    seeds
}
