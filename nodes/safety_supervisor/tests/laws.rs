//! What a person reads of the supervisor, and its times: since when, how often refused, how long a start waits.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::print::Print;
use common::{params, params_with};
use models::command::{Command, Mode, Request, Trims};
use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use safety_supervisor::{Cause, Decision, Event, Operator, Stream, Supervisor, What};

/// A supervisor that begins when the host has been up for a while.
fn late(start_ticks: u32, change: impl FnOnce(&mut Print)) -> Print {
    let mut print = Print::with(Supervisor::new(params(), 7, None));
    print.supervisor = Supervisor::new(params(), 7, None);
    print.tick = start_ticks;
    change(&mut print);
    print.step();
    print
}

/// 10 s, whatever the clock said at the start; then what did not come is missing.
#[test]
fn a_start_waits_for_its_streams_and_no_longer_than_it_may() {
    for start_ticks in [0, 250_000] {
        let mut print = late(start_ticks, |print| print.hotend = false);
        print.run(9.9);
        assert_eq!(print.mode(), Mode::Init, "{start_ticks}");
        print.run(0.3);
        assert_eq!(print.mode(), Mode::Observe, "{start_ticks}");
        let took_s = print.until(Mode::SafeOff);
        assert!((2.7..3.3).contains(&took_s), "{took_s}");
        assert_eq!(print.output.state.cause, Some(Cause::StaleHotend));
        let mut print = late(start_ticks, |_| ());
        print.run(0.2);
        assert_eq!(print.mode(), Mode::Observe, "all is there");
    }
}

#[test]
fn since_when_a_mode_is_in_force() {
    let mut print = Print::acting();
    let since = print.output.state.since.0;
    assert!((since - 0.1).abs() < 0.03, "{since}");
    print.ask(Operator::Pause);
    let paused_s = print.now();
    print.run(3.0);
    assert!((print.output.state.since.0 - paused_s).abs() < 0.03);
    print.ask(Operator::Resume);
    let resumed_s = print.now();
    print.run(1.0);
    assert!((print.output.state.since.0 - resumed_s).abs() < 0.03);
    print.ask(Operator::Estop);
    assert!((print.output.state.since.0 - print.now()).abs() < 1e-9);
}

/// As long as the controller takes for a command.
fn period(print: &mut Print) {
    (0..12).for_each(|_| print.step());
}

#[test]
fn refusals_and_clamps_are_counted_one_by_one() {
    let mut print = Print::acting();
    let state = &print.output.state;
    assert_eq!((state.refused_commands, state.clamped_commands, state.refused_values), (0, 0, 0));
    let command = Command { session: 4, sequence: 1, validity: Seconds(1.0), trims: Trims::NEUTRAL };
    print.event(Event::Command(command));
    print.event(Event::Command(Command { validity: Seconds(f64::NAN), ..command }));
    print.event(Event::Command(Command { session: 3, validity: Seconds(f64::NAN), ..command }));
    print.event(Event::Refused { stream: Stream::Bed });
    print.event(Event::Bed { stamp: Seconds(0.0), temp: Celsius(f64::INFINITY) });
    print.step();
    let state = &print.output.state;
    // A command that is not finite is a bad value as well, but for a stranger's: that is his.
    assert_eq!((state.refused_commands, state.refused_values), (3, 3));
    print.wish.flow = 2.0;
    period(&mut print);
    assert_eq!(print.output.state.clamped_commands, 1);
}

/// Once a tick, with what the tick's own step leaves: 0.6 a second for 20 ms. What was decided waits for the tick.
#[test]
fn a_command_is_answered_at_once_and_moves_no_faster_for_it() {
    let mut print = Print::acting();
    period(&mut print);
    let before = print.output.permit;
    print.wish.flow += 0.2;
    let now = Seconds(print.now() + 0.005);
    let commands: [Event; 2] = std::array::from_fn(|_| print.command());
    let answer = print.supervisor.on_event(now, commands[0].clone()).unwrap();
    assert!((answer.permit.trims.flow - before.trims.flow - 0.012).abs() < 1e-9, "{:?}", answer.permit);
    assert_eq!((answer.permit.sequence, answer.events.len()), (before.sequence + 1, 0));
    assert_eq!(print.supervisor.on_event(now, commands[1].clone()), None, "once a tick");
    print.controller = false;
    print.step();
    assert!((print.output.permit.trims.flow - before.trims.flow - 0.024).abs() < 1e-9);
    let clamped = |decision: &Decision| decision.what == What::CommandClamped;
    assert!(print.output.events.iter().any(clamped), "{:?}", print.output.events);
}

