//! Bags as the recorder writes them: channels, schemas and CDR of the declared topics.

use byteorder::LittleEndian;
use fdm_loop_msgs::RosType;
use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use runtime::topics::Topic;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// A file of a bag being written.
pub(crate) struct BagFile {
    writer: Writer<BufWriter<File>>,
    channels: BTreeMap<String, u16>,
    pub(crate) messages: u64,
}

impl BagFile {
    /// With `chunked` as finished, without as while recording.
    pub(crate) fn create(path: &Path, chunked: bool) -> Self {
        let file = BufWriter::new(File::create(path).unwrap());
        let options = WriteOptions::new().profile("ros2").use_chunks(chunked).compression_threads(0);
        Self { writer: options.create(file).unwrap(), channels: BTreeMap::new(), messages: 0 }
    }

    /// A message of a declared topic of the printer `/printer`.
    pub(crate) fn put<T: RosType>(&mut self, topic: &Topic<T>, at: f64, message: &T) {
        let name = match topic.name() {
            global if global.starts_with('/') => global.to_owned(),
            relative => format!("/printer/{relative}"),
        };
        let body = cdr_encoding::to_vec::<T, LittleEndian>(message).unwrap();
        self.bytes(&name, &T::DEFINITION.full_name(), at, &body);
    }

    /// Any bytes under any name.
    pub(crate) fn bytes(&mut self, topic: &str, type_name: &str, at: f64, body: &[u8]) {
        let id = match self.channels.get(topic) {
            Some(id) => *id,
            None => {
                let schema = self.writer.add_schema(type_name, "ros2msg", b"").unwrap();
                let id = self.writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap();
                self.channels.insert(topic.to_owned(), id);
                id
            }
        };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a time of the test
        let log_time = (at.max(0.0) * 1e9) as u64;
        let header = MessageHeader { channel_id: id, sequence: 0, log_time, publish_time: log_time };
        self.writer.write_to_known_channel(&header, &[&[0, 1, 0, 0], body].concat()).unwrap();
        self.messages += 1;
    }

    /// Closes the file in order.
    pub(crate) fn finish(mut self) -> u64 {
        self.writer.finish().unwrap();
        self.messages
    }

    /// Leaves the file as a kill does: all records written, no end.
    pub(crate) fn kill(mut self) -> u64 {
        self.writer.flush().unwrap();
        std::mem::forget(self.writer);
        self.messages
    }
}

/// A folder of this test, empty.
pub(crate) fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("report").join(name);
    _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}
