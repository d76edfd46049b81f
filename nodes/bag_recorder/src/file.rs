//! One MCAP file of a bag while it is written.

use crate::contents::{Channel, FileContents};
use crate::error::RecorderError;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Name of the metadata records that say what was printed, by what software, with what configuration.
pub const NOTE: &str = "fdm_loop";
/// What the head of our files says of who wrote them, before the version.
pub(crate) const LIBRARY: &str = "fdm_loop bag_recorder";
/// Key of a channel's metadata that holds the quality of service.
pub const QOS_KEY: &str = "offered_qos_profiles";
/// Encoding of the schemas.
const SCHEMA_ENCODING: &str = "ros2msg";
/// Encoding of the messages.
pub const MESSAGE_ENCODING: &str = "cdr";
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

/// A channel as a file describes it, beside what [`Channel`] says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Described {
    /// Name, encoding and text of its schema.
    pub schema: Option<(String, String, Vec<u8>)>,
    /// Encoding of its messages.
    pub encoding: String,
    /// All that the channel says of itself.
    pub metadata: BTreeMap<String, String>,
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
            .library(format!("{LIBRARY} {}", env!("CARGO_PKG_VERSION")))
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
        let id = match self.ids.get(channel) {
            Some(id) => *id,
            None => {
                let described = Described {
                    schema: Some((
                        channel.type_name.clone(),
                        SCHEMA_ENCODING.to_owned(),
                        schema.as_bytes().to_vec(),
                    )),
                    encoding: MESSAGE_ENCODING.to_owned(),
                    metadata: BTreeMap::from([(QOS_KEY.to_owned(), channel.offered_qos.clone())]),
                };
                let id = self.describe(channel, &described)?;
                self.ids.insert(channel.clone(), id);
                id
            }
        };
        self.append(id, channel, stamp, payload)
    }

    /// Number of a channel as a file describes it; written where it is not known yet.
    pub fn describe(&mut self, channel: &Channel, described: &Described) -> Result<u16, RecorderError> {
        let Described { schema, encoding, metadata } = described;
        let schema_id = match schema {
            // A channel without a schema.
            None => Ok(0),
            Some((name, encoding, data)) => self.writer.add_schema(name, encoding, data),
        };
        schema_id
            .and_then(|schema| self.writer.add_channel(schema, &channel.topic, encoding, metadata))
            .map_err(RecorderError::mcap("write to", &self.path))
    }

    /// Appends a message of a channel with this number.
    pub fn append(
        &mut self,
        channel_id: u16,
        channel: &Channel,
        stamp: Stamp,
        payload: &[u8],
    ) -> Result<(), RecorderError> {
        let Stamp { log_ns, publish_ns, sequence } = stamp;
        let header = MessageHeader { channel_id, sequence, log_time: log_ns, publish_time: publish_ns };
        let written = self.writer.write_to_known_channel(&header, payload);
        written.map_err(RecorderError::mcap("write to", &self.path))?;
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

    /// Appends an attachment.
    pub fn attach(&mut self, attachment: &Attachment<'_>) -> Result<(), RecorderError> {
        self.writer.attach(attachment).map_err(RecorderError::mcap("write to", &self.path))
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
