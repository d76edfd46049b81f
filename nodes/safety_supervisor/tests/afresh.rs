//! What begins anew, and what must not: latches after a restart, filters after a resume, times of a clock that was set back.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::params;
use common::print::{Print, SOUND};
use models::command::{Command, Mode, Request, Trims};
use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use safety_supervisor::{Cause, Defect, Event, Latch, Operator, Stream, Supervisor, VisionReport, What};

/// A supervisor that was started again and remembers a latch.
fn restarted(estop: bool, cause: Cause) -> Print {
    Print::with(Supervisor::new(params(), 8, Some(Latch { estop, cause })))
}

const ACKNOWLEDGED: What = What::Granted(Operator::Acknowledge);
const REFUSED: What = What::Denied(Operator::Acknowledge);

/// P13: the contact is still open, but nobody has said so yet.
#[test]
fn no_latch_ends_before_the_printer_has_told_its_state() {
    let mut print = restarted(true, Cause::StopInput);
    assert_eq!(print.ask(Operator::Acknowledge), REFUSED, "before the first reading");
    print.printer = false;
    // 10 s of start-up are over.
    print.run(11.0);
    assert_eq!(print.ask(Operator::Acknowledge), REFUSED, "no state");
    (print.printer, print.report.stop_input) = (true, Some(true));
    print.run(1.0);
    assert_eq!(print.ask(Operator::Acknowledge), REFUSED, "still open");
    print.report.stop_input = Some(false);
    print.run(1.0);
    assert_eq!(print.ask(Operator::Acknowledge), ACKNOWLEDGED);
    print.printer = false;
    print.ask(Operator::Estop);
    print.run(1.0);
    assert_eq!(print.ask(Operator::Acknowledge), REFUSED, "the last state is old");
}

/// S7: a stream that is expected, and missed only in 3 s, has not been heard.
#[test]
fn no_latch_ends_before_the_hot_end_was_heard() {
    let mut print = restarted(false, Cause::HotendRange);
    print.hotend = false;
    print.run(10.5);
    assert_eq!(print.ask(Operator::Acknowledge), REFUSED);
    assert_eq!((print.mode(), print.output.permit.request), (Mode::SafeOff, Request::HeatersOff));
}

#[test]
fn a_latch_of_the_bed_ends_with_a_bed_that_reads_well() {
    for cause in
        Cause::ALL.iter().copied().filter(|cause| cause.id() == "P12" || cause.text().starts_with("bed"))
    {
        let mut print = restarted(false, cause);
        print.run(1.0);
        assert_eq!(print.ask(Operator::Acknowledge), REFUSED, "{cause:?}: never heard");
        // A loose plug shows in ten readings; the balance of the bed is known after ten and five of its time constants.
        let balance = if cause.is_of_balance() { REFUSED } else { ACKNOWLEDGED };
        for (temp_c, readings, answer) in
            [(-14.0, 1, REFUSED), (24.0, 9, REFUSED), (24.0, 1, balance), (24.0, 120, ACKNOWLEDGED)]
        {
            for reading in 0..readings {
                print.run(0.1);
                let temp = Celsius(temp_c + 0.01 * f64::from(reading % 7));
                print.event(Event::Bed { stamp: Seconds(print.now()), temp });
            }
            let asked = print.ask(Operator::Acknowledge);
            assert_eq!(asked, answer, "{cause:?} at {temp_c} degC, {readings} readings");
            if asked == ACKNOWLEDGED {
                break;
            }
        }
    }
    for (span_s, answer) in [(1.0, REFUSED), (10.0, ACKNOWLEDGED)] {
        let mut print = restarted(true, Cause::HeaterStuckOn);
        print.run(span_s);
        assert_eq!(print.ask(Operator::Acknowledge), answer, "P1: not judged yet, hence not gone");
    }
    let mut print = restarted(false, Cause::HotendRange);
    print.run(1.0);
    assert_eq!(print.ask(Operator::Acknowledge), ACKNOWLEDGED, "a printer without a heated bed");
}

const RESUMED: What = What::Granted(Operator::Resume);

const LOOSE: VisionReport = VisionReport { defect: Some(Defect::Spaghetti), confirmed: true, ..SOUND };

