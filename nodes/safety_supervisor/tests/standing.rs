//! What a person has asked for still holds in a supervisor that was killed and started again.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::print::Print;
use common::{params, params_with};
use models::command::{Mode, Request, Trims};
use models::status::JobPhase;
use models::units::Seconds;
use safety_supervisor::params::StartMode;
use safety_supervisor::{Cause, Decision, Event, Evidence, Latch, Operator, Standing, Supervisor, What};

const RESUMED: What = What::Granted(Operator::Resume);

/// A supervisor whose `start_mode` is `start`, after a run that left that behind.
fn started(start: &str, left: Standing) -> Print {
    let params = params_with("start_mode: observe", &format!("start_mode: {start}"));
    Print::with(Supervisor::new(params, 8, None).after(left))
}

/// The next run of the same supervisor, in act, where its printer stands.
fn killed(print: &Print) -> Print {
    let mut next = started("act", print.supervisor.standing().unwrap_or_default());
    next.report = print.report;
    next
}

/// Runs until the start is over and returns what is told of the former run.
fn taken_over(print: &mut Print) -> Option<Decision> {
    let mut told = Vec::new();
    for _ in 0..50 {
        print.step();
        told.extend(print.output.events.iter().filter(|decision| decision.what == What::Remembered).cloned());
    }
    assert!(told.len() <= 1, "{told:?}");
    told.first().copied()
}

/// The same, as mode before and after, and the cause.
fn remembered(print: &mut Print) -> Option<(Mode, Mode, Option<Cause>)> {
    taken_over(print).map(|told| (told.before, told.after, told.cause.map(|(cause, _)| cause)))
}

#[test]
fn the_stricter_of_start_and_record_holds() {
    let modes = [("observe", StartMode::Observe), ("advise", StartMode::Advise), ("act", StartMode::Act)];
    for (start, start_mode) in modes {
        for (_, mode) in modes {
            let left = Standing { mode: Some(mode), paused: None, standby: false };
            let mut print = started(start, left);
            let wanted = Mode::from(start_mode).min(Mode::from(mode));
            assert_eq!(print.supervisor.standing(), Some(left), "a restart is nobody's order");
            let told = (wanted != start_mode.into()).then_some((start_mode.into(), wanted, None));
            assert_eq!(remembered(&mut print), told, "{start} {mode:?}");
            print.run(5.0);
            assert_eq!((print.mode(), print.output.state.set_mode), (wanted, wanted), "{start} {mode:?}");
            let acts = wanted == Mode::Act;
            assert_eq!(print.output.permit.trims != Trims::NEUTRAL, acts, "{start} {mode:?}");
        }
    }
}

#[test]
fn a_mode_is_kept_from_when_it_was_asked_for() {
    let mut print = Print::acting();
    assert_eq!(print.supervisor.standing(), None, "the start is nobody's order");
    assert_eq!(killed(&print).output.state.set_mode, Mode::Act);
    for (mode, kept) in
        [(Mode::Observe, StartMode::Observe), (Mode::Advise, StartMode::Advise), (Mode::Act, StartMode::Act)]
    {
        print.ask(Operator::SetMode(mode));
        assert_eq!(
            print.supervisor.standing(),
            Some(Standing { mode: Some(kept), paused: None, standby: false })
        );
        assert_eq!(killed(&print).output.state.set_mode, mode);
    }
    print.ask(Operator::SetMode(Mode::Estop));
    assert_eq!(killed(&print).output.state.set_mode, Mode::Act, "what was refused is no order");
}

/// P13: told as what it is, not as a pause of the printer's own, from the first permit on, until a person resumes.
#[test]
fn a_pause_is_kept_with_its_cause() {
    let mut print = Print::acting();
    print.ask(Operator::Pause);
    print.report.phase = JobPhase::Paused;
    let mut next = killed(&print);
    assert_eq!((next.mode(), next.output.permit.request), (Mode::Paused, Request::Pause), "first permit");
    let told = (Mode::Act, Mode::Paused, Some(Cause::OperatorPause));
    assert_eq!(remembered(&mut next), Some(told));
    next.run(5.0);
    assert_eq!((next.mode(), next.output.state.cause), (Mode::Paused, Some(Cause::OperatorPause)));
    assert_eq!(next.output.permit.request, Request::Pause);
    assert_eq!(killed(&next).output.state.cause, Some(Cause::OperatorPause), "a second time");
    assert_eq!(next.ask(Operator::Resume), RESUMED);
    next.report.phase = JobPhase::Printing;
    next.run(3.0);
    assert_eq!((next.mode(), next.supervisor.standing()), (Mode::Act, None));
}

