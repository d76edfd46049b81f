//! The shell: lines of the printer in; reports, state, events and questions out.

use fdm_loop_msgs::{PrintEvent, PrinterState, TemperatureReport};
use models::units::Seconds;
use runtime::serial::{PortEvent, SerialLine};
use runtime::wire::status_to_wire;
use runtime::{Diagnostics, FrameParams, Frames, Level, Node, Publisher, Refused, RuntimeError, topics};

use crate::commands::Access;
use crate::convert;
use crate::event::{Event, Link, Output};
use crate::line::LINE_MAX;
use crate::marlin::Marlin;
use crate::note::{Note, Severity};
use crate::params::{Host, Params};

/// Lines that may wait: a second of a Marlin that talks as fast as its line.
const WAITING: usize = 1000;

/// Block with the places of the printer's parts; not given: nobody is told.
const FRAMES: &str = "frames";

/// Runs the node to its end.
///
/// # Errors
/// [`RuntimeError`] where it cannot start, or its reader has ended.
pub async fn run(mut node: Node) -> Result<(), RuntimeError> {
    node.check_parameters(|parameters| {
        _ = parameters.optional::<FrameParams>(FRAMES)?;
        parameters.without(&[FRAMES]).parse::<Params>().map(drop)
    })?;
    let frames: Option<FrameParams> = node.raw_parameters().optional(FRAMES)?;
    let params: Params = node.raw_parameters().without(&[FRAMES]).parse()?;
    if node.clock().is_simulated() {
        return Err(RuntimeError::SimulatedTime { what: "a bridge to a real printer" });
    }
    let (Host::MarlinSerial, Access::ReadOnly) = (params.host, params.read_only);
    let mut line = node.serial_line(&params.serial, LINE_MAX, WAITING)?;
    let frames = frames.map(|params| node.frames(params)).transpose()?;
    let mut outlets = Outlets::open(&mut node, frames)?;
    let mut marlin = Marlin::new(params.marlin);
    let mut ticks = node.timer(Seconds(params.marlin.state_period_s.min(0.1)));
    let work = node.work();
    node.activated().await;
    outlets.tell_frames(node.clock().now());
    loop {
        let (now, event) = tokio::select! {
            received = line.recv() => received.map(|(now, event)| (now, Some(event)))?,
            now = ticks.next() => (now, None),
            () = node.shutdown() => return Ok(()),
        };
        let outputs = marlin.on_event(now, told(event.as_ref()));
        outlets.publish(now, &outputs, &line);
        outlets.report(now, &marlin);
        work.done();
    }
}

fn told(event: Option<&PortEvent>) -> Event<'_> {
    match event {
        Some(PortEvent::Connected) => Event::Connected,
        Some(PortEvent::Lost { reason, .. }) => Event::Lost(reason),
        Some(PortEvent::Line(line)) => Event::Line(line),
        Some(PortEvent::Overlong) => Event::Overlong,
        None => Event::Tick,
    }
}

/// Where everything goes.
struct Outlets {
    frames: Option<Frames>,
    temperatures: Publisher<TemperatureReport>,
    states: Publisher<PrinterState>,
    events: Publisher<PrintEvent>,
    diagnostics: Diagnostics,
    refused: Refused,
    name: String,
}

impl Outlets {
    fn open(node: &mut Node, frames: Option<Frames>) -> Result<Self, RuntimeError> {
        Ok(Self {
            frames,
            temperatures: node.publish_on(&topics::TEMPERATURE_REPORT)?,
            states: node.publish_on(&topics::PRINTER_STATE)?,
            events: node.publish_on(&topics::EVENTS)?,
            diagnostics: node.diagnostics(),
            refused: Refused::new(node.diagnostics(), "serial"),
            name: node.name(),
        })
    }

    fn publish(&mut self, now: Seconds, outputs: &[Output], line: &SerialLine) {
        for output in outputs {
            match output {
                Output::Ask(question) => {
                    if !line.send(&question.line()) {
                        self.diagnostics.count("questions_dropped");
                    }
                }
                Output::Temperatures(report) => _ = self.temperatures.send(convert::temperatures(report)),
                Output::State(state) => {
                    let state = status_to_wire(state);
                    if let Some(frames) = &mut self.frames {
                        frames.tool_at(now, state.position_m);
                    }
                    self.states.send(state);
                }
                Output::Note(note) => self.tell(now, note),
            }
        }
    }

    fn tell_frames(&self, now: Seconds) {
        if let Some(frames) = &self.frames {
            frames.tell(now);
        }
    }

    fn tell(&self, now: Seconds, note: &Note) {
        let event = convert::event(now, &self.name, note);
        match note.severity() {
            Severity::Info => tracing::info!("{}: {}", event.what, event.why),
            Severity::Warn => tracing::warn!("{}: {}", event.what, event.why),
            Severity::Error => tracing::error!("{}: {}", event.what, event.why),
        }
        self.events.send(event);
    }

    fn report(&mut self, now: Seconds, marlin: &Marlin) {
        let refusals = marlin.refusals();
        for (reason, total) in convert::reasons(&refusals) {
            self.refused.follow(reason, total);
        }
        let (level, message) = match marlin.link() {
            Link::Down => (Level::Error, "the serial line is not open"),
            Link::Silent => (Level::Warn, "the printer says nothing"),
            Link::Alive => (Level::Ok, "ok"),
            Link::Halted => {
                (Level::Error, "the firmware has stopped itself: find the cause, then reset the printer")
            }
        };
        self.diagnostics.report(level, message);
        self.diagnostics.set("firmware", marlin.firmware().name().unwrap_or("unknown"));
        self.diagnostics.set("job", convert::job_name(marlin.job().phase()));
        self.diagnostics.set("lines_overlong", refusals.overlong);
        self.diagnostics.set("questions_unanswered", marlin.unanswered());
        if let Some((done, total)) = marlin.job().bytes() {
            self.diagnostics.set("card_bytes", format_args!("{done} of {total}"));
        }
        if let Some(age_s) = marlin.position_age_s(now) {
            self.diagnostics.set("position_age_s", format_args!("{age_s:.1}"));
        }
    }
}
