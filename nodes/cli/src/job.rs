//! A G-code file on disk as a job for the simulated printer.

use crate::config::Setup;
use crate::output;
use anyhow::{Context, bail};
use models::gcode::{Header, Warning};
use models::motion::{Job, MotionParams, Step, Totals};
use printer_sim::JobSource;
use printer_sim::job::Wishes;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

mod cold;
mod slow;

/// Bytes at the end of a file in which slicers state the material.
const MATERIAL_BYTES: usize = 65_536;
/// Longest file that is printed, as it is held in memory `[byte]`; `fdm gcode` reads longer ones.
pub const BYTES_MAX: u64 = 512 << 20;

/// A file in memory.
#[derive(Debug, Clone)]
pub struct GcodeFile {
    name: String,
    bytes: Arc<[u8]>,
    header: Header,
    wishes: Wishes,
    oddities: u64,
}

impl GcodeFile {
    /// Reads a file; `layers` limits the print to the first ones.
    ///
    /// # Errors
    /// A file that cannot be read, is longer than [`BYTES_MAX`] or is empty.
    pub fn read(path: &Path, motion: &MotionParams, layers: Option<u32>) -> anyhow::Result<Self> {
        let bytes = runtime::input::bytes(path, BYTES_MAX).with_context(|| path.display().to_string())?;
        if bytes.is_empty() {
            bail!("{}: the file is empty", path.display());
        }
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Self::of(name, bytes.into(), motion, layers).with_context(|| path.display().to_string())
    }

    /// A file that exists as a text only.
    ///
    /// # Errors
    /// No move in it.
    pub fn of_text(text: &str, motion: &MotionParams, layers: Option<u32>) -> anyhow::Result<Self> {
        Self::of("text".to_owned(), text.as_bytes().into(), motion, layers)
    }

    fn of(
        name: String,
        bytes: Arc<[u8]>,
        motion: &MotionParams,
        layers: Option<u32>,
    ) -> anyhow::Result<Self> {
        let header_bytes = motion.read.header_bytes.min(bytes.len());
        let header = Header::scan(&bytes[..header_bytes], &bytes[bytes.len() - header_bytes..]);
        let job = Job::new(Cursor::new(Arc::clone(&bytes)), &header, motion);
        if !job.into_iter().any(|step| matches!(step, Step::Move(_))) {
            bail!("no move in the file");
        }
        Ok(Self { name, bytes, header, wishes: Wishes { layers, set_points: None }, oddities: 0 })
    }

    /// The same, and says on standard error what is odd in it: a print of what was meant otherwise misleads.
    ///
    /// # Errors
    /// As [`Self::read`]; a file that lays no road, or waits for days.
    pub fn read_telling(path: &Path, motion: &MotionParams, layers: Option<u32>) -> anyhow::Result<Self> {
        let mut file = Self::read(path, motion, layers)?;
        let (totals, wait) = file.look_through(path, motion);
        if let Some(wait) = wait.filter(slow::Wait::is_endless) {
            bail!("{}: {wait}", path.display());
        }
        if totals.deposit_m <= 0.0 {
            bail!(
                "{}: none of its {} moves lays a road (moves the tool while filament is pushed): nothing to print",
                path.display(),
                totals.moves
            );
        }
        Ok(file)
    }

    /// Says on standard error what is odd in it, and a line at which the print stands for minutes.
    pub fn tell(&mut self, path: &Path, motion: &MotionParams) {
        self.look_through(path, motion);
    }

    /// The same, with what the file holds, and its longest wait.
    fn look_through(&mut self, path: &Path, motion: &MotionParams) -> (Totals, Option<slow::Wait>) {
        let mut job = Job::new(Cursor::new(Arc::clone(&self.bytes)), &self.header, motion);
        let (mut wait, mut cold) = (None, cold::Cold::default());
        let slowest = slow::slowest(job.by_ref().inspect(|step| {
            slow::Wait::note(&mut wait, step);
            cold.note(step);
        }));
        self.oddities = job.oddities().total();
        if let Some(first) = first_of_each(job.oddities().kept()) {
            let (name, count) = (path.display(), self.oddities);
            output::note(&format!("{name}: {count} odd, first {first}; `fdm gcode` names them"));
        }
        if let Some(slow) = slowest.filter(slow::Line::is_long) {
            output::note(&format!("{}: {slow}", path.display()));
        }
        if cold.lays() {
            output::note(&format!("{}: {cold}", path.display()));
        }
        (*job.totals(), wait)
    }

    /// How much is odd, where that was counted.
    #[must_use]
    pub fn oddities(&self) -> u64 {
        self.oddities
    }

