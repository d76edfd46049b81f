//! Files that people name, opened only where they are plain files, and read up to a length.
//!
//! A device gives zeros without end, and a pipe waits for a writer that never comes: neither is opened.

use std::fs::{self, File, FileType, OpenOptions};
use std::io::{self, Read};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;

/// Longest file of text that is read: parameters, settings, networks, tables `[byte]`.
pub const TEXT_MAX: u64 = 64 << 20;

/// Why a file is not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
enum Refusal {
    /// Something else than a file.
    #[error("not a file but {0}: must be a regular file")]
    Kind(&'static str),
    /// More than is read.
    #[error("{found} bytes: must be at most {most}")]
    Long { found: u64, most: u64 },
}

/// Opens a plain file for reading, or a link to one. The error does not name the path.
///
/// # Errors
/// What is no plain file, and what it is instead; what the system says.
pub fn open(path: &Path) -> io::Result<File> {
    check(fs::metadata(path)?.file_type())?;
    // What took the file's place since is not waited for.
    let flags = rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOCTTY;
    let file = OpenOptions::new().read(true).custom_flags(flags.bits().cast_signed()).open(path)?;
    check(file.metadata()?.file_type())?;
    Ok(file)
}

/// Reads a plain file of at most `most` bytes. The error does not name the path.
///
/// # Errors
/// As [`open`]; a longer file.
pub fn bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let file = open(path)?;
    let long = |found: u64| io::Error::new(io::ErrorKind::FileTooLarge, Refusal::Long { found, most });
    let length = file.metadata()?.len();
    if length > most {
        return Err(long(length));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    // Files of the system's own tell a length of 0, others grow.
    file.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    let found = bytes.len() as u64;
    if found > most { Err(long(found)) } else { Ok(bytes) }
}

/// The same for text in UTF-8 of at most [`TEXT_MAX`].
///
/// # Errors
/// As [`bytes`]; bytes that are no text.
pub fn text(path: &Path) -> io::Result<String> {
    String::from_utf8(bytes(path, TEXT_MAX)?)
        .map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error.utf8_error()))
}

/// Refuses what is no plain file.
fn check(kind: FileType) -> io::Result<()> {
    let what = match kind {
        kind if kind.is_file() => return Ok(()),
        kind if kind.is_dir() => "a folder",
        kind if kind.is_fifo() => "a pipe",
        kind if kind.is_socket() => "a socket",
        kind if kind.is_char_device() || kind.is_block_device() => "a device",
        _ => "something else",
    };
    Err(io::Error::new(io::ErrorKind::InvalidInput, Refusal::Kind(what)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::fs::{CWD, FileType, Mode, mknodat};
    use std::path::PathBuf;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("fdm_input_{name}_{}", std::process::id()));
        _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    /// Each of them would wait or go on for ever; a link to one is that one.
    #[test]
    fn what_is_no_plain_file_is_refused_unopened_and_named() {
        let folder = folder("kinds");
        let (pipe, link) = (folder.join("pipe"), folder.join("link"));
        mknodat(CWD, &pipe, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        std::os::unix::fs::symlink(&pipe, &link).unwrap();
        let _socket = std::os::unix::net::UnixListener::bind(folder.join("socket")).unwrap();
        let cases: [(&Path, &str); 5] = [
            (Path::new("/dev/zero"), "a device"),
            (&folder, "a folder"),
            (&pipe, "a pipe"),
            (&link, "a pipe"),
            (&folder.join("socket"), "a socket"),
        ];
        for (path, kind) in cases {
            let told = bytes(path, 10).unwrap_err().to_string();
            assert_eq!(told, format!("not a file but {kind}: must be a regular file"), "{path:?}");
        }
        fs::remove_dir_all(folder).unwrap();
    }

    /// A file of the system tells no length: what is read counts.
    #[test]
    fn a_file_is_read_up_to_its_limit() {
        let folder = folder("length");
        let path = folder.join("file");
        fs::write(&path, "12345").unwrap();
        assert_eq!(bytes(&path, 5).unwrap(), b"12345");
        assert_eq!(bytes(&path, 4).unwrap_err().to_string(), "5 bytes: must be at most 4");
        let status = bytes(Path::new("/proc/self/status"), 40).unwrap_err().to_string();
        assert_eq!(status, "41 bytes: must be at most 40");
        assert!(text(Path::new("/proc/self/status")).unwrap().starts_with("Name:"));
        fs::write(&path, [0xff, 0xfe]).unwrap();
        assert!(text(&path).unwrap_err().to_string().contains("utf-8"));
        File::create(&path).unwrap().set_len(TEXT_MAX + 1).unwrap();
        assert_eq!(text(&path).unwrap_err().to_string(), "67108865 bytes: must be at most 67108864");
        fs::remove_dir_all(folder).unwrap();
    }
}