/// What the camera saw of a hand at the halted printer is no reason to pause it again.
#[test]
fn a_resume_after_an_acknowledge_forgets_what_was_seen_before_it() {
    let mut print = Print::acting();
    print.ask(Operator::Stop);
    print.report.phase = JobPhase::Paused;
    print.run(0.1);
    assert_eq!(print.ask(Operator::Acknowledge), ACKNOWLEDGED);
    print.watch(VisionReport { confidence: 0.95, ..SOUND }, 3.0);
    assert_eq!(print.output.permit.request, Request::Pause);
    assert_eq!(print.ask(Operator::Resume), RESUMED);
    print.report.phase = JobPhase::Printing;
    print.watch(SOUND, 3.0);
    assert_eq!((print.mode(), print.output.permit.request), (Mode::Act, Request::Run));
}

/// A print that was paused for what the camera sees in this layer, looked at and resumed.
fn looked_at(layer: Option<u32>) -> Print {
    let mut print = Print::acting();
    print.report.layer = layer;
    print.watch(LOOSE, 0.6);
    assert_eq!(print.output.state.cause, Some(Cause::Spaghetti));
    print.report.phase = JobPhase::Paused;
    print.watch(LOOSE, 1.0);
    assert_eq!(print.ask(Operator::Resume), RESUMED);
    print.report.phase = JobPhase::Printing;
    print
}

#[test]
fn the_camera_pauses_once_for_what_a_person_has_looked_at_until_two_layers_on() {
    let mut print = looked_at(Some(5));
    for layer in [5, 6] {
        print.report.layer = Some(layer);
        print.watch(LOOSE, 10.0);
        assert_eq!(
            (print.mode(), print.output.permit.request),
            (Mode::Degraded, Request::Run),
            "layer {layer}"
        );
    }
    print.report.layer = Some(7);
    print.watch(LOOSE, 0.6);
    assert_eq!((print.mode(), print.output.state.cause), (Mode::Paused, Some(Cause::Spaghetti)));
}

#[test]
fn what_a_person_has_not_looked_at_pauses_all_the_same() {
    let thin = VisionReport { defect: Some(Defect::Under), ..LOOSE };
    let mut print = looked_at(Some(5));
    print.watch(thin, 6.0);
    assert_eq!((print.mode(), print.output.state.cause), (Mode::Paused, Some(Cause::UnderExtrusion)));
    let mut print = looked_at(Some(5));
    print.slip = 1.0;
    assert!(print.until(Mode::Paused) <= 4.5);
    assert_eq!(print.output.state.cause, Some(Cause::FilamentSlip));
    let told = print.output.state.evidence.map(|evidence| evidence.to_string());
    assert_eq!(told.as_deref(), Some("100 % slip, limit 42 %"));
    let mut print = looked_at(Some(5));
    print.report.phase = JobPhase::Done;
    print.watch(SOUND, 1.0);
    (print.report.phase, print.report.layer) = (JobPhase::Printing, Some(0));
    print.watch(LOOSE, 0.6);
    assert_eq!(print.mode(), Mode::Paused, "another job");
}

/// An hour back, 50 ticks a second.
fn set_back(print: &mut Print) {
    print.tick -= 180_000;
    print.step();
}

fn acting_for_an_hour() -> Print {
    let mut print = Print::acting();
    print.tick += 180_000;
    print.run(10.0);
    assert_eq!(print.mode(), Mode::Act);
    print
}

#[test]
fn after_a_clock_was_set_back_what_began_before_it_is_answered_in_time() {
    let mut print = acting_for_an_hour();
    print.report.filament_present = Some(false);
    print.run(0.1);
    set_back(&mut print);
    assert!(print.until(Mode::Paused) <= 1.0, "run-out: {:?}", print.output.state);

    let mut print = acting_for_an_hour();
    print.report.phase = JobPhase::Paused;
    print.run(0.5);
    set_back(&mut print);
    assert!(print.until(Mode::Paused) <= 1.2, "paused by itself");

    let mut print = acting_for_an_hour();
    let thin = VisionReport { defect: Some(Defect::Under), ..LOOSE };
    print.watch(thin, 2.0);
    set_back(&mut print);
    print.watch(thin, 6.0);
    assert_eq!(print.mode(), Mode::Paused, "a thin road");

    let mut print = acting_for_an_hour();
    (print.report.fan, print.report.part_fan_speed_1_s) = (1.0, Some(0.0));
    print.run(1.0);
    set_back(&mut print);
    assert!(print.until(Mode::Degraded) <= 4.2, "the part fan");
}

