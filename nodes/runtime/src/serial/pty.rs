//! A pseudo-terminal that stands in for a device, for tests.

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use std::fs::File;
use std::io::{ErrorKind, Read, Result, Write};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

/// The other end of a line behind a path; dropping it takes the device away, and its path.
#[derive(Debug)]
pub struct Device {
    line: File,
    path: PathBuf,
}

/// A new device behind `path`, an older one replaced.
///
/// # Errors
/// What the system says.
pub fn device(path: &Path) -> Result<Device> {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
    grantpt(&master)?;
    unlockpt(&master)?;
    let name = ptsname(&master, Vec::new())?;
    remove(path)?;
    symlink(std::ffi::OsStr::from_bytes(name.to_bytes()), path)?;
    Ok(Device { line: File::from(master), path: path.to_owned() })
}

fn remove(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

impl Device {
    /// A second handle of the line; the device is gone with the last.
    ///
    /// # Errors
    /// What the system says.
    pub fn try_clone(&self) -> Result<File> {
        self.line.try_clone()
    }
}

// The path goes before the line: the system gives the number of a closed line to the next one that anybody opens,
// and a path left behind would lead there.
impl Drop for Device {
    fn drop(&mut self) {
        // Fails where the whole folder is gone: nothing leads to the line any more.
        drop(remove(&self.path));
    }
}

impl Read for Device {
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize> {
        self.line.read(bytes)
    }
}

impl Write for Device {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.line.write(bytes)
    }

    fn flush(&mut self) -> Result<()> {
        self.line.flush()
    }
}
