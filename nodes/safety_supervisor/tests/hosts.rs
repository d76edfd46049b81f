//! What a sound host does that looks like a fault: it goes on late, and counts its filament anew.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::print::Print;
use models::command::Mode;
use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use safety_supervisor::{Event, Operator, PrinterReport, What};

/// A host of 2 s, and a resume macro that primes: the job goes on later than it was let to.
#[test]
fn a_printer_that_is_slow_to_go_on_has_not_paused_by_itself() {
    for (stands_s, mode) in [(0.5, Mode::Act), (3.0, Mode::Act), (9.0, Mode::Act), (11.0, Mode::Paused)] {
        let mut print = Print::acting();
        print.ask(Operator::Pause);
        print.report.phase = JobPhase::Paused;
        print.run(3.0);
        assert_eq!(print.ask(Operator::Resume), What::Granted(Operator::Resume));
        print.run(stands_s);
        assert_eq!(print.mode(), mode, "{stands_s} s");
        print.report.phase = JobPhase::Printing;
        print.run(3.0);
        assert_eq!(print.mode(), Mode::Act, "{stands_s} s: taken for a pause of its own, it ends as one");
        // Once it has gone on, a pause is its own again.
        print.report.phase = JobPhase::Paused;
        print.run(1.5);
        assert_eq!(print.mode(), Mode::Paused, "{stands_s} s");
    }
}

/// M0, M600 or a hand at the display: the pause is the printer's, and ends where it began. One that was asked for here does not.
#[test]
fn a_pause_of_the_printer_ends_at_the_printer_and_one_of_ours_does_not() {
    let mut print = Print::acting();
    for _ in 0..2 {
        print.report.phase = JobPhase::Paused;
        print.run(90.0);
        assert_eq!(print.mode(), Mode::Paused);
        print.report.phase = JobPhase::Printing;
        print.step();
        let told = print.output.events.iter().any(|told| told.why == "resumed at the printer");
        assert!(told && print.mode() == Mode::Act, "{:?}", print.output.events);
        print.run(5.0);
        assert_eq!(print.mode(), Mode::Act, "{:?}", print.output.state.cause);
    }
    print.ask(Operator::Pause);
    print.report.phase = JobPhase::Paused;
    print.run(3.0);
    print.report.phase = JobPhase::Printing;
    print.run(3.0);
    assert_eq!(print.mode(), Mode::Paused, "who does not obey is none that was let go on");
}

/// A position that leaps is no filament that slips; one that slips is found after it all the same.
#[test]
fn a_motor_position_that_leaps_pauses_nothing_and_is_told() {
    for leap_m in [0.02, 1.0, -0.5] {
        let mut print = Print::acting();
        print.run(5.0);
        let refused = print.output.state.refused_values;
        print.report.motor_position_m += leap_m;
        print.step();
        print.report.motor_position_m -= leap_m;
        print.run(10.0);
        assert_eq!(print.mode(), Mode::Act, "{leap_m} m");
        assert!(print.output.state.refused_values > refused, "{leap_m} m");
        print.slip = 1.0;
        assert!(print.until(Mode::Paused) < 6.0, "{leap_m} m");
    }
}

/// Orders that are no numbers are refused: a target that is none would count as no heat.
#[test]
fn a_state_whose_targets_are_no_numbers_is_refused() {
    let spoilt: [fn(&mut PrinterReport); 5] = [
        |report| report.hotend_target = Celsius(f64::NAN),
        |report| report.hotend_sliced_target = Celsius(f64::INFINITY),
        |report| report.bed_target = Celsius(f64::NAN),
        |report| report.path_speed_m_s = f64::NAN,
        |report| report.motor_position_m = f64::NAN,
    ];
    for (number, spoil) in spoilt.into_iter().enumerate() {
        let mut print = Print::acting();
        let mut report = PrinterReport { stamp: Seconds(print.now() + 0.01), ..print.report };
        spoil(&mut report);
        print.event(Event::Printer(report));
        print.run(0.1);
        assert_eq!(print.output.state.refused_values, 1, "{number}");
    }
}

/// A state that was overtaken by 0.1 s is over: the pause that it tells of was resumed. By an hour, the clock was set back.
#[test]
fn a_state_that_was_overtaken_is_over() {
    for (behind_s, mode) in [(0.1, Mode::Act), (3600.0, Mode::Paused)] {
        let mut print = Print::acting();
        print.printer = false;
        let overtaken = Seconds(print.now() - behind_s);
        for _ in 0..110 {
            print.event(Event::Printer(PrinterReport {
                stamp: overtaken,
                phase: JobPhase::Paused,
                ..print.report
            }));
            print.step();
        }
        assert_eq!(print.mode(), mode, "{behind_s} s");
    }
}

/// The encoder's last message, and a prime of 6 mm before its silence is one: nothing is known of what it went.
#[test]
fn c4_what_the_motor_goes_while_the_encoder_is_silent_is_no_slip() {
    let mut print = Print::acting();
    print.run(5.0);
    print.encoder = false;
    for _ in 0..30 {
        print.report.motor_position_m += 3e-4;
        print.step();
        assert!(print.mode() <= Mode::Degraded, "{:?}", print.output.state.cause);
    }
    assert_eq!(print.mode(), Mode::Degraded);
}
