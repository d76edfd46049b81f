//! A bag written from its first message to its last by one program: nothing to recover, nothing to wait for.

use crate::contents::Channel;
use crate::error::RecorderError;
use crate::file::{BagFile, Form, NOTE, Stamp};
use crate::folder::Folder;
use crate::tally::Tally;
use mcap::records::Metadata;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// A bag in the making.
pub struct WholeBag {
    folder: Folder,
    file: BagFile,
}

impl WholeBag {
    /// Makes the folder and its one file, with a `fdm_loop` record at its head.
    ///
    /// # Errors
    /// A folder that cannot be made, or is another recorder's.
    pub fn create(path: &Path, note: BTreeMap<String, String>) -> Result<Self, RecorderError> {
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let folder = Folder::open(path, &name, Arc::new(Tally::new(0)))?;
        let active = folder.path(&folder.layout().active(0));
        let mut file = BagFile::create(&active, Form::Indexed, 0, folder.layout().finished(0))?;
        file.note(&Metadata { name: NOTE.to_owned(), metadata: note })?;
        Ok(Self { folder, file })
    }

    /// Appends a message.
    ///
    /// # Errors
    /// A disk that refuses.
    pub fn put(
        &mut self,
        channel: &Channel,
        schema: &str,
        stamp: Stamp,
        payload: &[u8],
    ) -> Result<(), RecorderError> {
        self.file.write(channel, schema, stamp, payload)
    }

    /// Closes the bag, and tells how many messages it holds.
    ///
    /// # Errors
    /// A disk that refuses.
    pub fn finish(self) -> Result<u64, RecorderError> {
        let contents = self.file.finish()?;
        let messages = contents.total();
        self.folder.add(contents)?;
        Ok(messages)
    }
}
