//! What is refused, and what is told of a pattern.

use super::super::DriveName;
use super::super::tests::setup;
use super::*;

/// What the pattern gave is trained with as it is printed: the row is one of a person's file.
#[test]
fn the_row_to_train_with_is_one_of_a_persons_file() {
    let (config, setup) = setup();
    let (polymer, drive) = ("pla".to_owned(), DriveName::Direct);
    let printed = Printed { drive, polymer, config: None, models: None, json: None };
    let place = Place { temperature: 215.0, height: 0.2, width: 0.4 };
    let args = CalibrateArgs { printed, place, printer: Printer::Line, seed: 1 };
    let mut figures = figures(&args, &config).unwrap();
    figures.agree = true;
    let mut told = text(&figures).lines().take(2).map(str::to_owned).collect::<Vec<_>>();
    let heading = told.remove(0);
    assert!(heading.contains("K [s]  RMS error [%]"), "{heading}");
    assert_eq!(told[0].len(), heading.find("  (").unwrap(), "{heading}\n{}", told[0]);
    assert!(!text(&figures).contains("--measured"), "{}", text(&figures));
    figures.agree = false;
    let [command, names, row] = row(&figures);
    assert!(text(&figures).contains(&command), "{}", text(&figures));
    let read = super::super::measured::parse(&format!("{}\n{}\n", names.trim(), row.trim()), &setup);
    let read = read.unwrap();
    assert!(read.len() == 1 && read[0].at == place.condition() && read[0].drive == DriveKind::Direct);
    assert!((read[0].advance_s - figures.advance_s).abs() < 1e-4);
}

/// 14.4 mm3/s of ABS at 245 degC: the drive slips on the fast stretch, and no K found there is the lag's. Told as such.
#[test]
fn a_line_that_the_drive_cannot_push_is_refused() {
    let printed =
        Printed { drive: DriveName::Bowden, polymer: "ABS".into(), config: None, models: None, json: None };
    let place = Place { temperature: 245.0, height: 0.3, width: 0.6 };
    let args = CalibrateArgs { printed, place, printer: Printer::Plant, seed: 1 };
    let error = figures(&args, &setup().0).unwrap_err().to_string();
    assert!(error.starts_with("at the best K, ") && error.contains("thinner than the slow ones"), "{error}");
}

#[test]
fn the_simulated_printer_is_not_taken_for_another_drive() {
    for printer in [Printer::Simulated, Printer::Plant] {
        let error = check_drive(printer, DriveKind::Direct).unwrap_err().to_string();
        assert!(error.starts_with("--drive direct: the simulated printer has a bowden drive"), "{error}");
        assert!(check_drive(printer, DriveKind::Bowden).is_ok());
    }
    assert!(check_drive(Printer::Line, DriveKind::Direct).is_ok());
}
