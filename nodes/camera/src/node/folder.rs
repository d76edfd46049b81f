//! Pictures of a folder in the order of their names. JPEG files pass as they are, PNG files are encoded.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use runtime::Reason;

use super::driver::{BackOff, DriverEvent};
use super::encode::{decoded_to_jpeg, one_thread};
use crate::frames::BYTES_MAX;
use crate::params::{CameraParams, FolderParams};
use crate::picture::png_header;

/// Reads a folder.
#[derive(Debug)]
pub struct Folder {
    params: FolderParams,
    jpeg_quality: u8,
    back_off: BackOff,
    /// Files to come, the next one last; `None` before the folder is read.
    rest: Option<Vec<PathBuf>>,
}

impl Folder {
    /// Nothing is read before the first [`Folder::next_event`]. A folder that is not there is looked for at the pace of the
    /// frames.
    #[must_use]
    pub fn new(params: FolderParams, camera: &CameraParams) -> Self {
        one_thread();
        let period_s = 1.0 / camera.rate_hz;
        let back_off = BackOff::new(period_s, period_s);
        Self { params, jpeg_quality: camera.jpeg_quality, back_off, rest: None }
    }

    /// The next event: a frame for each picture. Reads files.
    pub fn next_event(&mut self) -> DriverEvent {
        let Some(rest) = &mut self.rest else { return self.open() };
        match rest.pop() {
            Some(file) => read(&file, self.jpeg_quality),
            None if self.params.repeat => self.open(),
            None => DriverEvent::Ended,
        }
    }

    fn open(&mut self) -> DriverEvent {
        let path = Path::new(&self.params.path);
        match pictures(path) {
            Ok(files) if files.is_empty() => {
                self.back_off.lost(format!("no .jpg, .jpeg or .png in {}", path.display()))
            }
            Ok(files) => {
                let text = format!("{} pictures in {}", files.len(), path.display());
                self.rest = Some(files);
                DriverEvent::Found { text }
            }
            Err(error) => self.back_off.lost(format!("{}: {error}", path.display())),
        }
    }
}

/// The pictures of a folder, the first one last.
fn pictures(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if kind(&path).is_some() && path.is_file() {
            files.push(path);
        }
    }
    files.sort_by(|a, b| b.cmp(a));
    Ok(files)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Jpeg,
    Png,
}

fn kind(path: &Path) -> Option<Kind> {
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "jpg" | "jpeg" => Some(Kind::Jpeg),
        "png" => Some(Kind::Png),
        _ => None,
    }
}

fn read(path: &Path, jpeg_quality: u8) -> DriverEvent {
    let mut bytes = Vec::new();
    // One byte more than is passed tells a file that is too long.
    let limit = BYTES_MAX as u64 + 1;
    if let Err(error) = File::open(path).and_then(|file| file.take(limit).read_to_end(&mut bytes)) {
        tracing::warn!("{}: {error}", path.display());
        return DriverEvent::Refused(Reason::Malformed);
    }
    if bytes.len() > BYTES_MAX {
        return DriverEvent::Refused(Reason::OutOfRange);
    }
    if kind(path) != Some(Kind::Png) {
        return DriverEvent::Frame(bytes);
    }
    let header = match png_header(&bytes) {
        Ok(header) if header.bounded() => header,
        Ok(_) => return DriverEvent::Refused(Reason::OutOfRange),
        Err(_) => return DriverEvent::Refused(Reason::Malformed),
    };
    match decoded_to_jpeg(&bytes, header, jpeg_quality) {
        Ok(jpeg) => DriverEvent::Frame(jpeg),
        Err(error) => {
            tracing::warn!("{}: {error}", path.display());
            DriverEvent::Refused(Reason::Malformed)
        }
    }
}
