//! Trims of coming moves: what goes on to the printer, and what does not.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::params_with;
use common::print::Print;
use models::command::{AdvanceLaw, Mode, MotionTrim, Scheduled};
use models::units::Seconds;
use safety_supervisor::{Event, Operator, Supervisor};

/// Session of the print's own controller.
const CONTROLLER: u64 = 3;
/// Feed at which the shipped limit of the advance is taken `[m/s]`.
const FEED_M_S: f64 = 2e-3;

fn wish(sequence: u64) -> Scheduled {
    let advance = AdvanceLaw { linear_s: 0.3, shear: 0.01, index: 0.4 };
    let trim = MotionTrim { sequence: sequence + 40, flow: 1.05, speed: 0.9, advance, carried_m: 2e-3 };
    Scheduled { session: CONTROLLER, sequence, validity: Seconds(5.0), trim }
}

fn offer(print: &mut Print, wish: Scheduled) -> Option<Scheduled> {
    let now = Seconds(print.now());
    print.supervisor.on_scheduled(now, wish)
}

/// As it came, but for its publisher: the printer takes a schedule beside this supervisor's permits only.
#[test]
fn in_the_mode_act_a_trim_inside_the_limits_goes_on_as_it_came() {
    let mut print = Print::acting();
    let allowed = [1, 2].map(|sequence| offer(&mut print, wish(sequence)).unwrap());
    assert_eq!(allowed.map(|allowed| allowed.trim), [1, 2].map(|sequence| wish(sequence).trim));
    assert_eq!(allowed.map(|allowed| (allowed.session, allowed.sequence)), [(7, 1), (7, 2)]);
    print.step();
    let state = &print.output.state;
    assert_eq!((state.scheduled, state.refused_schedule, state.clamped_schedule), (2, 0, 0));
}

/// Nothing of a schedule reaches a printer that is only watched, or whose corrections are taken back.
#[test]
fn in_any_other_mode_nothing_goes_on() {
    for start in ["start_mode: observe", "start_mode: advise"] {
        let mut print = Print::with(Supervisor::new(params_with("start_mode: observe", start), 7, None));
        print.run(5.0);
        assert_eq!(offer(&mut print, wish(1)), None, "{start}");
    }
    let mut print = Print::acting();
    print.encoder = false;
    print.until(Mode::Degraded);
    assert_eq!(offer(&mut print, wish(1)), None);
    let mut print = Print::acting();
    print.ask(Operator::Pause);
    assert_eq!(offer(&mut print, wish(1)), None);
}

/// K6: what lies outside comes inside: flow and speed, and all parts of the law by the same factor. Three in a second
/// degrade, as commands do.
#[test]
fn k6_a_schedule_out_of_the_envelope_is_clamped_and_degrades() {
    let mut print = Print::acting();
    let far = AdvanceLaw { linear_s: 3.0, shear: 0.1, index: 0.4 };
    let trim = MotionTrim { sequence: 1, flow: 3.0, speed: 0.1, advance: far, carried_m: 3e-3 };
    let factor = 4.0 / far.advance_s(FEED_M_S);
    for sequence in 1..=3 {
        let sent = offer(&mut print, Scheduled { trim, ..wish(sequence) }).unwrap().trim;
        assert_eq!((sent.flow, sent.speed), (1.25, 0.7));
        assert!((sent.advance.advance_s(FEED_M_S) - 4.0).abs() < 1e-9, "{:?}", sent.advance);
        assert!((sent.advance.linear_s / sent.advance.shear - 30.0).abs() < 1e-9, "{:?}", sent.advance);
        assert!((sent.carried_m - 3e-3 * factor).abs() < 1e-12, "{} m", sent.carried_m);
    }
    print.step();
    assert_eq!((print.mode(), print.output.state.clamped_schedule), (Mode::Degraded, 3));
}

/// K6: more than any clog leaves in a nozzle is not held.
#[test]
fn k6_nobody_carries_more_than_a_nozzle_holds() {
    let mut print = Print::acting();
    let trim = MotionTrim { carried_m: 9e-3, ..wish(1).trim };
    let sent = offer(&mut print, Scheduled { trim, ..wish(1) }).unwrap().trim;
    assert_eq!(sent, MotionTrim { carried_m: 6e-3, ..trim });
    print.step();
    assert_eq!(print.output.state.clamped_schedule, 1);
}

/// C8: out of order, of a publisher without a command in force, longer than may be; and of one that is not finite
/// three in a second degrade (S5).
#[test]
fn c8_what_does_not_count_is_refused_and_counted() {
    let mut print = Print::acting();
    assert!(offer(&mut print, wish(5)).is_some());
    for refused in
        [wish(5), Scheduled { session: 4, ..wish(6) }, Scheduled { validity: Seconds(6.0), ..wish(6) }]
    {
        assert_eq!(offer(&mut print, refused), None);
    }
    print.step();
    assert_eq!((print.output.state.refused_schedule, print.mode()), (3, Mode::Act));
    for sequence in 6..9 {
        let trim = MotionTrim { flow: f64::NAN, ..wish(sequence).trim };
        assert_eq!(offer(&mut print, Scheduled { trim, ..wish(sequence) }), None);
    }
    print.step();
    assert_eq!((print.output.state.refused_values, print.mode()), (3, Mode::Degraded));
}

/// The silence that ends a controller's commands ends its schedule.
#[test]
fn a_schedule_ends_with_the_commands() {
    let mut print = Print::acting();
    print.controller = false;
    // commands count for 1 s; the encoder's and the estimator's own ages are fed
    print.run(1.1);
    let silent = offer(&mut print, wish(1));
    print.event(Event::Tick { now: Seconds(print.now()) });
    assert_eq!((silent, print.output.state.refused_schedule), (None, 1));
}
