mod asking;

use super::*;
use crate::params::RawMarlinParams;
use models::status::{JobPhase, PrinterStatus};
use models::units::Celsius;
use proptest::prelude::*;

const M115: &str = "FIRMWARE_NAME:Marlin 2.1.2 SOURCE_CODE_URL:x";

fn params() -> MarlinParams {
    let raw = RawMarlinParams {
        greeting_s: 2.0,
        temperature_period_s: 1,
        question_period_s: 1.0,
        position_while_printing: false,
        answer_limit_s: 5.0,
        stale_after_s: 2.0,
        state_period_s: 0.25,
        duty_full: 127.0,
        target_max_c: 500.0,
        position_max_m: 2.0,
    };
    raw.try_into().unwrap()
}

/// A brain and the time that it is told.
struct Bench {
    marlin: Marlin,
    now_s: f64,
    outputs: Vec<Output>,
}

impl Bench {
    /// Connected at 100 s.
    fn connected() -> Self {
        let mut bench = Self { marlin: Marlin::new(params()), now_s: 100.0, outputs: Vec::new() };
        bench.event(Event::Connected);
        bench
    }

    /// Connected, started, and with a firmware that has said all of this; the next question waits.
    fn found(capabilities: &[&str]) -> Self {
        let mut bench = Self::connected();
        bench.line("start");
        bench.line(M115);
        for capability in capabilities {
            bench.line(capability);
        }
        bench.line("ok");
        bench
    }

    fn event(&mut self, event: Event<'_>) -> &[Output] {
        self.outputs = self.marlin.on_event(Seconds(self.now_s), event);
        &self.outputs
    }

    fn line(&mut self, line: &str) -> &[Output] {
        self.event(Event::Line(line.as_bytes()))
    }

    /// What is asked in a span of ticks of 0.1 s where each question gets its `ok` at once.
    fn asked(&mut self, span_s: f64) -> Vec<Question> {
        let mut asked = Vec::new();
        let end_s = self.now_s + span_s;
        while self.now_s < end_s {
            while !questions(&self.outputs).is_empty() {
                asked.extend(questions(self.line("ok")));
            }
            self.now_s += 0.1;
            asked.extend(questions(self.event(Event::Tick)));
        }
        asked
    }
}

fn questions(outputs: &[Output]) -> Vec<Question> {
    outputs
        .iter()
        .filter_map(|output| if let Output::Ask(question) = output { Some(*question) } else { None })
        .collect()
}

fn notes(outputs: &[Output]) -> Vec<&Note> {
    outputs
        .iter()
        .filter_map(|output| if let Output::Note(note) = output { Some(note) } else { None })
        .collect()
}

fn state(outputs: &[Output]) -> Option<PrinterStatus> {
    outputs.iter().find_map(|output| if let Output::State(state) = output { Some(**state) } else { None })
}

#[test]
fn what_is_found_is_noted_once_with_what_is_missing() {
    let bench = Bench::found(&["Cap:EMERGENCY_PARSER:1", "Cap:THERMAL_PROTECTION:0"]);
    let [Note::Found(firmware)] = notes(&bench.outputs)[..] else { panic!("{:?}", bench.outputs) };
    assert_eq!(firmware.name(), Some("Marlin 2.1.2"));
    assert!(firmware.has_emergency_parser() && !firmware.reports_temperatures());
    assert_eq!(notes(&bench.outputs)[0].severity(), crate::note::Severity::Error, "protection is off");
    let mut bench = bench;
    assert_eq!(notes(bench.line("ok T:21.3 /0 @:0")), [&Note::SensorMissing(Sensor::Bed)]);
    assert_eq!(notes(bench.line("ok T:21.3 /0 @:0")), Vec::<&Note>::new());
}

