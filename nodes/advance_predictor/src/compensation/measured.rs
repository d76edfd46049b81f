//! Lines that a person printed and scored, as comma-separated text.
//!
//! First line: names of the columns, in any order. Needed: `drive` (bowden or direct), `polymer` (as in
//! `config/advance/physics.yaml`), `temperature_c`, `height_mm`, `width_mm`, `advance_s` (the K of the best line of the
//! pattern). Other columns are left alone: notes. Lines that are empty or begin with `#` are skipped.

use models::advance::{Condition, DriveKind};
use models::units::Celsius;

/// Columns that have to be there.
pub const COLUMNS: [&str; 6] = ["drive", "polymer", "temperature_c", "height_mm", "width_mm", "advance_s"];

/// One measured line.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Drive.
    pub drive: DriveKind,
    /// Polymer.
    pub polymer: String,
    /// Condition.
    pub at: Condition,
    /// Best `K_A` of the pattern `[s]`.
    pub advance_s: f64,
}

/// Why a file was refused.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeasuredError {
    /// The first line lacks a column.
    #[error("line 1: no column '{0}'")]
    Column(&'static str),
    /// No comma-separated text: a row that is shorter or longer than the first line, bytes that are no text.
    #[error(transparent)]
    Table(#[from] csv::Error),
    /// A cell that cannot be read.
    #[error("line {line}: {column} is '{found}', must be {wanted}")]
    Cell {
        /// From 1.
        line: u64,
        /// Name of the column.
        column: &'static str,
        /// What stands there.
        found: String,
        /// What has to.
        wanted: &'static str,
    },
}

/// Reads measured lines.
///
/// # Errors
/// [`MeasuredError`] with line and column.
pub fn parse(text: &str) -> Result<Vec<Measured>, MeasuredError> {
    let mut table =
        csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
    let names = table.headers()?;
    let mut places = [0; COLUMNS.len()];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        *place = names.iter().position(|name| name == column).ok_or(MeasuredError::Column(column))?;
    }
    table.records().map(|record| row(&record?, &places)).collect()
}

fn row(record: &csv::StringRecord, places: &[usize; 6]) -> Result<Measured, MeasuredError> {
    let cell = |column: usize| record.get(places[column]).unwrap_or_default();
    let refused = |column: usize, wanted| MeasuredError::Cell {
        line: record.position().map_or(0, csv::Position::line),
        column: COLUMNS[column],
        found: cell(column).to_owned(),
        wanted,
    };
    let number = |column: usize| {
        let value: Option<f64> = cell(column).parse().ok();
        value
            .filter(|value| value.is_finite() && *value > 0.0)
            .ok_or_else(|| refused(column, "a number above 0"))
    };
    let drive = DriveKind::ALL.into_iter().find(|drive| drive.name() == cell(0).to_lowercase());
    if cell(1).is_empty() {
        return Err(refused(1, "a polymer"));
    }
    Ok(Measured {
        drive: drive.ok_or_else(|| refused(0, "bowden or direct"))?,
        polymer: cell(1).to_uppercase(),
        at: Condition {
            temperature: Celsius(number(2)?),
            height_m: 1e-3 * number(3)?,
            width_m: 1e-3 * number(4)?,
        },
        advance_s: number(5)?,
    })
}
