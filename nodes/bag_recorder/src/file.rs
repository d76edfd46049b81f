//! One MCAP file of a bag while it is written.

use crate::contents::{Channel, FileContents};
use crate::error::RecorderError;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Name of the metadata records that say what was printed, by what software, with what configuration.
pub const NOTE: &str = "fdm_loop";
/// Key of a channel's metadata that holds the quality of service.
pub const QOS_KEY: &str = "offered_qos_profiles";
/// Encoding of the schemas.
const SCHEMA_ENCODING: &str = "ros2msg";
/// Encoding of the messages.
const MESSAGE_ENCODING: &str = "cdr";
/// Bytes gathered for one write to the system.
const BUFFER: usize = 256 * 1024;

/// How messages lie in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Record after record: what is written is readable after a kill.
    Plain,
    /// In compressed chunks with an index.
    Indexed,
}

/// Times and number of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stamp {
    /// Time of receipt on the node's clock `[ns]`.
    pub log_ns: u64,
    /// Time of sending by the publisher `[ns]`.
    pub publish_ns: u64,
    /// Number of the message by its publisher, modulo 2^32.
    pub sequence: u32,
}

/// A file being written.
pub struct BagFile {
    writer: Writer<BufWriter<File>>,
    path: PathBuf,
    ids: BTreeMap<Channel, u16>,
    contents: FileContents,
    bytes: u64,
}

/// Bytes of a message's record beside its payload.
const RECORD: usize = 31;

impl BagFile {
    /// Makes a file that is not there yet; `contents` names it as it will be called when finished.
    pub fn create(path: &Path, form: Form, number: u32, name: String) -> Result<Self, RecorderError> {
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(path)
            .map_err(RecorderError::file("create", path))?;
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("fdm_loop bag_recorder ", env!("CARGO_PKG_VERSION")))
            .use_chunks(form == Form::Indexed)
            .compression(Some(Compression::Zstd))
            .compression_threads(0);
        let writer = options
            .create(BufWriter::with_capacity(BUFFER, file))
            .map_err(RecorderError::mcap("begin", path))?;
        let contents = FileContents { number, name, ..FileContents::default() };
        Ok(Self { writer, path: path.to_path_buf(), ids: BTreeMap::new(), contents, bytes: 0 })
    }

    /// A second handle, for the thread that syncs.
    pub fn handle(&self) -> Result<File, RecorderError> {
        File::open(&self.path).map_err(RecorderError::file("open", &self.path))
    }

    /// Appends a message; the channel is written with its first one.
    pub fn write(
        &mut self,
        channel: &Channel,
        schema: &str,
        stamp: Stamp,
        payload: &[u8],
    ) -> Result<(), RecorderError> {
        let failed = || RecorderError::mcap("write to", &self.path);
        let channel_id = match self.ids.get(channel) {
            Some(id) => *id,
            None => {
                let schema_id = self
                    .writer
                    .add_schema(&channel.type_name, SCHEMA_ENCODING, schema.as_bytes())
                    .map_err(failed())?;
                let metadata = BTreeMap::from([(QOS_KEY.to_owned(), channel.offered_qos.clone())]);
                let id = self
                    .writer
                    .add_channel(schema_id, &channel.topic, MESSAGE_ENCODING, &metadata)
                    .map_err(failed())?;
                self.ids.insert(channel.clone(), id);
                id
            }
        };
        let Stamp { log_ns, publish_ns, sequence } = stamp;
        let header = MessageHeader { channel_id, sequence, log_time: log_ns, publish_time: publish_ns };
        self.writer.write_to_known_channel(&header, payload).map_err(failed())?;
        self.contents.add(channel, log_ns);
        self.bytes += u64::try_from(payload.len() + RECORD).unwrap_or(u64::MAX);
        Ok(())
    }

    /// What it holds so far.
    #[must_use]
    pub fn contents(&self) -> &FileContents {
        &self.contents
    }

    /// Bytes of its messages so far.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Appends a metadata record.
    pub fn note(&mut self, note: &Metadata) -> Result<(), RecorderError> {
        self.writer.write_metadata(note).map_err(RecorderError::mcap("write to", &self.path))
    }

    /// Hands everything to the system: it survives the end of this process from here on.
    pub fn flush(&mut self) -> Result<(), RecorderError> {
        self.writer.flush().map_err(RecorderError::mcap("write to", &self.path))
    }

    /// Writes summary and footer, waits for the disk, and gives the file its final name.
    pub fn finish(mut self) -> Result<FileContents, RecorderError> {
        self.writer.finish().map_err(RecorderError::mcap("finish", &self.path))?;
        let file = self
            .writer
            .into_inner()
            .into_inner()
            .map_err(|error| RecorderError::file("finish", &self.path)(error.into_error()))?;
        file.sync_all().map_err(RecorderError::file("sync", &self.path))?;
        let target = self.path.with_file_name(&self.contents.name);
        std::fs::rename(&self.path, &target).map_err(RecorderError::file("rename", &self.path))?;
        Ok(self.contents)
    }
}
