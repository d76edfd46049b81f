//! Lines that a person printed and scored, as comma-separated text.
//!
//! First line: names of the columns, in any order. Needed:
//!
//! | column | what | range |
//! |---|---|---|
//! | `drive` | where the drive gear sits | `bowden`, `direct` |
//! | `polymer` | what was printed | a block of `config/advance/physics.yaml` |
//! | `temperature_c` | hot end | `bounds.temperature_c` of `config/advance_predictor.param.yaml`: 160 to 320 |
//! | `height_mm` | layer | `bounds.height_m` there: 0.05 to 1 |
//! | `width_mm` | line | `bounds.width_m` there: 0.15 to 2 |
//! | `advance_s` | K of the best line of the pattern | `advance_range_s` of the drive: 0.3 to 1.5, 0.01 to 0.2 |
//!
//! Other columns are left alone: notes. Lines that are empty or begin with `#` are skipped.

use super::Setup;
use advance_predictor::compensation::measured::Measured;
use anyhow::{anyhow, bail};
use models::advance::{Condition, DriveKind};
use models::units::Celsius;

/// Columns that have to be there.
const COLUMNS: [&str; 6] = ["drive", "polymer", "temperature_c", "height_mm", "width_mm", "advance_s"];

/// Metres as millimetres, without what rounding adds.
pub(super) fn mm(value_m: f64) -> f64 {
    (1e9 * value_m).round() / 1e6
}

/// Reads measured lines.
///
/// # Errors
/// Line, column, value and allowed range of what is refused; a row with more or fewer cells than the first line; no row.
pub(super) fn parse(text: &str, setup: &Setup) -> anyhow::Result<Vec<Measured>> {
    // Ends of lines of every system count alike, here and in what is said of a line.
    let text = text.replace("\r\n", "\n").replace('\r', "\n");
    let mut table = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .flexible(true)
        .from_reader(text.as_bytes());
    let names = table.headers()?.clone();
    let head = line_at(&text, 0);
    let mut places = [0; COLUMNS.len()];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        let mut found = (0..names.len()).filter(|place| names.get(*place) == Some(column));
        match (found.next(), found.next()) {
            (Some(only), None) => *place = only,
            (None, _) => bail!("line {head}: no column '{column}'"),
            _ => bail!("line {head}: column '{column}' stands there twice"),
        }
    }
    let mut measured = vec![];
    for record in table.records() {
        let record = record?;
        let byte = record.position().and_then(|at| usize::try_from(at.byte()).ok()).unwrap_or(0);
        let line = line_at(&text, byte);
        if record.len() != names.len() {
            bail!("line {line}: {} cells, must be {} as in line {head}", record.len(), names.len());
        }
        measured.push(
            Row { line, cells: places.map(|place| record.get(place).unwrap_or_default()) }.read(setup)?,
        );
    }
    if measured.is_empty() {
        bail!("no measured line below line {head}");
    }
    Ok(measured)
}

/// Line of the first row at or behind a place: the reader's own place is before the empty lines and comments it skips.
fn line_at(text: &str, byte: usize) -> usize {
    let (before, behind) = text.split_at_checked(byte).unwrap_or((text, ""));
    let skipped = behind.lines().take_while(|line| line.is_empty() || line.starts_with('#')).count();
    1 + before.matches('\n').count() + skipped
}

/// Cells in the order of [`COLUMNS`].
struct Row<'a> {
    line: usize,
    cells: [&'a str; COLUMNS.len()],
}