/// Nothing to do at once: a refused command, and one that is not carried out.
#[test]
fn what_is_not_carried_out_is_not_answered() {
    let mut print = Print::acting();
    period(&mut print);
    let now = Seconds(print.now());
    let stranger = Command { session: 4, sequence: 1, validity: Seconds(1.0), trims: Trims::NEUTRAL };
    assert_eq!(print.supervisor.on_event(now, Event::Command(stranger)), None);
    for mode in [Mode::Observe, Mode::Advise] {
        print.ask(Operator::SetMode(mode));
        period(&mut print);
        let command = print.command();
        assert_eq!(print.supervisor.on_event(Seconds(print.now()), command), None, "{mode:?}");
    }
}

/// A command may move the trims as fast as its limits say over the time since the one before, and no faster.
#[test]
fn k6_the_slew_of_commands_is_taken_over_the_time_between_them() {
    // 0.6 a second over 0.24 s, for which the controller's period of 0.25 s counts.
    for (step, clamped) in [(0.14, 0), (0.16, 1)] {
        let mut print = Print::acting();
        let before = print.wish.flow;
        period(&mut print);
        print.wish.flow = before + step;
        period(&mut print);
        assert_eq!(print.output.state.clamped_commands, clamped, "{step}");
    }
    let mut print = Print::acting();
    print.controller = false;
    period(&mut print);
    print.controller = true;
    print.wish.flow += 0.2;
    period(&mut print);
    assert_eq!(print.output.state.clamped_commands, 0, "twice the time, twice the way");
}

/// C8: a stranger is a rival once the bound controller speaks after it, for as long as it is remembered.
#[test]
fn c8_a_rival_is_remembered_for_two_seconds() {
    let mut print = Print::acting();
    let command = Command { session: 4, sequence: 1, validity: Seconds(1.0), trims: Trims::NEUTRAL };
    print.event(Event::Command(command));
    let heard_s = print.now();
    print.until(Mode::Degraded);
    assert_eq!(print.output.state.cause, Some(Cause::SecondPublisher));
    // 2 s of memory and 1 s in which the cause must be gone.
    print.until(Mode::Act);
    assert!((print.now() - heard_s - 3.0).abs() < 0.1, "{}", print.now() - heard_s);
}

/// Of a pause that a resume has to end, and of the hot end before it.
#[test]
fn a_resume_wants_a_hot_end_within_its_margin() {
    for (temp_c, resumed) in [(204.5, false), (205.5, true)] {
        let mut print = Print::acting();
        print.ask(Operator::Pause);
        print.report.phase = JobPhase::Paused;
        print.temp_c = temp_c;
        print.report.hotend_duty = 0.31;
        print.run(0.5);
        assert_eq!(print.ask(Operator::Resume), What::Granted(Operator::Resume));
        assert_eq!(print.output.permit.request == Request::Run, resumed, "{temp_c}");
    }
    let mut print = Print::acting();
    assert_eq!(print.ask(Operator::Resume), What::Denied(Operator::Resume), "nothing is paused");
    assert_eq!(print.ask(Operator::Acknowledge), What::Denied(Operator::Acknowledge), "nothing is latched");
    assert_eq!(print.ask(Operator::Approve), What::Denied(Operator::Approve), "not in advise");
}