#[test]
fn after_a_clock_was_set_back_nothing_is_held_against_anybody_for_an_hour() {
    let stranger = Command { session: 4, sequence: 1, validity: Seconds(1.0), trims: Trims::NEUTRAL };
    let mut print = acting_for_an_hour();
    (0..3).for_each(|_| print.event(Event::Refused { stream: Stream::Bed }));
    print.event(Event::Command(stranger));
    print.run(0.5);
    assert_eq!(print.mode(), Mode::Degraded);
    set_back(&mut print);
    assert!(print.until(Mode::Act) <= 5.0, "{:?}", print.output.state);

    let mut print = acting_for_an_hour();
    print.ask(Operator::Pause);
    print.report.phase = JobPhase::Paused;
    print.run(30.0);
    set_back(&mut print);
    print.run(29.0);
    assert_eq!(print.output.permit.request, Request::Pause);
    print.run(2.0);
    assert_eq!(print.output.permit.request, Request::Standby, "60 s after it began");

    let mut print = acting_for_an_hour();
    print.tick -= 180_000;
    print.ask(Operator::Pause);
    print.report.phase = JobPhase::Paused;
    print.run(1.0);
    assert_eq!(
        (print.mode(), print.output.permit.request),
        (Mode::Paused, Request::Pause),
        "asked for just now"
    );
}

/// P8: what is dated ahead would leave out all that comes before it.
#[test]
fn a_batch_that_ends_ahead_of_the_clock_hides_no_knock() {
    let still = vec![[0.0, 0.0, 9.81]; 20];
    for (first_s, period_s) in [(0.0, 1.0), (0.0, 1e300), (0.3, 1e-3), (0.0, f64::INFINITY)] {
        let mut print = Print::acting();
        let now_s = print.now();
        let first = Seconds(now_s + first_s);
        print.event(Event::Imu { first, period: Seconds(period_s), samples: still.clone() });
        for shock_m_s2 in [0.0, 40.0] {
            print.step();
            let (first, samples) = (Seconds(print.now() - 0.02), vec![[shock_m_s2, 0.0, 9.81]; 20]);
            print.event(Event::Imu { first, period: Seconds(1e-3), samples });
        }
        print.step();
        let state = &print.output.state;
        assert_eq!((state.impulses, state.refused_values), (1, 1), "{first_s} s ahead, {period_s} s apart");
    }
}

/// C8: who floods the topic does not flood the log as well.
#[test]
fn a_flood_of_refused_commands_is_told_once_a_tick_and_counted_in_full() {
    let mut print = Print::acting();
    let command = Command { session: 4, sequence: 1, validity: Seconds(1.0), trims: Trims::NEUTRAL };
    for sequence in 0..1000 {
        print.event(Event::Command(Command { sequence, ..command }));
    }
    print.step();
    let refused = |what: &What| matches!(what, What::CommandRefused(_));
    assert_eq!(print.output.events.iter().filter(|decision| refused(&decision.what)).count(), 1);
    assert_eq!(print.output.state.refused_commands, 1000);
}

/// What a person reads: the number that the cause rests on, as it was when it was found.
#[test]
fn a_cause_comes_with_the_number_it_rests_on() {
    let mut print = Print::acting();
    print.temp_c = 450.0;
    print.until(Mode::SafeOff);
    let told = print.output.events.iter().find_map(|decision| decision.cause);
    let (cause, evidence) = told.unwrap();
    let text = evidence.unwrap().to_string();
    assert!(cause == Cause::HotendRange && text.starts_with("450."), "{text}");
    assert!(text.ends_with(" degC, limit 285.0 degC"), "{text}");
    print.temp_c = 25.0;
    print.run(3.0);
    assert_eq!(print.output.state.evidence, evidence, "not what came of it later");

    let mut print = Print::acting();
    print.hotend = false;
    for (mode, at_least) in [(Mode::Degraded, 0.3), (Mode::Paused, 1.5), (Mode::SafeOff, 3.0)] {
        print.until(mode);
        let age = print.output.state.evidence.unwrap();
        assert!((at_least..at_least + 0.1).contains(&age.value) && age.unit == "s", "{age}");
        assert_eq!(age.limit, Some(at_least), "{age}");
    }
    let mut print = Print::acting();
    print.slip = 0.5;
    print.until(Mode::Paused);
    assert!(print.output.state.evidence.unwrap().to_string().ends_with(" % slip, limit 42 %"));
    print.ask(Operator::Stop);
    assert_eq!(print.output.state.evidence, None, "a person needs none");
}
