//! Modes, gate, permits and the checks that need no heater.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::params;
use common::print::Print;
use models::command::{Command, Mode, Request, Trims};
use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use safety_supervisor::{Cause, Event, Operator, Stream, Supervisor, What};

#[test]
fn observe_is_the_default_and_sends_nothing() {
    let mut print = Print::with(Supervisor::new(params(), 7, None));
    assert_eq!(print.mode(), Mode::Init);
    print.run(5.0);
    assert_eq!((print.mode(), print.output.permit.trims), (Mode::Observe, Trims::NEUTRAL));
    assert_eq!(print.ask(Operator::SetMode(Mode::Act)), What::Granted(Operator::SetMode(Mode::Act)));
    print.run(2.0);
    assert!((print.output.permit.trims.flow - 1.05).abs() < 1e-12);
    let refused = Operator::SetMode(Mode::Estop);
    assert_eq!(print.ask(refused), What::Denied(refused));
}

/// C1: with a part of the control path away the printer is at the slicer's values within 2.5 s, and whole again
/// within 5 s after it is back.
#[test]
fn a_part_that_is_away_degrades_and_heals() {
    let away: [fn(&mut Print, bool); 3] =
        [|print, on| print.controller = on, |print, on| print.estimator = on, |print, on| print.encoder = on];
    for switch in away {
        let mut print = Print::acting();
        switch(&mut print, false);
        let detected_s = print.until(Mode::Degraded);
        assert!(detected_s <= 1.0, "{detected_s}");
        print.run(2.5 - detected_s);
        assert_eq!((print.output.permit.trims, print.output.permit.request), (Trims::NEUTRAL, Request::Run));
        switch(&mut print, true);
        assert!(print.until(Mode::Act) <= 5.0);
    }
}

/// The estimator is away for 0.5 s and corrections go back within 1.25 s when the encoder falls silent too: its loop is
/// open at once, and it is told once.
#[test]
fn an_encoder_that_falls_silent_beside_another_cause_is_told_and_opens_its_loop() {
    let mut print = Print::acting();
    print.wish = Trims { flow: 1.05, slip: Some(0.09), ..Trims::NEUTRAL };
    print.run(1.0);
    assert_eq!(print.output.permit.trims.slip, Some(0.09));
    print.estimator = false;
    print.run(0.2);
    print.encoder = false;
    print.until(Mode::Degraded);
    assert_eq!(print.output.state.cause, Some(Cause::StaleEstimate));
    assert!(print.output.permit.trims.slip.is_some(), "the encoder has been silent for 0.3 s");
    let mut told = Vec::new();
    let mut opened_s = None;
    for tick in 0..100 {
        print.step();
        if print.output.permit.trims.slip.is_none() {
            opened_s = opened_s.or(Some(0.02 * f64::from(tick)));
        }
        told.extend(print.output.events.iter().filter(|decision| decision.what == What::AlsoRaised).copied());
    }
    assert!(opened_s.is_some_and(|opened_s| opened_s <= 0.14), "{opened_s:?}");
    let of_encoder =
        told.iter().filter(|decision| decision.cause.is_some_and(|(cause, _)| cause == Cause::StaleEncoder));
    assert_eq!(of_encoder.count(), 1, "{told:?}");
}

/// S7: 300 ms degraded, 1.5 s paused, 3 s heaters off; whole again after acknowledge, the job waits for a resume.
#[test]
fn s7_a_silent_thermistor_degrades_pauses_and_ends_in_safe_off() {
    let mut print = Print::acting();
    print.hotend = false;
    // one sample period of 0.1 s and a tick beyond the age
    for (mode, limit_s) in [(Mode::Degraded, 0.32), (Mode::Paused, 1.52), (Mode::SafeOff, 3.02)] {
        let start_s = print.now();
        print.until(mode);
        assert!(print.now() - 5.0 <= limit_s + 0.02, "{mode:?} {start_s} {}", print.now());
    }
    print.report.phase = JobPhase::Paused;
    assert_eq!(print.ask(Operator::Acknowledge), What::Denied(Operator::Acknowledge));
    print.hotend = true;
    print.run(1.0);
    assert_eq!((print.mode(), print.output.permit.request), (Mode::SafeOff, Request::HeatersOff));
    assert_eq!(print.ask(Operator::Acknowledge), What::Granted(Operator::Acknowledge));
    print.run(3.0);
    assert_eq!((print.mode(), print.output.permit.request), (Mode::Act, Request::Pause));
    assert_eq!(print.ask(Operator::Resume), What::Granted(Operator::Resume));
    assert_eq!(print.output.permit.request, Request::Run);
}

