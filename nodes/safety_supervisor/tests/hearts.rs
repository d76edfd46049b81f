//! C4: a process hangs, and its heart tells before its messages are late.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::print::Print;
use models::command::Mode;
use models::status::JobPhase;
use safety_supervisor::checks::hearts::LOOK_S;
use safety_supervisor::{Cause, Event, Worker};

/// Runs the print while these beat ten times a second, and the shell looks twenty times.
fn beating(print: &mut Print, workers: &[Worker], span_s: f64) {
    let end_s = print.now() + span_s;
    while print.now() < end_s - 1e-9 {
        if print.tick.is_multiple_of(5) {
            workers.iter().for_each(|worker| print.event(Event::Beat(*worker)));
        }
        // 20 ms a tick, 50 ms a look.
        if (print.tick * 2) % 5 < 2 {
            print.event(Event::Look);
        }
        print.step();
    }
}

fn acting() -> Print {
    let mut print = Print::acting();
    beating(&mut print, &Worker::ALL, 2.0);
    assert_eq!(print.mode(), Mode::Act, "{:?}", print.output.state.cause);
    print
}

#[test]
fn whoever_hangs_degrades_within_half_a_second_and_returns_with_its_heart() {
    for (hanging, cause) in [
        (Worker::Encoder, Cause::StaleEncoder),
        (Worker::Estimator, Cause::StaleEstimate),
        (Worker::Controller, Cause::StaleCommand),
        (Worker::Camera, Cause::StaleVision),
        (Worker::Judge, Cause::StaleVision),
    ] {
        let mut print = acting();
        let others: Vec<Worker> = Worker::ALL.into_iter().filter(|worker| *worker != hanging).collect();
        // Its last beat may be 0.1 s old by now.
        beating(&mut print, &others, 0.2);
        assert_eq!(print.mode(), Mode::Act, "{hanging:?}: two beats late are none missed");
        beating(&mut print, &others, 0.28);
        let state = &print.output.state;
        assert_eq!((state.mode, state.cause), (Mode::Degraded, Some(cause)), "{hanging:?}");
        // Its own number, not the age of messages that are not late.
        let evidence = state.evidence.unwrap();
        assert!(
            evidence.limit.is_some_and(|limit_s| evidence.value >= limit_s - 0.5 * LOOK_S),
            "{evidence:?}"
        );
        beating(&mut print, &Worker::ALL, 2.5);
        assert_eq!(print.mode(), Mode::Act, "{hanging:?}: back");
    }
}

#[test]
fn whoever_was_never_heard_is_never_missed() {
    let mut print = Print::acting();
    beating(&mut print, &[], 5.0);
    assert_eq!(print.mode(), Mode::Act, "{:?}", print.output.state.cause);
}

/// A supervisor that stood still has not looked: it hears first what has come.
#[test]
fn a_supervisor_that_stood_still_misses_nobody() {
    let mut print = acting();
    print.tick += 15;
    Worker::ALL.into_iter().for_each(|worker| print.event(Event::Beat(worker)));
    beating(&mut print, &Worker::ALL, 0.5);
    assert!(!matches!(print.output.state.cause, Some(Cause::StaleVision)), "{:?}", print.output.state);
}

/// Frames are judged and corrections are wished for while the job prints.
#[test]
fn beside_a_print_nobody_misses_the_camera_and_the_controller() {
    let mut print = acting();
    print.report.phase = JobPhase::Idle;
    beating(&mut print, &[Worker::Encoder, Worker::Estimator], 2.0);
    assert_eq!(print.mode(), Mode::Act, "{:?}", print.output.state.cause);
}