/// Reports come between a question and its `ok`, and an `ok` may carry temperatures: content tells, not order.
#[test]
fn answers_in_any_order_mean_the_same() {
    let mut bench = Bench::found(&["Cap:AUTOREPORT_TEMP:1"]);
    bench.line("X:10.00 Y:20.00 Z:0.30 E:0 Count X:1 Y:2 Z:3");
    bench.line("echo:busy: processing");
    let stamp = Seconds(bench.now_s);
    let outputs = bench.line("T:200.0 /210.0 B:50.0 /60.0 @:127 B@:0").to_vec();
    let report = Report { stamp, hotend: Some(Celsius(200.0)), bed: Some(Celsius(50.0)) };
    assert!(outputs.contains(&Output::Temperatures(report)));
    bench.line("ok");
    bench.now_s += 0.5;
    let state = state(bench.event(Event::Tick)).unwrap();
    assert_eq!((state.hotend_target, state.bed_target), (Celsius(210.0), Celsius(60.0)));
    assert!((state.hotend_duty - 1.0).abs() < 1e-12 && state.bed_duty.abs() < 1e-12);
    assert!((state.position_m[1] - 0.02).abs() < 1e-12);
    assert_eq!((state.phase, state.homed, state.layer), (JobPhase::Idle, false, None));
}

#[test]
fn values_that_cannot_be_reach_the_report_but_not_the_state() {
    let mut bench = Bench::found(&[]);
    bench.line("T:20 /200 B:20 /60 @:0 B@:0");
    let outputs = bench.line("T:nan /nan B:9999 /9999 @:500 B@:-1").to_vec();
    let passed = outputs.iter().any(|output| {
        matches!(output, Output::Temperatures(report)
            if report.hotend.unwrap().0.is_nan() && report.bed == Some(Celsius(9999.0)))
    });
    assert!(passed, "{outputs:?}");
    bench.line("X:1 Y:inf Z:3");
    bench.now_s += 0.5;
    let state = state(bench.event(Event::Tick)).unwrap();
    assert_eq!((state.hotend_target, state.bed_target), (Celsius(200.0), Celsius(60.0)), "as they were");
    assert!(state.position_m.iter().all(|value| value.abs() < 1e-12), "as it was");
    let refusals = bench.marlin.refusals();
    assert_eq!((refusals.not_finite, refusals.out_of_range), (2, 3));
}

/// C13: silence is told once, nothing is sent in it, and it ends with the next line.
#[test]
fn silence_ends_the_state_and_is_told_once() {
    let mut bench = Bench::found(&[]);
    bench.line("T:20 /200 B:20 /60");
    bench.now_s += 1.9;
    assert!(state(bench.event(Event::Tick)).is_some());
    bench.now_s += 0.2;
    assert!(matches!(notes(bench.event(Event::Tick))[..], [Note::Stale { .. }]));
    assert_eq!(bench.marlin.link(), Link::Silent);
    for _ in 0..20 {
        bench.now_s += 1.0;
        let outputs = bench.event(Event::Tick);
        assert!(state(outputs).is_none() && notes(outputs).is_empty());
    }
    assert_eq!(notes(bench.line("ok")), [&Note::Fresh]);
    assert!(state(&bench.outputs).is_some());
}

#[test]
fn a_device_that_never_speaks_is_told_once() {
    let mut bench = Bench::connected();
    let mut told = 0;
    for _ in 0..200 {
        bench.now_s += 0.1;
        told += notes(bench.event(Event::Tick)).len();
    }
    assert_eq!((told, bench.marlin.link()), (1, Link::Silent));
}

