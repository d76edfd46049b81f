use super::*;
use crate::config::{Choice, ConfigDir};
use crate::job::GcodeFile;
use models::units::Celsius;
use mpc_controller::params::Level;
use printer_sim::job::Preheat;
use std::path::Path;

/// A warm printer that lays two lines; between them stands `between`.
fn two_lines(between: &str) -> Printing {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    let config = ConfigDir::find(Some(&folder)).unwrap();
    let text = format!(
        "M140 S60\nM104 S215\nG28\nM190 S60\nM109 S215\nM83\nG1 Z0.2 F600\nG1 X80 E2.6 F1800\n{between}\nG1 X0 E2.6\n"
    );
    let file = GcodeFile::of_text(&text, &config.motion().unwrap(), None).unwrap();
    let setup = config.load(&Choice::of("PLA".to_owned(), Level::Mpc)).unwrap();
    let mut printing = Printing::new(&setup, file.job(&setup), &Scenario::default(), 1).unwrap();
    let warm = Preheat { hotend: Some(Celsius(215.0)), bed: Some(Celsius(60.0)) };
    printing.simulator_mut().warm_up(&warm);
    while printing.step() && !printing.is_stuck() {}
    printing
}

/// C14 is a printer that pauses by itself. One that does what line 9 of its file says does no such thing.
#[test]
fn a_pause_that_the_file_asks_for_is_no_alarm() {
    for command in ["M600", "M0", "M25"] {
        let printing = two_lines(command);
        assert!(printing.is_stuck(), "{command}: nobody resumes");
        assert_eq!(printing.noticed, [], "{command}");
        let lines: Vec<u64> = printing.file_pauses.iter().map(|pause| pause.line).collect();
        assert_eq!(lines, [9], "{command}");
    }
    let printing = two_lines("G4 P10");
    assert_eq!((printing.simulator().phase(), printing.file_pauses.len()), (JobPhase::Done, 0));
}
