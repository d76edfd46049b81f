//! A machine without a hot end: which streams must come, limits of the wire, and nothing weakened for the others.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::print::Print;
use common::{params, params_with, report};
use models::command::{Mode, Request, Trims};
use models::units::{Celsius, Seconds};
use safety_supervisor::params::Streams;
use safety_supervisor::{Cause, Operator, Params, PrinterReport, Stream, Supervisor, What};
use serde_json::Value;

/// Puts a file over another as the nodes read them: the later one wins, value by value.
fn put_over(under: &mut Value, over: Value) {
    match (under, over) {
        (Value::Object(under), Value::Object(over)) => {
            for (name, value) in over {
                put_over(under.entry(name).or_insert(Value::Null), value);
            }
        }
        (under, over) => *under = over,
    }
}

/// The files of a wire machine, as `fdm wire up` gives them.
fn wire(start_mode: &str) -> Params {
    let base = include_str!("../../../config/safety_supervisor.param.yaml");
    let over = include_str!("../../../config/wire/safety_supervisor.param.yaml");
    let mut file: Value = serde_saphyr::from_str(base).unwrap();
    put_over(&mut file, serde_saphyr::from_str(over).unwrap());
    let mut parameters = file["/**"]["ros__parameters"].take();
    parameters["start_mode"] = start_mode.into();
    serde_json::from_value(parameters).unwrap()
}

/// A machine at work that has a controller and nothing else.
fn machine(start_mode: &str) -> Print {
    let mut print = Print::with(Supervisor::new(wire(start_mode), 7, None));
    (print.hotend, print.encoder, print.estimator) = (false, false, false);
    print.report = PrinterReport { filament_present: None, ..report(0.0) };
    print
}

#[test]
fn a_machine_without_a_hot_end_starts_at_once_and_acts() {
    let mut print = machine("act");
    print.run(0.1);
    assert_eq!(print.mode(), Mode::Act);
    print.wish = Trims { flow: 1.6, speed: 0.8, ..Trims::NEUTRAL };
    print.run(30.0);
    assert_eq!((print.mode(), print.output.permit.trims), (Mode::Act, print.wish));
}

/// C1 for the wire: 0.75 s of silence and a ramp of 1.25 s.
#[test]
fn without_its_controller_it_runs_at_the_planned_speeds() {
    let mut print = machine("act");
    print.run(5.0);
    print.controller = false;
    assert!(print.until(Mode::Degraded) <= 1.02);
    print.run(1.5);
    assert_eq!((print.output.permit.trims, print.output.permit.request), (Trims::NEUTRAL, Request::Run));
    print.controller = true;
    assert!(print.until(Mode::Act) <= 5.0);
}

#[test]
fn sections_outside_of_the_law_are_clamped_counted_and_degrade() {
    for (flow, kept) in [(2.5, 1.8), (0.1, 0.2)] {
        let mut print = machine("act");
        print.run(2.0);
        print.wish = Trims { flow, ..Trims::NEUTRAL };
        let mut reached = 1.0_f64;
        while print.mode() == Mode::Act {
            print.step();
            let now = print.output.permit.trims.flow;
            // The slew's last step may round.
            assert!((0.2 - 1e-12..=1.8 + 1e-12).contains(&now), "{now}");
            reached = if flow > 1.0 { reached.max(now) } else { reached.min(now) };
        }
        assert_eq!((print.mode(), print.output.state.cause), (Mode::Degraded, Some(Cause::Envelope)));
        assert!((reached - kept).abs() < 1e-12 && print.output.state.clamped_commands >= 3, "{reached}");
        let told = print.output.state.evidence.map(|evidence| evidence.to_string());
        assert_eq!(told.as_deref(), Some("3 commands since the start"));
    }
}

/// There is nothing to measure before a resume or an acknowledge.
#[test]
fn pause_and_trip_end_as_a_person_says() {
    let mut print = machine("act");
    print.run(2.0);
    print.ask(Operator::Pause);
    print.run(1.0);
    assert_eq!(print.mode(), Mode::Paused);
    assert_eq!(print.ask(Operator::Resume), What::Granted(Operator::Resume));
    print.ask(Operator::Stop);
    print.run(1.0);
    assert_eq!((print.mode(), print.output.permit.request), (Mode::SafeOff, Request::HeatersOff));
    assert_eq!(print.ask(Operator::Acknowledge), What::Granted(Operator::Acknowledge));
}

/// The wire machine's files on a printer that heats: its temperature is missed all the same.
#[test]
fn what_heats_is_watched_whatever_is_required() {
    for report in [
        PrinterReport { hotend_duty: 0.1, ..report(0.0) },
        PrinterReport { hotend_target: Celsius(210.0), ..report(0.0) },
        PrinterReport { hotend_sliced_target: Celsius(210.0), ..report(0.0) },
    ] {
        let mut print = machine("observe");
        print.run(1.0);
        print.report = report;
        // 3 s of silence and a tick or two
        assert!(print.until(Mode::SafeOff) <= 3.06, "{:?}", print.output.state.cause);
        assert_eq!(print.output.state.cause, Some(Cause::StaleHotend));
        assert_eq!(print.ask(Operator::Acknowledge), What::Denied(Operator::Acknowledge));
    }
}

/// A stream that came once and stopped is missed even where it need not come.
#[test]
fn a_hot_end_that_was_heard_is_missed() {
    let mut print = machine("observe");
    print.hotend = true;
    print.run(1.0);
    print.hotend = false;
    assert!(print.until(Mode::SafeOff) <= 3.12);
}

/// Nothing weakened: the shipped file says what was built in, and a file without the lists means the same.
#[test]
fn a_printer_that_extrudes_requires_what_it_did() {
    let required =
        (Streams::of(&[Stream::Hotend, Stream::Printer]), Streams::of(&[Stream::Estimate, Stream::Encoder]));
    let silent = params_with("    required: [hotend, printer]", "    #");
    let silent_to_act = params_with("    required_to_act: [estimate, encoder]", "    #");
    for params in [params(), silent, silent_to_act] {
        assert_eq!((params.required, params.required_to_act), required);
    }
    // Without a hot end it waits the whole time for it, then misses it.
    let mut print = Print::with(Supervisor::new(params(), 7, None));
    print.hotend = false;
    print.run(9.9);
    assert_eq!(print.mode(), Mode::Init);
    assert!(print.until(Mode::SafeOff) <= 3.3);
    assert!(Seconds(print.now()).0 > 12.9);
}