/// A nozzle that was let cool down while nobody was there is not heated because a supervisor was started again: not before
/// its first tick either, nor by the run after that.
#[test]
fn a_pause_in_standby_stays_in_standby() {
    let mut print = Print::acting();
    print.ask(Operator::Pause);
    print.report.phase = JobPhase::Paused;
    print.run(59.0);
    assert_eq!(print.supervisor.standing().map(|left| left.standby), Some(false));
    print.run(2.0);
    assert_eq!(print.supervisor.standing().map(|left| left.standby), Some(true));
    let mut next = killed(&print);
    assert_eq!(killed(&next).output.permit.request, Request::Standby, "killed at once");
    for _ in 0..500 {
        assert_eq!((next.mode(), next.output.permit.request), (Mode::Paused, Request::Standby));
        next.step();
    }
    assert_eq!(next.ask(Operator::Resume), RESUMED);
    assert_ne!(next.output.permit.request, Request::Standby, "a person lets it be heated");
}

/// The printer had not begun to pause when the supervisor was killed.
#[test]
fn a_printer_that_prints_on_is_paused_again() {
    let mut print = Print::acting();
    print.ask(Operator::Pause);
    let mut next = killed(&print);
    next.run(5.0);
    assert_eq!((next.mode(), next.output.permit.request), (Mode::Paused, Request::Pause));
}

/// Its time begins with the first tick, not with the host's.
#[test]
fn a_pause_that_is_taken_over_is_not_old() {
    let left = Standing { mode: None, paused: Some(Cause::FilamentSlip), standby: false };
    let mut supervisor = Supervisor::new(params(), 8, None).after(left);
    let mut request_at = |now_s: f64| {
        let now = Seconds(now_s);
        let output = supervisor.on_event(now, Event::Tick { now }).unwrap();
        (output.permit.mode, output.permit.request)
    };
    for (now_s, request) in
        [(1e6, Request::Pause), (1e6 + 0.02, Request::Pause), (1e6 + 61.0, Request::Standby)]
    {
        assert_eq!(request_at(now_s), (Mode::Paused, request), "{now_s}");
    }
    let mut asked = Supervisor::new(params(), 8, None).after(left);
    let output = asked.on_event(Seconds(1e6), Event::Operator(Operator::SetMode(Mode::Act))).unwrap();
    assert_eq!(output.permit.request, Request::Pause, "before the first tick");
}

/// A pause of a job that is over, at a printer that was switched off and on, waits for nobody.
#[test]
fn a_pause_ends_where_no_job_waits() {
    for phase in [JobPhase::Idle, JobPhase::Done, JobPhase::Failed] {
        let mut print = started(
            "act",
            Standing { mode: Some(StartMode::Advise), paused: Some(Cause::OperatorPause), standby: false },
        );
        print.report.phase = phase;
        assert_eq!(remembered(&mut print), Some((Mode::Act, Mode::Advise, None)), "{phase:?}");
        assert_eq!((print.mode(), print.output.permit.request), (Mode::Advise, Request::Run), "{phase:?}");
        let kept = Standing { mode: Some(StartMode::Advise), paused: None, standby: false };
        assert_eq!(print.supervisor.standing(), Some(kept));
        // A pause of this run is not of the former; a job that is over is not paused.
        let pauses = phase == JobPhase::Idle;
        let asked = print.ask(Operator::Pause);
        assert_eq!(asked == What::Granted(Operator::Pause), pauses, "{phase:?}: {asked:?}");
        print.run(1.0);
        assert_eq!(print.mode() == Mode::Paused, pauses, "{phase:?}");
    }
}

/// One that is heating up for its job has one.
#[test]
fn a_pause_lasts_wherever_a_job_waits() {
    for phase in [JobPhase::Preparing, JobPhase::Printing, JobPhase::Paused] {
        let mut print =
            started("act", Standing { mode: None, paused: Some(Cause::OperatorPause), standby: false });
        print.report.phase = phase;
        print.run(3.0);
        assert_eq!((print.mode(), print.output.permit.request), (Mode::Paused, Request::Pause), "{phase:?}");
    }
}