impl Row<'_> {
    fn read(&self, setup: &Setup) -> anyhow::Result<Measured> {
        let drive = DriveKind::ALL.into_iter().find(|drive| drive.name() == self.cells[0].to_lowercase());
        let drive = drive.ok_or_else(|| self.refused(0, "bowden or direct"))?;
        let polymers = &setup.physics.polymers;
        let polymer = self.cells[1].to_uppercase();
        if !polymers.contains_key(&polymer) {
            let names: Vec<&str> = polymers.keys().map(String::as_str).collect();
            return Err(self.refused(1, &format!("one of {}", names.join(", "))));
        }
        let bounds = &setup.params.bounds;
        let at = Condition {
            temperature: Celsius(self.number(2, bounds.temperature_c, "")?),
            height_m: 1e-3 * self.number(3, bounds.height_m.map(mm), "")?,
            width_m: 1e-3 * self.number(4, bounds.width_m.map(mm), "")?,
        };
        let range_s = setup.physics.drive(drive).advance_range_s;
        let advance_s = self.number(5, range_s, &format!(" for a {} drive", drive.name()))?;
        Ok(Measured { drive, polymer, at, advance_s })
    }

    fn number(&self, column: usize, [low, high]: [f64; 2], of: &str) -> anyhow::Result<f64> {
        let value: Option<f64> = self.cells[column].parse().ok();
        // A NaN is in no range.
        value
            .filter(|value| (low..=high).contains(value))
            .ok_or_else(|| self.refused(column, &format!("a number in [{low}, {high}]{of}")))
    }

    fn refused(&self, column: usize, wanted: &str) -> anyhow::Error {
        anyhow!("line {}: {} is '{}', must be {wanted}", self.line, COLUMNS[column], self.cells[column])
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::setup;
    use super::*;

    const HEAD: &str = "drive,polymer,temperature_c,height_mm,width_mm,advance_s\n";

    fn refused(text: &str) -> String {
        parse(text, &setup().1).unwrap_err().to_string()
    }

    #[test]
    fn measured_lines_are_refused_by_line_and_column() {
        assert_eq!(refused("drive,polymer\n"), "line 1: no column 'temperature_c'");
        assert_eq!(refused(""), "line 1: no column 'drive'");
        assert_eq!(refused("# mine\n\ndrive,polymer\n"), "line 3: no column 'temperature_c'");
        let twice = format!("advance_s,{HEAD}0.6,bowden,PLA,215,0.2,0.4,0.6\n");
        assert_eq!(refused(&twice), "line 1: column 'advance_s' stands there twice");
        assert_eq!(refused(HEAD), "no measured line below line 1");
        // A row cut short is no row with empty cells.
        let error = refused(&format!("{HEAD}# mine\nbowden,PLA,215,0.2\n"));
        assert_eq!(error, "line 3: 4 cells, must be 6 as in line 1");
    }

    /// Kelvin for degrees Celsius, metres and tenths for millimetres, milliseconds for seconds, the other drive's K.
    #[test]
    fn a_slip_of_a_unit_is_refused_with_the_range() {
        for (row, error) in [
            ("remote,PLA,215,0.2,0.4,0.6", "drive is 'remote', must be bowden or direct"),
            ("bowden,WOOD,215,0.2,0.4,0.6", "polymer is 'WOOD', must be one of ABS, PETG, PLA"),
            ("bowden,,215,0.2,0.4,0.6", "polymer is '', must be one of ABS, PETG, PLA"),
            ("bowden,PLA,488,0.2,0.4,0.6", "temperature_c is '488', must be a number in [160, 320]"),
            ("bowden,PLA,nan,0.2,0.4,0.6", "temperature_c is 'nan', must be a number in [160, 320]"),
            ("bowden,PLA,215,0.0002,0.4,0.6", "height_mm is '0.0002', must be a number in [0.05, 1]"),
            ("bowden,PLA,215,0.2,200,0.6", "width_mm is '200', must be a number in [0.15, 2]"),
            (
                "bowden,PLA,215,0.2,0.4,600",
                "advance_s is '600', must be a number in [0.3, 1.5] for a bowden drive",
            ),
            (
                "direct,PLA,215,0.2,0.4,0.6",
                "advance_s is '0.6', must be a number in [0.01, 0.2] for a direct drive",
            ),
        ] {
            assert_eq!(
                refused(&format!("{HEAD}bowden,PLA,215,0.2,0.4,0.6\n{row}\n")),
                format!("line 3: {error}")
            );
        }
    }

    /// Comments, empty lines and the line ends of other systems do not move the line that is named.
    #[test]
    fn the_line_is_the_files_own() {
        let odd = "bowden,PLA,215,0.2,0.4,-1";
        let sound = "bowden,PLA,215,0.2,0.4,0.6";
        for text in [
            format!("{HEAD}# one\n# two\n\n{sound}\n# three\n\n{odd}\n"),
            format!("# one\r\n\r\n{}\r\n{sound}\r\n{sound}\r\n# two\r\n{odd}\r\n", HEAD.trim()),
            format!("{}\r{}{odd}\r", HEAD.trim(), format!("{sound}\r").repeat(6)),
        ] {
            let expected =
                1 + text.replace("\r\n", "\n").split(['\n', '\r']).position(|line| line == odd).unwrap();
            assert!(refused(&text).starts_with(&format!("line {expected}: advance_s is '-1'")), "{text}");
        }
    }

    /// Comments, notes, any order of columns, a comma inside of quotes.
    #[test]
    fn measured_lines_are_read_with_what_a_person_notes() {
        let text = "note,drive,polymer,temperature_c,height_mm,width_mm,advance_s\n# mine\n\n\
                    \"dry, new\",Direct, pla ,215,0.2,0.4,0.04\n";
        let at = Condition { temperature: Celsius(215.0), height_m: 2e-4, width_m: 4e-4 };
        let wanted = Measured { drive: DriveKind::Direct, polymer: "PLA".to_owned(), at, advance_s: 0.04 };
        assert_eq!(parse(text, &setup().1).unwrap(), [wanted]);
    }
}
