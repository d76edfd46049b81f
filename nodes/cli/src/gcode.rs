//! Library half of `fdm gcode FILE`: opens the file, the rest is `models::gcode::survey`.

use models::gcode::Header;
use models::gcode::survey::{self, Survey};
use models::motion::MotionParams;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

/// Bytes fetched from the file at a time: large enough that the system call does not count.
const BUFFER_BYTES: usize = 1 << 20;

/// Parses and plans a file under a printer's limits; limits stated in the file replace them.
///
/// # Errors
/// Those of opening and reading; oddities of the contents are in the [`Survey`].
pub(crate) fn survey(path: &Path, params: &MotionParams) -> io::Result<Survey> {
    let mut file = File::open(path)?;
    let header = Header::read_ends(&mut file, params.read.header_bytes)?;
    Ok(survey::survey(BufReader::with_capacity(BUFFER_BYTES, file), &header, params))
}
