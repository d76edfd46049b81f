use super::*;
use crate::config::{Choice, ConfigDir};
use crate::job::GcodeFile;
use models::units::Celsius;
use mpc_controller::params::Level;
use printer_sim::job::Preheat;
use std::path::Path;

/// A printer under a control level, with a hot end at `hotend_c`.
fn printing(text: &str, level: Level, hotend_c: f64) -> Printing {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    let config = ConfigDir::find(Some(&folder)).unwrap();
    let file = GcodeFile::of_text(text, &config.motion().unwrap(), None).unwrap();
    let setup = config.load(&Choice::of("PLA".to_owned(), level)).unwrap();
    let mut printing = Printing::new(&setup, file.job(&setup), &Scenario::default(), 1).unwrap();
    let warm = Preheat { hotend: Some(Celsius(hotend_c)), bed: Some(Celsius(60.0)) };
    printing.simulator_mut().warm_up(&warm);
    printing
}

/// A warm printer with this file behind its start.
fn warm(body: &str) -> Printing {
    let text = format!("M140 S60\nM104 S215\nG28\nM190 S60\nM109 S215\nM83\nG1 Z0.2 F600\n{body}\n");
    printing(&text, Level::Mpc, 215.0)
}

/// It lays two lines; between them stands `between`.
fn two_lines(between: &str) -> Printing {
    let mut printing = warm(&format!("G1 X80 E2.6 F1800\n{between}\nG1 X0 E2.6"));
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

/// Trims that are attached after a pause of so long in the midst of lines of 0.33 s, of which a second is known ahead.
fn attached_after(pause_s: f64) -> usize {
    let mut printing = warm(&"G1 X10 E0.33 F1800\nG1 X0 E0.33\n".repeat(60));
    while printing.simulator().attached() < 3 || !printing.simulator().truth().depositing {
        assert!(printing.step(), "no trim was attached in the whole print");
    }
    printing.ask(Operator::Pause);
    let until_s = printing.simulator().now().0 + pause_s;
    while printing.simulator().now().0 < until_s {
        printing.step();
    }
    printing.simulator().attached()
}

/// The printer's node drops a trim once `schedule_validity_s`, 5 s, has passed unless its move has begun; so does this one.
#[test]
fn a_scheduled_trim_lapses_in_a_long_pause_as_over_dds() {
    let (short, long) = (attached_after(2.0), attached_after(5.5));
    assert!(short >= 3 && long <= 1, "{short} after 2 s, {long} after 5.5 s");
}

/// `M109` heats the hot end up, and no halt comes before the roads: what was planned for them was planned for a cold nozzle.
#[test]
fn corrections_behind_a_heat_up_lay_no_worse_a_print_than_none() {
    let text = "G28\nM190 S60\nM109 S215\nM83\nG1 Z0.2 F600\nG1 X80 E2.6 F1800\nG1 X0 E2.6\n";
    let quality = |level| {
        let mut printing = printing(text, level, 60.0);
        while printing.step() && !printing.is_stuck() {}
        assert_eq!(printing.simulator().phase(), JobPhase::Done);
        printing.simulator().truth().integrals.since(&Default::default()).unwrap().quality_mean
    };
    let (off, mpc) = (quality(Level::Off), quality(Level::Mpc));
    assert!(mpc < 1.05 * off, "Q {mpc} with corrections, {off} without");
}
