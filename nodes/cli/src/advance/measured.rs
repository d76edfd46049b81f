//! Lines that a person printed and scored, as comma-separated text.
//!
//! First line: names of the columns, in any order. Needed: `drive` (bowden or direct), `polymer` (as in
//! `config/advance/physics.yaml`), `temperature_c`, `height_mm`, `width_mm`, `advance_s` (the K of the best line of the
//! pattern). Other columns are left alone: notes. Lines that are empty or begin with `#` are skipped.

use advance_predictor::compensation::measured::Measured;
use anyhow::{Context, anyhow};
use models::advance::{Condition, DriveKind};
use models::units::Celsius;

/// Columns that have to be there.
const COLUMNS: [&str; 6] = ["drive", "polymer", "temperature_c", "height_mm", "width_mm", "advance_s"];

/// Reads measured lines.
///
/// # Errors
/// Line and column of what is refused; a row with more or fewer cells than the first line.
pub(super) fn parse(text: &str) -> anyhow::Result<Vec<Measured>> {
    let mut table =
        csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
    let names = table.headers()?;
    let mut places = [0; COLUMNS.len()];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        *place = names
            .iter()
            .position(|name| name == column)
            .with_context(|| format!("line 1: no column '{column}'"))?;
    }
    table.records().map(|record| row(&record?, &places)).collect()
}

fn row(record: &csv::StringRecord, places: &[usize; 6]) -> anyhow::Result<Measured> {
    let line = record.position().map_or(0, csv::Position::line);
    let cell = |column: usize| record.get(places[column]).unwrap_or_default();
    let refused = |column: usize, wanted: &str| {
        anyhow!("line {line}: {} is '{}', must be {wanted}", COLUMNS[column], cell(column))
    };
    let number = |column: usize| {
        let value: Option<f64> = cell(column).parse().ok();
        value
            .filter(|value| value.is_finite() && *value > 0.0)
            .ok_or_else(|| refused(column, "a number above 0"))
    };
    let drive = DriveKind::ALL.into_iter().find(|drive| drive.name() == cell(0).to_lowercase());
    let drive = drive.ok_or_else(|| refused(0, "bowden or direct"))?;
    if cell(1).is_empty() {
        return Err(refused(1, "a polymer"));
    }
    Ok(Measured {
        drive,
        polymer: cell(1).to_uppercase(),
        at: Condition {
            temperature: Celsius(number(2)?),
            height_m: 1e-3 * number(3)?,
            width_m: 1e-3 * number(4)?,
        },
        advance_s: number(5)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "drive,polymer,temperature_c,height_mm,width_mm,advance_s\n";

    #[test]
    fn measured_lines_are_refused_by_line_and_column() {
        let refused = |text: &str| parse(text).unwrap_err().to_string();
        assert_eq!(refused("drive,polymer\n"), "line 1: no column 'temperature_c'");
        assert_eq!(refused(""), "line 1: no column 'drive'");
        let error = refused(&format!("{HEAD}bowden,PLA,215,0.2,0.4,0.6\nbowden,PLA,nan,0.2,0.4,0.6\n"));
        assert_eq!(error, "line 3: temperature_c is 'nan', must be a number above 0");
        let error = refused(&format!("{HEAD}remote,PLA,215,0.2,0.4,0.6\n"));
        assert_eq!(error, "line 2: drive is 'remote', must be bowden or direct");
        // A row cut short is no row with empty cells.
        let error = refused(&format!("{HEAD}bowden,PLA,215,0.2\n"));
        assert!(error.contains("line: 2") && error.contains("4 fields"), "{error}");
    }

    /// Comments, notes, any order of columns, a comma inside of quotes.
    #[test]
    fn measured_lines_are_read_with_what_a_person_notes() {
        let text = "note,drive,polymer,temperature_c,height_mm,width_mm,advance_s\n# mine\n\n\
                    \"dry, new\",Direct, pla ,215,0.2,0.4,0.04\n";
        let at = Condition { temperature: Celsius(215.0), height_m: 2e-4, width_m: 4e-4 };
        let wanted = Measured { drive: DriveKind::Direct, polymer: "PLA".to_owned(), at, advance_s: 0.04 };
        assert_eq!(parse(text).unwrap(), [wanted]);
    }
}