#[test]
fn a_record_that_cannot_be_read_is_observe_and_paused() {
    let mut print = started("act", Standing::UNREADABLE);
    let told = (Mode::Act, Mode::Paused, Some(Cause::StandingUnreadable));
    assert_eq!(remembered(&mut print), Some(told));
    print.run(5.0);
    let state = print.output.state;
    assert_eq!((state.mode, state.set_mode), (Mode::Paused, Mode::Observe));
    assert_eq!(state.cause, Some(Cause::StandingUnreadable));
    assert_eq!(print.ask(Operator::Resume), RESUMED);
    print.run(3.0);
    assert_eq!(print.mode(), Mode::Observe);
}

/// A latch comes before the pause below it, and ends by its acknowledge as ever.
#[test]
fn a_latch_is_over_the_pause() {
    let latch = Some(Latch { estop: false, cause: Cause::OperatorStop });
    let left = Standing { mode: None, paused: Some(Cause::OperatorPause), standby: false };
    let mut print = Print::with(Supervisor::new(params(), 8, latch).after(left));
    print.run(1.0);
    assert_eq!((print.mode(), print.output.state.cause), (Mode::SafeOff, Some(Cause::OperatorStop)));
    print.report.phase = JobPhase::Failed;
    print.run(0.1);
    assert_eq!(print.ask(Operator::Acknowledge), What::Granted(Operator::Acknowledge));
    print.run(3.0);
    assert_eq!((print.mode(), print.output.permit.request), (Mode::Observe, Request::Run));
}

/// Once, from what was latched on, with the number as it was when the cause was found, where the record has it.
#[test]
fn a_latch_that_is_taken_over_is_told_with_its_cause_and_number() {
    let number = Evidence::of(Cause::HotendRange, 450.0, Some(285.0));
    assert!(number.is_some());
    for (estop, cause, evidence) in [
        (false, Cause::HotendRange, number),
        (false, Cause::HotendRange, None),
        (true, Cause::OperatorEstop, None),
        (false, Cause::LatchUnreadable, None),
    ] {
        let latch = Latch { estop, cause };
        let mut supervisor = Supervisor::new(params(), 8, Some(latch));
        if let Some(evidence) = evidence {
            supervisor = supervisor.resting_on(evidence);
        }
        let mut print = Print::with(supervisor);
        let told = taken_over(&mut print).unwrap();
        assert_eq!((told.before, told.after), (Mode::Observe, latch.mode()));
        assert_eq!(told.cause, Some((cause, evidence)), "{cause:?}");
        assert_eq!(told.why, "taken over from before the supervisor was started again");
        assert_eq!((print.output.state.cause, print.output.state.evidence), (Some(cause), evidence));
        assert_eq!(print.supervisor.evidence_of(cause), evidence, "kept for the next run");
    }
}

/// P6: the slip that paused the job is told by the next run too, and kept for the one after it.
#[test]
fn a_pause_that_is_taken_over_is_told_with_its_number() {
    let mut print = Print::acting();
    print.slip = 0.5;
    print.until(Mode::Paused);
    let evidence = print.supervisor.evidence_of(Cause::FilamentSlip);
    assert!(evidence.is_some_and(|slip| slip.value > 42.0), "{evidence:?}");
    let left = print.supervisor.standing().unwrap();
    let supervisor = Supervisor::new(params(), 8, None).after(left).resting_on(evidence.unwrap());
    let mut next = Print::with(supervisor);
    next.report = print.report;
    next.report.phase = JobPhase::Paused;
    assert_eq!(taken_over(&mut next).unwrap().cause, Some((Cause::FilamentSlip, evidence)));
    assert_eq!(next.supervisor.evidence_of(Cause::FilamentSlip), evidence);
}

/// A latch of this run is no former one's.
#[test]
fn what_is_latched_while_it_starts_is_not_taken_over() {
    let mut print = Print::with(Supervisor::new(params(), 8, None));
    print.ask(Operator::Stop);
    assert_eq!(taken_over(&mut print), None);
}

/// The first change of mode is told as all others are, and once.
#[test]
fn the_end_of_the_start_is_told() {
    let mut print = Print::with(Supervisor::new(params(), 7, None));
    let mut told = Vec::new();
    for _ in 0..100 {
        print.step();
        told.extend(
            print.output.events.iter().map(|event| (event.what, event.before, event.after, event.why)),
        );
    }
    assert_eq!(told, [(What::ModeChanged, Mode::Init, Mode::Observe, "the start is over")]);
}
