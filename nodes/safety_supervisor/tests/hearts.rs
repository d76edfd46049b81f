//! C4: a process hangs, and its heart tells before its messages are late.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::print::{Print, SOUND};
use models::command::Mode;
use models::status::JobPhase;
use models::units::Seconds;
use safety_supervisor::checks::hearts::{HeartsCheck, LOOK_S};
use safety_supervisor::checks::work::WorkCheck;
use safety_supervisor::{Cause, Event, Worker};

/// Runs the print while these beat ten times a second and work, and the shell looks twenty times.
fn beating(print: &mut Print, workers: &[Worker], span_s: f64) {
    working(print, workers, &[], span_s);
}

/// As [`beating`], but these beat without work. Frames come twice a second, plans four times, all else with every beat.
fn working(print: &mut Print, workers: &[Worker], idle: &[Worker], span_s: f64) {
    let end_s = print.now() + span_s;
    while print.now() < end_s - 1e-9 {
        if print.tick.is_multiple_of(25) && print.report.phase == JobPhase::Printing {
            print.event(Event::Vision(SOUND));
        }
        if print.tick.is_multiple_of(5) {
            for worker in workers.iter().filter(|worker| !idle.contains(worker)) {
                let period = match worker {
                    Worker::Camera | Worker::Judge => 25,
                    Worker::Controller => 12,
                    Worker::Encoder | Worker::Estimator => 5,
                };
                print.event(Event::Beat { worker: *worker, work: u64::from(print.tick / period) });
            }
            idle.iter().for_each(|worker| print.event(Event::Beat { worker: *worker, work: STANDS }));
        }
        // 20 ms a tick, 50 ms a look.
        if (print.tick * 2) % 5 < 2 {
            print.event(Event::Look);
        }
        print.step();
    }
}

/// The counter of who does nothing.
const STANDS: u64 = 7;

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
    print.event(Event::Beat { worker: Worker::Camera, work: 0 });
    for _ in 0..500 {
        let work = u64::from(print.tick);
        others.into_iter().for_each(|worker| print.event(Event::Beat { worker, work }));
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

const WATCHED: [(Worker, Cause); 4] = [
    (Worker::Estimator, Cause::EstimatorIdle),
    (Worker::Controller, Cause::ControllerIdle),
    (Worker::Camera, Cause::CameraIdle),
    (Worker::Judge, Cause::JudgeIdle),
];

/// C4, by work: messages come in its name all the while, so that no stream tells.
#[test]
fn whoever_beats_without_work_is_missed_after_the_time_and_taken_back_with_its_work() {
    for (idle, cause) in WATCHED {
        let mut print = acting();
        working(&mut print, &Worker::ALL, &[idle], 3.0);
        assert_eq!(print.mode(), Mode::Act, "{idle:?}: not before {:?}", print.output.state.cause);
        // The judge is due once two frames lie unanswered.
        working(&mut print, &Worker::ALL, &[idle], if idle == Worker::Judge { 1.3 } else { 0.3 });
        let state = &print.output.state;
        assert_eq!((state.mode, state.cause), (Mode::Degraded, Some(cause)), "{idle:?}");
        let evidence = state.evidence.unwrap();
        assert!((evidence.value - 3.1).abs() < 0.11 && evidence.limit == Some(3.0), "{evidence:?}");
        beating(&mut print, &Worker::ALL, 3.0);
        assert_eq!(print.mode(), Mode::Act, "{idle:?}: back, {:?}", print.output.state.cause);
    }
}

/// Two minutes of frames twice a second and plans four times, and of an encoder whose count is left out: it stands.
#[test]
fn whoever_works_slowly_is_not_missed() {
    let mut print = acting();
    working(&mut print, &Worker::ALL, &[Worker::Encoder], 120.0);
    assert_eq!(print.mode(), Mode::Act, "{:?}", print.output.state.cause);
}

/// A plan every 2.5 s, and frames as seldom: slow work is work.
#[test]
fn work_that_comes_before_the_time_is_enough() {
    let mut print = acting();
    for _ in 0..10 {
        working(&mut print, &Worker::ALL, &[Worker::Controller, Worker::Camera, Worker::Judge], 2.5);
        beating(&mut print, &Worker::ALL, 0.1);
        assert_eq!(print.mode(), Mode::Act, "{:?}", print.output.state.cause);
    }
}

/// Before, between and after prints nothing is due, nor as a print begins.
#[test]
fn whoever_idles_beside_a_print_is_not_missed() {
    for phase in [JobPhase::Idle, JobPhase::Preparing, JobPhase::Done] {
        let mut print = acting();
        for (phase, span_s) in [(phase, 10.0), (JobPhase::Printing, 2.5)] {
            print.report.phase = phase;
            working(&mut print, &Worker::ALL, &WATCHED.map(|(worker, _)| worker), span_s);
            assert_eq!(print.mode(), Mode::Act, "{phase:?}: {:?}", print.output.state.cause);
        }
    }
}

/// A frame every ten seconds, and a judge whose beat tells of it before the camera's: nothing is due until the next one.
#[test]
fn a_frame_that_the_judge_was_first_to_tell_of_is_answered() {
    let mut print = acting();
    for beat in 0..600_u32 {
        let (camera, judge) = (u64::from(beat / 100), u64::from((beat + 1) / 100));
        print.event(Event::Beat { worker: Worker::Judge, work: judge });
        // What a frame every ten seconds is late by is another matter, and so is a camera that seems to rest between.
        print.event(Event::Beat { worker: Worker::Camera, work: camera });
        (0..5).for_each(|_| {
            if print.tick.is_multiple_of(25) {
                print.event(Event::Vision(SOUND));
            }
            print.step();
        });
        assert_ne!(print.output.state.cause, Some(Cause::JudgeIdle));
    }
}

/// Its camera gives nothing: the judge has nothing to do, and is not the one to be started again.
#[test]
fn without_frames_the_camera_is_missed_and_not_the_judge() {
    let mut print = acting();
    working(&mut print, &Worker::ALL, &[Worker::Camera, Worker::Judge], 10.0);
    assert_eq!(print.output.state.cause, Some(Cause::CameraIdle));
}

/// A simulated clock that stands for a minute holds work up, not beats; one that runs fast leaves few beats to a second.
#[test]
fn work_stands_still_by_both_clocks_or_not_at_all() {
    let mut work = WorkCheck::new(3.0);
    let mut idle = |now_s: f64, beats: u32| {
        (0..beats).for_each(|_| work.beat(Seconds(now_s), Worker::Controller, STANDS));
        work.idle_s(Seconds(now_s), Worker::Controller).is_some()
    };
    assert_eq!([idle(0.0, 600), idle(2.9, 1), idle(3.1, 1)], [false, false, true]);
    let mut fast = WorkCheck::new(3.0);
    let mut idle = |now_s: f64| {
        fast.beat(Seconds(now_s), Worker::Controller, STANDS);
        fast.idle_s(Seconds(now_s), Worker::Controller).is_some()
    };
    assert!(!(0..=30).any(|beat| idle(2.0 * f64::from(beat))));
    assert!(idle(62.0));
}
