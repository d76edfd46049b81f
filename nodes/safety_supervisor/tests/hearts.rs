//! C4: a process hangs, and its heart tells before its messages are late.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::print::{Print, SOUND};
use models::command::Mode;
use models::status::JobPhase;
use safety_supervisor::checks::hearts::{HeartsCheck, LOOK_S};
use safety_supervisor::{Cause, Event, Worker};

/// Runs the print while these beat ten times a second, and the shell looks twenty times.
fn beating(print: &mut Print, workers: &[Worker], span_s: f64) {
    let end_s = print.now() + span_s;
    while print.now() < end_s - 1e-9 {
        if print.tick.is_multiple_of(25) && print.report.phase == JobPhase::Printing {
            print.event(Event::Vision(SOUND));
        }
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

/// Seven looks of 50 ms are 0.35 s, however long they took: a supervisor that stood still looks once, and has missed nobody.
#[test]
fn looks_count_and_not_time() {
    let mut hearts = HeartsCheck::new(0.35);
    let mut looks = |count: u32, beats: bool| {
        if beats {
            hearts.beat(Worker::Judge);
        }
        (0..count).for_each(|_| hearts.look());
        hearts.hang_s(Worker::Judge)
    };
    assert_eq!([looks(20, false), looks(6, true), looks(6, true)], [None; 3]);
    let (silent_s, limit_s) = looks(1, false).unwrap();
    assert!(
        (silent_s - 7.0 * LOOK_S).abs() < 1e-12 && (limit_s - 0.35).abs() < 1e-12,
        "{silent_s} {limit_s}"
    );
}

/// A camera that was tried and taken away again, and never showed a frame: no print is degraded for it.
#[test]
fn whoever_never_sent_anything_is_not_missed() {
    let mut print = Print::acting();
    let others = [Worker::Encoder, Worker::Estimator, Worker::Controller];
    print.event(Event::Beat(Worker::Camera));
    for _ in 0..500 {
        others.into_iter().for_each(|worker| print.event(Event::Beat(worker)));
        print.event(Event::Look);
        print.step();
    }
    assert_eq!(print.mode(), Mode::Act, "{:?}", print.output.state.cause);
}

/// Frames are judged and corrections are wished for while the job prints.
#[test]
fn beside_a_print_nobody_misses_the_camera_and_the_controller() {
    let mut print = acting();
    print.report.phase = JobPhase::Idle;
    beating(&mut print, &[Worker::Encoder, Worker::Estimator], 2.0);
    assert_eq!(print.mode(), Mode::Act, "{:?}", print.output.state.cause);
}