#[test]
fn a_supervisor_that_stood_still_blames_nobody() {
    let mut print = Print::acting();
    print.tick += 250;
    print.step();
    assert!(print.output.events.iter().any(|decision| decision.what == What::StoodStill));
    assert_eq!(print.output.permit.trims, Trims::NEUTRAL);
    print.run(3.0);
    assert_eq!(print.mode(), Mode::Act);
}

/// Who stands still again and again hears nothing in time: that is no excuse any more.
#[test]
fn a_supervisor_that_keeps_standing_still_degrades() {
    let mut print = Print::acting();
    let mut degraded = false;
    for _ in 0..4 {
        print.tick += 50;
        print.step();
        degraded |= print.mode() == Mode::Degraded;
    }
    assert!(degraded, "1 s of silence before every tick");
}

/// S1: 0.5 s, and no trip on a single spike.
#[test]
fn s1_open_and_short_circuits_switch_off() {
    for reading_c in [-14.0, 450.0] {
        let mut print = Print::acting();
        print.temp_c = reading_c;
        print.run(0.1);
        print.temp_c = 210.0;
        print.run(2.0);
        assert_eq!(print.mode(), Mode::Act, "spike");
        print.temp_c = reading_c;
        assert!(print.until(Mode::SafeOff) <= 0.5);
        assert_eq!(print.output.state.cause, Some(Cause::HotendRange));
        print.run(1.0);
        assert_eq!(print.ask(Operator::Acknowledge), What::Denied(Operator::Acknowledge));
    }
}

/// S5: three refused values in a second.
#[test]
fn s5_refused_values_degrade() {
    let mut print = Print::acting();
    for _ in 0..2 {
        print.event(Event::Refused { stream: Stream::Printer });
    }
    print.run(0.5);
    assert_eq!(print.mode(), Mode::Act);
    print.event(Event::Hotend { stamp: Seconds(0.0), temp: Celsius(f64::NAN) });
    print.step();
    assert_eq!((print.mode(), print.output.state.cause), (Mode::Degraded, Some(Cause::BadValues)));
    print.run(4.0);
    assert_eq!(print.mode(), Mode::Act);
}

/// K6: clamped at once; three in a second degrade.
#[test]
fn k6_commands_out_of_the_envelope_are_clamped_and_degrade() {
    let mut print = Print::acting();
    print.wish = Trims { flow: 3.0, ..Trims::NEUTRAL };
    let detected_s = print.until(Mode::Degraded);
    // three commands of 0.24 s and the first one's wait
    assert!(detected_s <= 1.0, "{detected_s}");
    assert!(print.output.permit.trims.flow <= 1.25);
    assert_eq!(print.output.state.clamped_commands, 3);
}

/// C8: a second publisher, told from a successor by the first one's next command.
#[test]
fn c8_a_second_publisher_is_refused_and_degrades() {
    let mut print = Print::acting();
    let trims = Trims { flow: 0.8, ..Trims::NEUTRAL };
    print.event(Event::Command(Command { session: 4, sequence: 1, validity: Seconds(1.0), trims }));
    let detected_s = print.until(Mode::Degraded);
    assert!(detected_s <= 0.5, "{detected_s}");
    assert_eq!(print.output.state.cause, Some(Cause::SecondPublisher));
    assert!(print.output.permit.trims.flow > 1.0);
}

/// C1: a controller that was started again is no second publisher: its predecessor is silent.
#[test]
fn c1_a_restarted_controller_is_no_second_publisher() {
    let mut print = Print::acting();
    print.controller = false;
    for sequence in 1..=20 {
        print.run(0.24);
        let trims = print.wish;
        print.event(Event::Command(Command { session: 4, sequence, validity: Seconds(1.0), trims }));
        assert_ne!(print.output.state.cause, Some(Cause::SecondPublisher));
    }
    assert_eq!(print.mode(), Mode::Act);
}

