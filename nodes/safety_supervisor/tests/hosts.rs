//! What a sound host does that looks like a fault: it goes on late, and counts its filament anew.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::print::Print;
use models::command::Mode;
use models::status::JobPhase;
use safety_supervisor::{Operator, What};

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
        assert_eq!(print.mode(), mode, "{stands_s} s");
        // Once it has gone on, a pause is its own again.
        print.report.phase = JobPhase::Paused;
        print.run(1.5);
        assert_eq!(print.mode(), Mode::Paused, "{stands_s} s");
    }
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