    /// File name without folder.
    #[must_use]
    pub fn name(&self) -> String {
        self.name.clone()
    }

    /// Material that the slicer states; PLA where it states none.
    #[must_use]
    pub fn material(&self) -> String {
        const KEY: &str = "; filament_type = ";
        let tail = &self.bytes[self.bytes.len() - MATERIAL_BYTES.min(self.bytes.len())..];
        let text = String::from_utf8_lossy(tail);
        let stated = text.lines().find_map(|line| line.strip_prefix(KEY)).map(str::trim);
        stated.filter(|name| !name.is_empty()).map_or_else(|| "PLA".to_owned(), str::to_uppercase)
    }

    /// The same file with the set-points of the material in use.
    #[must_use]
    pub fn with_set_points(mut self, setup: &Setup) -> Self {
        self.wishes.set_points = Some(setup.simulated.set_points(&setup.material));
        self
    }

    /// The job, from its start.
    #[must_use]
    pub fn job(&self, setup: &Setup) -> JobSource {
        JobSource::from_gcode(&self.bytes, &self.header, &setup.motion, self.wishes)
    }
}

/// Reasons that are told on one line.
const REASONS: usize = 3;

/// The first line of each of the first reasons; `None` where there is none.
fn first_of_each(odd: &[Warning]) -> Option<String> {
    let mut told: Vec<&Warning> = Vec::new();
    for warning in odd {
        if told.len() < REASONS && told.iter().all(|known| known.reason != warning.reason) {
            told.push(warning);
        }
    }
    let lines: Vec<String> =
        told.iter().map(|warning| format!("line {}: {}", warning.line, warning.reason)).collect();
    (!lines.is_empty()).then(|| lines.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A refused pressure advance is counted; a file in which nothing is odd has none.
    #[test]
    fn odd_lines_of_a_print_are_counted() {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config"));
        let motion = crate::config::ConfigDir::find(Some(folder)).unwrap().motion().unwrap();
        let path = std::env::temp_dir().join(format!("fdm_odd_{}.gcode", std::process::id()));
        let oddities = |text: &str| {
            std::fs::write(&path, text).unwrap();
            GcodeFile::read_telling(&path, &motion, None).unwrap().oddities()
        };
        assert_eq!(oddities("M900 K-1\nG1 X10 E1\nSET_PRESSURE_ADVANCE ADVANCE=nan\nM900 K75\n"), 3);
        assert_eq!(oddities("M900 K0.1\nG1 X10 E1\nSET_PRESSURE_ADVANCE ADVANCE=0.2\n"), 0);
        std::fs::remove_file(&path).unwrap();
    }
    #[test]
    fn each_reason_is_told_once_with_its_first_line() {
        let odd = |line, reason: &str| Warning { line, reason: reason.to_owned() };
        let all = [odd(4, "a"), odd(5, "a"), odd(6, "b"), odd(7, "a"), odd(8, "c"), odd(9, "d")];
        assert_eq!(first_of_each(&all).unwrap(), "line 4: a, line 6: b, line 8: c");
        assert_eq!(first_of_each(&[]), None);
    }

    /// 100 000 000 s of virtual time are hours of the processor's, in which nothing is printed.
    #[test]
    fn a_file_that_waits_for_days_is_refused_with_its_line() {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config"));
        let motion = crate::config::ConfigDir::find(Some(folder)).unwrap().motion().unwrap();
        let path = std::env::temp_dir().join(format!("fdm_waits_{}.gcode", std::process::id()));
        let read = |seconds: u32| {
            std::fs::write(&path, format!("G1 X10 E1 F1800\nG4 S1\nG4 S{seconds}\nG1 X0 E2\n")).unwrap();
            GcodeFile::read_telling(&path, &motion, None).map_err(|error| error.to_string())
        };
        let refused = read(100_000_000).unwrap_err();
        assert!(refused.ends_with("line 3 waits 100000000 s, longer than a day: not printed"), "{refused}");
        assert!(read(86_400).is_ok());
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn a_file_that_lays_no_road_is_refused() {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config"));
        let motion = crate::config::ConfigDir::find(Some(folder)).unwrap().motion().unwrap();
        let path = std::env::temp_dir().join(format!("fdm_no_road_{}.gcode", std::process::id()));
        for text in ["G1 X10 F1800\nG1 Y10\n", "M83\nG1 E5 F300\n"] {
            std::fs::write(&path, text).unwrap();
            let error = GcodeFile::read_telling(&path, &motion, None).unwrap_err().to_string();
            assert!(error.contains("moves lays a road") && error.starts_with("/"), "{error}");
        }
        std::fs::remove_file(&path).unwrap();
    }
}