#[test]
fn a_loss_is_told_once_and_a_new_connection_asks_anew() {
    let mut bench = Bench { marlin: Marlin::new(params()), now_s: 1.0, outputs: Vec::new() };
    assert_eq!(notes(bench.event(Event::Lost("no such file"))).len(), 1);
    assert_eq!(notes(bench.event(Event::Lost("no such file"))).len(), 0);
    let mut bench = Bench::found(&["Cap:AUTOREPORT_TEMP:1"]);
    bench.line("T:20 /200 B:20 /60");
    bench.event(Event::Lost("unplugged"));
    assert_eq!(bench.marlin.link(), Link::Down);
    bench.now_s += 1.0;
    assert!(bench.event(Event::Tick).is_empty(), "nothing is sent or asked");
    bench.event(Event::Connected);
    assert_eq!(questions(bench.line("start")), [Question::Firmware]);
    assert!(state(&bench.outputs).is_none(), "set-points of the time before do not count");
}

/// C14: halted by itself or restarted in a job, the job has failed; nothing is sent again.
#[test]
fn a_halt_and_a_restart_fail_the_job() {
    let mut bench = Bench::found(&["Cap:SDCARD:1"]);
    bench.line("T:20 /200 B:20 /60");
    bench.line("SD printing byte 5/100");
    bench.now_s += 1.0;
    bench.line("Error:Thermal Runaway, system stopped! Heater_ID: 0");
    let told = notes(&bench.outputs);
    assert!(
        matches!(told[..], [Note::Halted { .. }, Note::Job { after: Some(JobPhase::Failed), .. }]),
        "{told:?}"
    );
    assert_eq!(state(&bench.outputs).unwrap().phase, JobPhase::Failed);
    assert_eq!(bench.marlin.link(), Link::Halted);
    assert_eq!(notes(bench.line("Error:Printer halted. kill() called!")), Vec::<&Note>::new());
    bench.now_s += 60.0;
    assert!(bench.event(Event::Tick).is_empty());
    assert_eq!(notes(bench.line("start")), [&Note::Started]);

    let mut bench = Bench::found(&["Cap:SDCARD:1"]);
    bench.line("SD printing byte 5/100");
    bench.event(Event::Lost("unplugged"));
    bench.event(Event::Connected);
    bench.line("start");
    assert_eq!(bench.marlin.job().phase(), Some(JobPhase::Failed), "opening the line restarted the board");
}

#[test]
fn a_firmware_that_repeats_itself_does_not_fill_the_log() {
    let mut bench = Bench::found(&[]);
    let mut told = 0;
    for _ in 0..1000 {
        bench.now_s += 0.001;
        told += notes(bench.line("Resend: 5")).len();
        told += notes(bench.line("Error:checksum mismatch, Last Line: 4")).len();
    }
    assert_eq!(told, 2, "one of each in a second");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Whatever a device says: one question at a time, states that the wire takes, every line bounded in its effect.
    #[test]
    fn no_device_breaks_the_brain(
        lines in proptest::collection::vec(
            ("(ok |echo:|//action:|Error:|Cap:|T:|B:|@:|X:|Y:|Z:|start|wait|SD printing byte |FIRMWARE_NAME:|[-0-9./naife]{0,6}| ){0,8}",
             0.0..3.0f64),
            0..30)
    ) {
        let mut bench = Bench::connected();
        for (line, pause_s) in lines {
            bench.now_s += pause_s;
            let outputs = bench.line(&line);
            prop_assert!(questions(outputs).len() <= 1);
            if let Some(state) = state(outputs) {
                prop_assert!((0.0..=1.0).contains(&state.hotend_duty) && (0.0..=1.0).contains(&state.bed_duty));
                prop_assert!((0.0..=500.0).contains(&state.hotend_target.0));
                prop_assert!(state.position_m.iter().all(|value| value.abs() <= 2.0));
            }
        }
    }

    /// Nothing that the bridge sends has another first word.
    #[test]
    fn only_questions_are_sent(period_s: u8) {
        for question in [
            Question::Firmware, Question::Reports(period_s), Question::Temperatures, Question::Card, Question::Position,
        ] {
            let line = question.line();
            let word = line.split(' ').next().unwrap();
            prop_assert!(["M115", "M155", "M105", "M27", "M114"].contains(&word));
            prop_assert!(!line.contains(['\n', '\r']));
        }
    }
}