/// While a pause cause lasts no resume ends the pause, and one that waits for heat is taken back.
#[test]
fn a_cause_that_comes_while_a_resume_waits_holds_the_pause() {
    let mut print = Print::acting();
    print.ask(Operator::Pause);
    print.report.phase = JobPhase::Paused;
    print.report.hotend_sliced_target = Celsius(230.0);
    print.run(0.5);
    assert_eq!(print.ask(Operator::Resume), What::Granted(Operator::Resume));
    print.printer = false;
    print.run(3.2);
    print.printer = true;
    print.report.hotend_sliced_target = Celsius(210.0);
    print.run(1.0);
    assert_eq!((print.mode(), print.output.permit.request), (Mode::Paused, Request::Pause));
    assert_eq!(print.ask(Operator::Resume), What::Granted(Operator::Resume));
    assert_eq!(print.output.permit.request, Request::Run);
}

/// Corrections come back at their slew, and go back along a straight line of 0.8 s.
#[test]
fn trims_go_and_come_at_their_pace() {
    let mut print = Print::acting();
    let start = print.output.permit.trims.flow;
    print.ask(Operator::SetMode(Mode::Observe));
    print.run(0.4);
    let half = print.output.permit.trims.flow;
    assert!((half - 1.0 - (start - 1.0) / 2.0).abs() < 0.002, "{half}");
    print.run(0.45);
    assert_eq!(print.output.permit.trims, Trims::NEUTRAL);
    print.ask(Operator::SetMode(Mode::Act));
    print.step();
    // 0.6 a second for a tick of 20 ms.
    assert!((print.output.permit.trims.flow - 1.012).abs() < 1e-9, "{}", print.output.permit.trims.flow);
}

#[test]
fn a_job_that_the_printer_gave_up_is_answered_once() {
    let mut print =
        Print::with(Supervisor::new(params_with("start_mode: observe", "start_mode: act"), 7, None));
    print.run(1.0);
    print.report.phase = JobPhase::Failed;
    print.step();
    assert_eq!((print.mode(), print.output.state.cause), (Mode::SafeOff, Some(Cause::PrinterFailed)));
    assert!(!print.output.state.what_to_do.is_empty());
    print.run(0.1);
    assert_eq!(print.ask(Operator::Acknowledge), What::Granted(Operator::Acknowledge));
    print.run(3.0);
    assert_eq!((print.mode(), print.output.permit.request), (Mode::Act, Request::Run), "no job waits");
}

/// Without a time nothing can be said of any age: no permit, and the printer's dead-man takes over. A person is heard.
#[test]
fn without_a_time_there_is_no_permit_but_an_emergency_stop() {
    for broken in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut print = Print::acting();
        let now = Seconds(broken);
        assert_eq!(print.supervisor.on_event(now, Event::Tick { now }), None);
        assert_eq!(print.supervisor.on_event(now, Event::Hotend { stamp: now, temp: Celsius(210.0) }), None);
        print.run(0.1);
        assert_eq!(print.mode(), Mode::Act, "one missed tick is none");
        print.hotend = false;
        assert!(print.until(Mode::SafeOff) <= 3.1, "and no age was lost by it");
        let output = print.supervisor.on_event(now, Event::Operator(Operator::Estop)).unwrap();
        assert_eq!(output.permit.request, Request::EmergencyStop);
    }
}

/// A supervisor that comes late to every tick has no time for a long start either.
#[test]
fn a_start_ends_however_late_the_ticks_come() {
    let mut print = late(0, |print| print.hotend = false);
    while print.now() < 25.0 {
        print.tick += 20;
        print.step();
    }
    // Nobody sees whether the heaters are off: the mains.
    assert_eq!((print.mode(), print.output.state.cause), (Mode::Estop, Some(Cause::HeatUnseen)));
}

/// S7 on a clock that went ahead and came back within seconds: a stream that has been silent since is missed in time.
#[test]
fn a_clock_that_is_set_back_hides_no_silence() {
    let mut print = Print::acting();
    print.tick += 180_000;
    print.step();
    print.tick -= 180_000;
    print.hotend = false;
    assert!(print.until(Mode::SafeOff) <= 3.3, "{:?}", print.output.state);
}