/// P6: 7 mm and 1 s at 2 mm/s; 30 % slip is for the controller.
#[test]
fn p6_slip_pauses_once_and_small_slip_does_not() {
    for (slip, way_m) in [(0.5, 7e-3), (1.0, 7e-3)] {
        let mut print = Print::acting();
        print.slip = slip;
        let time_s = print.until(Mode::Paused);
        assert!(time_s <= way_m / 2e-3 + 1.0, "{slip}: {time_s}");
        assert_eq!(print.output.state.cause, Some(Cause::FilamentSlip));
    }
    let mut print = Print::acting();
    print.slip = 0.3;
    print.run(20.0);
    assert_eq!(print.mode(), Mode::Act);
}

/// P7: 1 s after the switch; the resume wants filament, heat and a homed printer, and heats up again after standby.
#[test]
fn p7_run_out_pauses_and_resumes_only_when_ready() {
    let mut print = Print::acting();
    print.report.filament_present = Some(false);
    assert!(print.until(Mode::Paused) <= 1.0);
    print.report.phase = JobPhase::Paused;
    print.run(1.0);
    assert_eq!(print.output.permit.request, Request::Pause);
    assert_eq!(print.ask(Operator::Resume), What::Denied(Operator::Resume));
    print.report.filament_present = Some(true);
    print.run(61.0);
    assert_eq!(print.output.permit.request, Request::Standby);
    print.report.homed = false;
    print.run(1.0);
    assert_eq!(print.ask(Operator::Resume), What::Denied(Operator::Resume));
    print.report.homed = true;
    print.report.hotend_sliced_target = Celsius(216.0);
    print.run(0.1);
    assert_eq!(print.ask(Operator::Resume), What::Granted(Operator::Resume));
    print.run(1.0);
    assert_eq!(print.output.permit.request, Request::Pause, "210 degC is more than 5 K below 216 degC");
    print.report.hotend_sliced_target = Celsius(212.0);
    print.run(0.1);
    assert_eq!((print.mode(), print.output.permit.request), (Mode::Act, Request::Run));
}

/// P13: the answer comes with the event itself.
#[test]
fn p13_an_emergency_stop_is_answered_at_once_and_stays() {
    let mut print = Print::acting();
    assert_eq!(print.ask(Operator::Estop), What::Granted(Operator::Estop));
    assert_eq!((print.mode(), print.output.permit.request), (Mode::Estop, Request::EmergencyStop));
    print.run(5.0);
    assert_eq!((print.mode(), print.output.permit.trims), (Mode::Estop, Trims::NEUTRAL));
    let latch = print.supervisor.latch();
    let mut restarted = Print::with(Supervisor::new(params(), 8, latch));
    assert_eq!(restarted.output.permit.request, Request::EmergencyStop, "from the first permit on");
    restarted.run(5.0);
    assert_eq!(restarted.mode(), Mode::Estop);
    restarted.report.phase = JobPhase::Failed;
    restarted.run(0.1);
    assert_eq!(restarted.ask(Operator::Acknowledge), What::Granted(Operator::Acknowledge));
    // the printer's own report of the given-up job is the last cause
    restarted.run(2.1);
    assert_eq!((restarted.mode(), restarted.output.permit.request), (Mode::Observe, Request::Run));
}

#[test]
fn a_pause_that_the_printer_made_itself_is_taken_over() {
    let mut print = Print::acting();
    print.report.phase = JobPhase::Paused;
    // A second, after which it is no pause of a moment.
    let took_s = print.until(Mode::Paused);
    assert!((0.98..=1.1).contains(&took_s), "{took_s}");
    let state = &print.output.state;
    assert_eq!((state.cause, print.output.permit.request), (Some(Cause::PrinterPaused), Request::Pause));
}

#[test]
fn a_pause_of_a_moment_that_the_printer_made_itself_is_none() {
    let mut print = Print::acting();
    for _ in 0..5 {
        for (phase, span_s) in [(JobPhase::Paused, 0.9), (JobPhase::Printing, 0.2)] {
            print.report.phase = phase;
            print.run(span_s);
            assert_eq!((print.mode(), print.output.permit.request), (Mode::Act, Request::Run));
        }
    }
}
