//! The bridge's brain behind a serial line, with a stand-in of Marlin at the other end. Real time passes: a line has no
//! other; nothing is asserted of it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod stand_in;

use models::status::JobPhase;
use models::units::{Celsius, Seconds};
use printer_bridge::line::LINE_MAX;
use printer_bridge::params::{MarlinParams, RawMarlinParams};
use printer_bridge::{Event, Marlin, Note, Output};
use runtime::serial::{PortEvent, SerialReader};
use stand_in::StandIn;
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Longest wait for anything: only ends a test that hangs.
const PATIENCE: Duration = Duration::from_secs(20);

fn params() -> MarlinParams {
    let raw = RawMarlinParams {
        greeting_s: 0.0,
        temperature_period_s: 1,
        question_period_s: 0.2,
        position_while_printing: false,
        answer_limit_s: 5.0,
        stale_after_s: 5.0,
        state_period_s: 0.05,
        duty_full: 127.0,
        target_max_c: 500.0,
        position_max_m: 2.0,
    };
    raw.try_into().unwrap()
}

/// What the node does, without ROS.
struct Bridge {
    marlin: Marlin,
    reader: SerialReader,
    events: Receiver<PortEvent>,
    begin: Instant,
}

impl Bridge {
    fn open(path: &Path) -> Self {
        let text = format!("{{path: {path:?}, baud: 115200, retry_min_s: 0.02, retry_max_s: 0.1}}");
        let (sink, events) = channel();
        let serial = serde_saphyr::from_str(&text).unwrap();
        let reader = SerialReader::spawn(serial, LINE_MAX, move |event| drop(sink.send(event))).unwrap();
        Self { marlin: Marlin::new(params()), reader, events, begin: Instant::now() }
    }

    /// Passes events on until an output is as wished.
    fn until(&mut self, what: &str, wished: impl Fn(&Output) -> bool) {
        let begin = Instant::now();
        loop {
            assert!(begin.elapsed() < PATIENCE, "no {what}");
            let event = self.events.recv_timeout(Duration::from_millis(20)).ok();
            let event = match &event {
                Some(PortEvent::Connected) => Event::Connected,
                Some(PortEvent::Lost { reason, .. }) => Event::Lost(reason),
                Some(PortEvent::Line(line)) => Event::Line(line),
                Some(PortEvent::Overlong) => Event::Overlong,
                None => Event::Tick,
            };
            let outputs = self.marlin.on_event(Seconds(self.begin.elapsed().as_secs_f64()), event);
            for output in &outputs {
                if let Output::Ask(question) = output {
                    assert!(self.reader.send(&question.line()));
                }
            }
            if outputs.iter().any(&wished) {
                return;
            }
        }
    }

    fn until_phase(&mut self, phase: JobPhase) {
        self.until("phase", |output| matches!(output, Output::State(state) if state.phase == phase));
    }
}

#[test]
fn a_marlin_is_found_watched_lost_and_found_again() {
    let path = std::env::temp_dir().join(format!("printer_bridge_pty_{}", std::process::id()));
    let printer = StandIn::start(&path);
    let mut bridge = Bridge::open(&path);

    bridge.until("firmware", |output| {
        matches!(output, Output::Note(Note::Found(firmware))
            if firmware.name() == Some(stand_in::NAME) && firmware.has_emergency_parser())
    });
    bridge.until("temperatures", |output| {
        matches!(output, Output::Temperatures(report)
            if report.hotend == Some(Celsius(199.87)) && report.bed == Some(Celsius(59.9)))
    });
    bridge.until_phase(JobPhase::Idle);
    bridge.until("position", |output| {
        matches!(output, Output::State(state) if (state.position_m[1] - 0.02).abs() < 1e-9
            && state.hotend_target == Celsius(200.0) && (state.hotend_duty - 64.0 / 127.0).abs() < 1e-9)
    });

    printer.print_from_card(Some((10, 1000)));
    bridge.until_phase(JobPhase::Printing);
    printer.say("// action:paused");
    bridge.until_phase(JobPhase::Paused);
    printer.print_from_card(Some((20, 1000)));
    bridge.until_phase(JobPhase::Printing);
    printer.say("Error:Printer halted. kill() called!");
    bridge.until_phase(JobPhase::Failed);

    let first = printer.end();
    bridge.until("loss", |output| matches!(output, Output::Note(Note::Lost { .. })));
    let printer = StandIn::start(&path);
    bridge.until("firmware", |output| matches!(output, Output::Note(Note::Found(_))));
    bridge.until_phase(JobPhase::Failed);
    let second = printer.end();

    for sent in [&first, &second] {
        assert_eq!(sent[0], "M115");
        assert_eq!(sent.iter().filter(|line| *line == "M115").count(), 1, "{sent:?}");
        let harmless = ["M115", "M155 S1", "M105", "M27", "M114"];
        assert!(sent.iter().all(|line| harmless.contains(&line.as_str())), "{sent:?}");
    }
    assert_eq!(bridge.marlin.refusals().malformed, 0);
}
