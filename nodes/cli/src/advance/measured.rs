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
pub(super) const COLUMNS: [&str; 6] =
    ["drive", "polymer", "temperature_c", "height_mm", "width_mm", "advance_s"];

/// Metres as millimetres, without what rounding adds.
pub(super) fn mm(value_m: f64) -> f64 {
    (1e9 * value_m).round() / 1e6
}

/// Rows that are refused are told one by one up to this many.
const ROWS_TOLD: usize = 10;
/// Characters of a cell that a refusal shows.
const CELL_TOLD: usize = 40;

/// Reads measured lines.
///
/// # Errors
/// Line, column, value and allowed range of what is refused, of up to ten rows; a row with more or fewer cells than the
/// first line, a cell that goes on over the end of its line, no row.
pub(super) fn parse(text: &str, setup: &Setup) -> anyhow::Result<Vec<Measured>> {
    // Ends of lines of every system count alike, here and in what is said of a line.
    let text = text.replace("\r\n", "\n").replace('\r', "\n");
    let mut table = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .flexible(true)
        .from_reader(text.as_bytes());
    let names = table.headers()?.clone();
    let mut lines = Lines { text: &text, byte: 0, line: 1 };
    let head = lines.at(0);
    check_whole(&names, head)?;
    let places = places(&names, head)?;
    let (mut measured, mut refused) = (vec![], vec![]);
    for record in table.records() {
        let record = record?;
        let byte = record.position().and_then(|at| usize::try_from(at.byte()).ok()).unwrap_or(0);
        let line = lines.at(byte);
        // What follows an open quote is no row of its own.
        check_whole(&record, line)?;
        let cells = places.map(|place| record.get(place).unwrap_or_default());
        let row = if record.len() == names.len() {
            Row { line, cells }.read(setup)
        } else {
            Err(anyhow!("line {line}: {} cells, must be {} as in line {head}", record.len(), names.len()))
        };
        match row {
            Ok(row) => measured.push(row),
            Err(error) => refused.push(error.to_string()),
        }
    }
    if !refused.is_empty() {
        let more = refused.len().saturating_sub(ROWS_TOLD);
        refused.truncate(ROWS_TOLD);
        let more = if more > 0 { format!("; and {more} rows more") } else { String::new() };
        bail!("{}{more}", refused.join("; "));
    }
    if measured.is_empty() {
        bail!("no measured line below line {head}");
    }
    Ok(measured)
}

/// Places of [`COLUMNS`] in the first line.
fn places(names: &csv::StringRecord, head: usize) -> anyhow::Result<[usize; COLUMNS.len()]> {
    let mut places = [0; COLUMNS.len()];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        let mut found = (0..names.len()).filter(|place| names.get(*place) == Some(column));
        match (found.next(), found.next()) {
            (Some(only), None) => *place = only,
            (None, _) => bail!("line {head}: no column '{column}'; {}", told(names)),
            _ => bail!("line {head}: column '{column}' stands there twice"),
        }
    }
    Ok(places)
}

/// The columns that were found instead, and what they seem to be.
fn told(names: &csv::StringRecord) -> String {
    let found: Vec<String> = names.iter().map(|name| format!("'{}'", shown(name))).collect();
    let found = if found.is_empty() { "none".to_owned() } else { found.join(", ") };
    let other = [(';', "semicolons"), ('\t', "tabs")]
        .into_iter()
        .find(|(separator, _)| names.len() == 1 && names.iter().any(|name| name.contains(*separator)));
    match other {
        Some((_, separator)) => format!("found {found}, separated by {separator}: must be commas"),
        None if names.iter().any(|name| name.parse::<f64>().is_ok()) => {
            format!("found {found}: the first line must name the columns")
        }
        None => format!("found {found}"),
    }
}

/// Refuses a cell that goes on over the end of its line: an open quote takes the rows below into it.
fn check_whole(record: &csv::StringRecord, line: usize) -> anyhow::Result<()> {
    match record.iter().find(|cell| cell.contains('\n')) {
        Some(cell) => {
            bail!("line {line}: the cell '{}' has the end of a line in it: a quote is open", shown(cell))
        }
        None => Ok(()),
    }
}

/// A cell as a message shows it: on one line, and not all of a long one.
fn shown(cell: &str) -> String {
    let mut shown = String::new();
    for one in cell.chars().take(CELL_TOLD) {
        if one.is_control() { shown.extend(one.escape_default()) } else { shown.push(one) }
    }
    if cell.chars().nth(CELL_TOLD).is_some() {
        shown.push_str("...");
    }
    shown
}

/// Lines of a text by places that rise: each line is counted once.
struct Lines<'a> {
    text: &'a str,
    byte: usize,
    line: usize,
}

impl Lines<'_> {
    /// Line of the first row at or behind a place: the reader's own place is before the empty lines and comments it skips.
    fn at(&mut self, byte: usize) -> usize {
        self.line += self.text.get(self.byte..byte).unwrap_or("").matches('\n').count();
        self.byte = self.byte.max(byte);
        let behind = self.text.get(byte..).unwrap_or("");
        self.line + behind.lines().take_while(|line| line.is_empty() || line.starts_with('#')).count()
    }
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
        if at.height_m > at.width_m {
            return Err(self.refused(3, &format!("at most width_mm, {}", self.cells[4])));
        }
        let range_s = setup.physics.drive(drive).advance_range_s;
        let advance_s = self.number(5, range_s, &format!(" for a {} drive", drive.name()))?;
        Ok(Measured { row: self.line, drive, polymer, at, advance_s })
    }

    fn number(&self, column: usize, [low, high]: [f64; 2], of: &str) -> anyhow::Result<f64> {
        let value: Option<f64> = self.cells[column].parse().ok();
        // A NaN is in no range.
        value
            .filter(|value| (low..=high).contains(value))
            .ok_or_else(|| self.refused(column, &format!("a number in [{low}, {high}]{of}")))
    }

    fn refused(&self, column: usize, wanted: &str) -> anyhow::Error {
        let found = shown(self.cells[column]);
        anyhow!("line {}: {} is '{found}', must be {wanted}", self.line, COLUMNS[column])
    }
}

#[cfg(test)]
mod tests;
