//! P1 behind a blind thermistor: what is off by order and not seen to be goes off the mains.

mod common;

use common::print::Print;
use models::command::Mode;
use safety_supervisor::{Cause, Operator, What};

/// As it is in the parameter file `[s]`.
const UNSEEN_S: f64 = 8.0;
/// The order, the tick that sees it carried out, and the one that is beyond the limit `[s]`.
const TICKS_S: f64 = 0.08;

/// How long it takes to SAFE_OFF, and from there to ESTOP `[s]`.
fn steps(print: &mut Print) -> (f64, f64) {
    let safe_off_s = print.until(Mode::SafeOff);
    (safe_off_s, print.until(Mode::Estop))
}

fn is_in_time(took_s: f64) -> bool {
    (UNSEEN_S..UNSEEN_S + TICKS_S).contains(&took_s)
}

#[test]
fn p1_behind_an_open_thermistor_the_mains_go_and_its_return_may_be_acknowledged() {
    let mut print = Print::acting();
    print.temp_c = -30.0;
    let (safe_off_s, estop_s) = steps(&mut print);
    assert!(safe_off_s < 0.5 && is_in_time(estop_s), "{safe_off_s} {estop_s}");
    assert_eq!(print.output.state.cause, Some(Cause::HeatUnseen));
    let evidence = print.output.state.evidence.unwrap();
    assert!(evidence.to_string().contains("limit 8.0 s"), "{evidence}");
    assert_eq!(print.ask(Operator::Acknowledge), What::Denied(Operator::Acknowledge), "still open");
    print.temp_c = 25.0;
    print.run(3.0);
    assert_eq!(
        print.ask(Operator::Acknowledge),
        What::Granted(Operator::Acknowledge),
        "{:?}",
        print.output.events
    );
}

#[test]
fn p1_without_readings_the_mains_go_and_with_readings_again_they_stay() {
    for (unseen_s, cut) in [(60.0, true), (6.0, false)] {
        let mut print = Print::acting();
        print.hotend = false;
        print.until(Mode::SafeOff);
        print.report.hotend_duty = 0.0;
        print.run(unseen_s);
        print.hotend = true;
        for tenth in 0..300_u32 {
            print.temp_c = 25.0 + 175.0 * (-f64::from(tenth) / 2420.0).exp(); // 16.7 J/K, 0.069 W/K
            print.run(0.1);
        }
        let cause = print.output.state.cause;
        assert_eq!(print.mode(), if cut { Mode::Estop } else { Mode::SafeOff }, "{unseen_s} s: {cause:?}");
    }
}

/// Which fault came first counts for nothing, and a stop that is seen to cool stays one.
#[test]
fn p1_a_thermistor_that_fails_behind_a_stop_counts_too() {
    let mut print = Print::acting();
    print.ask(Operator::Stop);
    print.report.hotend_duty = 0.0;
    for _ in 0..60 {
        print.temp_c -= 1.0;
        print.run(1.0);
    }
    assert_eq!(print.mode(), Mode::SafeOff, "{:?}", print.output.state.cause);
    print.hotend = false;
    let took_s = print.until(Mode::Estop);
    assert!(is_in_time(took_s - 3.0), "3 s of S7 and the limit: {took_s}");
}

/// Sets the reading's course from one tenth of a second to the next, from 210 degC on.
type Course = fn(&mut Print, f64);

/// Readings that are not the block's, behind a stop too: which fault came first counts for nothing.
#[test]
fn p1_readings_that_are_not_the_blocks_are_doubted_whatever_was_latched() {
    let stands: Course = |print, _| print.bits = 0.0;
    let falls: Course = |print, since_s| print.temp_c = 210.0 - 8.0 * since_s.min(20.0);
    let steps: Course = |print, _| print.temp_c = 180.0;
    for (course, stop) in [(stands, false), (stands, true), (falls, false), (falls, true), (steps, true)] {
        let mut print = Print::acting();
        print.run(5.0);
        if stop {
            print.ask(Operator::Stop);
            print.report.hotend_duty = 0.0;
        }
        let from_s = print.now();
        while print.mode() != Mode::Estop && print.now() - from_s < 40.0 {
            let since_s = print.now() - from_s;
            course(&mut print, since_s);
            print.run(0.1);
        }
        assert_eq!(print.output.state.cause, Some(Cause::HeatUnseen), "after {:.1} s", print.now() - from_s);
    }
}

/// A reading now and then is none: only what lasts for a second is seen.
#[test]
fn p1_a_plug_that_makes_contact_now_and_then_shows_nothing() {
    let mut print = Print::acting();
    let from_s = print.now();
    while print.mode() != Mode::Estop && print.now() - from_s < 30.0 {
        let contact = (print.now() - from_s) % 1.0 > 0.75;
        print.temp_c = if contact { 210.0 } else { -30.0 };
        print.run(0.02);
    }
    let took_s = print.now() - from_s;
    assert!(print.mode() == Mode::Estop && took_s < 10.0, "{took_s}");
}

/// A printer that is switched off says nothing at all, and no order would reach it.
#[test]
fn a_printer_that_is_switched_off_is_not_cut_off_the_mains() {
    let mut print = Print::acting();
    (print.hotend, print.printer, print.encoder) = (false, false, false);
    print.run(60.0);
    assert_eq!(print.mode(), Mode::SafeOff, "{:?}", print.output.state.cause);
}
