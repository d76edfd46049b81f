//! What is told of a person's requests: the cause, the number it rests on, and which mode was set.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::params;
use common::print::Print;
use models::command::Mode;
use models::status::JobPhase;
use models::units::Celsius;
use safety_supervisor::{Cause, Decision, Operator, Supervisor, What};

/// The decision on a request.
fn decided(print: &mut Print, request: Operator) -> Decision {
    print.ask(request);
    *print.output.events.last().unwrap()
}

fn cause(decision: &Decision) -> Option<Cause> {
    decision.cause.map(|(cause, _)| cause)
}

#[test]
fn what_a_person_stops_is_its_own_cause() {
    for (request, told, after) in [
        (Operator::Pause, Cause::OperatorPause, Mode::Paused),
        (Operator::Stop, Cause::OperatorStop, Mode::SafeOff),
        (Operator::Estop, Cause::OperatorEstop, Mode::Estop),
    ] {
        let mut print = Print::acting();
        let decision = decided(&mut print, request);
        assert_eq!((decision.what, decision.why), (What::Granted(request), told.text()));
        assert_eq!(decision.cause, Some((told, None)));
        assert_eq!((decision.before, decision.after), (Mode::Act, after));
    }
}

/// Beneath what stands already a request is told as what it is: carried out, and not the cause.
#[test]
fn what_stood_before_a_request_stays_its_cause() {
    let mut print = Print::acting();
    print.slip = 1.0;
    print.until(Mode::Paused);
    let decision = decided(&mut print, Operator::Pause);
    assert_eq!(decision.what, What::Granted(Operator::Pause));
    assert_eq!(decision.why, "on request; what was in force before it still is");
    let (cause, evidence) = decision.cause.unwrap();
    assert_eq!(cause, Cause::FilamentSlip);
    assert!(evidence.is_some_and(|slip| slip.limit == Some(42.0)), "{evidence:?}");
}

/// The set mode is what changes; what keeps it from being in force is told beside it.
#[test]
fn a_mode_that_is_set_is_told_with_what_it_waits_for() {
    let mut print = Print::with(Supervisor::new(params(), 7, None));
    let observe = Operator::SetMode(Mode::Observe);
    let decision = decided(&mut print, observe);
    assert_eq!((decision.why, decision.cause), ("it holds as soon as the start is over", None));
    print.run(3.0);
    let advise = Operator::SetMode(Mode::Advise);
    let decision = decided(&mut print, advise);
    assert_eq!((decision.why, decision.cause), (Decision::ON_REQUEST, None));
    assert_eq!((decision.before, decision.after), (Mode::Observe, Mode::Advise));
    print.ask(Operator::Pause);
    let decision = decided(&mut print, observe);
    assert_eq!((decision.before, decision.after), (Mode::Advise, Mode::Observe));
    assert_eq!(decision.why, "it holds as soon as what is in force is over");
    assert_eq!((cause(&decision), print.mode()), (Some(Cause::OperatorPause), Mode::Paused));
}

#[test]
fn a_refusal_tells_what_stands_against_it() {
    let mut print = Print::acting();
    print.report.filament_present = Some(false);
    print.until(Mode::Paused);
    print.run(1.0);
    let refused = decided(&mut print, Operator::Resume);
    let stands = "the cause is still there";
    assert_eq!((refused.what, refused.why), (What::Denied(Operator::Resume), stands));
    assert_eq!(cause(&refused), Some(Cause::RunOut));

    print.report.stop_input = Some(true);
    print.until(Mode::Estop);
    let refused = decided(&mut print, Operator::Resume);
    assert_eq!((refused.why, cause(&refused)), ("latched: `fdm acknowledge` first", Some(Cause::StopInput)));
    let refused = decided(&mut print, Operator::Acknowledge);
    assert_eq!((refused.why, cause(&refused)), (stands, Some(Cause::StopInput)));
}

/// The worst of what stands is told, with the number of now where it is not the one that was found.
#[test]
fn of_several_causes_the_worst_stands_against_an_acknowledge() {
    let mut print = Print::acting();
    print.ask(Operator::Stop);
    print.estimator = false;
    print.hotend = false;
    print.run(4.0);
    // A reading that is inside of its range, by a thermistor that fell silent again.
    print.hotend = true;
    print.run(0.5);
    print.hotend = false;
    print.run(3.5);
    let refused = decided(&mut print, Operator::Acknowledge);
    let (cause, age) = refused.cause.unwrap();
    assert_eq!((refused.why, cause), ("the cause is still there", Cause::StaleHotend));
    assert!(age.is_some_and(|age| (3.4..3.7).contains(&age.value)), "{age:?}");
}

#[test]
fn what_is_granted_and_still_waits_says_for_what() {
    let mut print = Print::acting();
    print.ask(Operator::Stop);
    print.report.phase = JobPhase::Paused;
    print.run(1.0);
    let decision = decided(&mut print, Operator::Acknowledge);
    assert_eq!(decision.why, "the job waits: `fdm resume`, or `fdm stop`");
    print.report.hotend_sliced_target = Celsius(230.0);
    print.run(0.1);
    let decision = decided(&mut print, Operator::Resume);
    assert_eq!((decision.what, decision.cause), (What::Granted(Operator::Resume), None));
    assert_eq!(decision.why, "until the printer is homed and hot again");
    print.report.hotend_sliced_target = Celsius(210.0);
    let decision = loop {
        print.step();
        if let Some(decision) = print.output.events.last() {
            break *decision;
        }
        assert!(print.now() < 20.0, "no resume");
    };
    assert_eq!((decision.what, decision.why), (What::ModeChanged, "resumed"));
}

/// The printer gives its job up for an emergency stop, and says so after that was acknowledged: it has not failed by itself.
#[test]
fn a_job_that_was_given_up_on_request_has_not_failed() {
    for (later_s, phase, mode) in [
        (0.3, JobPhase::Failed, Mode::Act),
        (6.0, JobPhase::Failed, Mode::SafeOff),
        (0.3, JobPhase::Done, Mode::Act),
    ] {
        let mut print = Print::acting();
        print.ask(Operator::Estop);
        print.run(0.3);
        assert_eq!(print.ask(Operator::Acknowledge), What::Granted(Operator::Acknowledge));
        print.run(later_s);
        print.report.phase = phase;
        print.run(1.0);
        let cause = (mode == Mode::SafeOff).then_some(Cause::PrinterFailed);
        assert_eq!(
            (print.mode(), print.output.state.cause.filter(|_| cause.is_some())),
            (mode, cause),
            "{later_s} s"
        );
    }
}
