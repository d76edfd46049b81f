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
    for (silent_s, cut) in [(60.0, true), (10.0, false)] {
        let mut print = Print::acting();
        print.hotend = false;
        print.run(silent_s);
        print.hotend = true;
        (print.report.hotend_duty, print.temp_c) = (0.0, 150.0);
        print.run(30.0);
        assert_eq!(print.mode(), if cut { Mode::Estop } else { Mode::SafeOff }, "{silent_s} s");
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
