//! Bytes of a file at any place, read in large pieces.

use rustix::fs::SeekFrom;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;

/// Read from the file at once `[byte]`.
const PIECE: u64 = 1024 * 1024;

/// A file of which a piece is in memory. It is taken to be as long as it was when it was opened.
#[derive(Debug)]
pub(super) struct Window {
    file: File,
    size: u64,
    start: u64,
    piece: Vec<u8>,
}

impl Window {
    pub(super) fn new(file: File) -> io::Result<Self> {
        let size = file.metadata()?.len();
        Ok(Self { file, size, start: 0, piece: Vec::new() })
    }

    /// Length of the file `[byte]`.
    pub(super) fn size(&self) -> u64 {
        self.size
    }

    /// The bytes from `at` on that a look takes at once; none at the end.
    pub(super) fn ahead(&mut self, at: u64) -> io::Result<&[u8]> {
        let held = self.start + self.piece.len() as u64;
        let length = if at >= self.start && at < held { held - at } else { PIECE };
        self.bytes(at, length)
    }

    /// Where the disk holds something from `at` on: what was never written reads as zeros.
    pub(super) fn written_from(&self, at: u64) -> u64 {
        match rustix::fs::seek(&self.file, SeekFrom::Data(at)) {
            Ok(place) => place.max(at),
            Err(rustix::io::Errno::NXIO) => self.size,
            // A disk that does not tell.
            Err(_) => at,
        }
    }

    /// `length` bytes from `at`; fewer where the file ends before.
    pub(super) fn bytes(&mut self, at: u64, length: u64) -> io::Result<&[u8]> {
        let at = at.min(self.size);
        let length = length.min(self.size - at);
        let held = self.start + self.piece.len() as u64;
        if at < self.start || at + length > held {
            let wanted = length.max(PIECE).min(self.size - at);
            self.piece.resize(usize::try_from(wanted).map_err(io::Error::other)?, 0);
            self.start = at;
            if let Err(error) = self.file.read_exact_at(&mut self.piece, at) {
                self.piece.clear();
                return Err(error);
            }
        }
        let from = usize::try_from(at - self.start).map_err(io::Error::other)?;
        let length = usize::try_from(length).map_err(io::Error::other)?;
        Ok(&self.piece[from..from + length])
    }
}
