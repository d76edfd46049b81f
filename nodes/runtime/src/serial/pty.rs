//! A pseudo-terminal that stands in for a device, for tests.

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use std::fs::File;
use std::io::Result;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::path::Path;

/// A new device behind `path`, an older one replaced; the other end of the line. Dropping it takes the device away.
///
/// # Errors
/// What the system says.
pub fn device(path: &Path) -> Result<File> {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
    grantpt(&master)?;
    unlockpt(&master)?;
    let name = ptsname(&master, Vec::new())?;
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    symlink(std::ffi::OsStr::from_bytes(name.to_bytes()), path)?;
    Ok(File::from(master))
}
