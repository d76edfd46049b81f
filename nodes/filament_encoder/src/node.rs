//! The shell: counts of the printer or a serial line in, checked positions out.

use fdm_loop_msgs::FilamentReport;
use models::units::Seconds;
use runtime::serial::{PortEvent, SerialLine};
use runtime::{Inlet, Node, Reason, Refused, RuntimeError, topics};

use crate::convert;
use crate::encoder::Encoder;
use crate::params::{Driver, LIVE, Params};
use crate::serial_line::{LINE_MAX, LineError, parse};

/// Lines that may wait: a second of counts at 100 Hz. Counts are a sum: one that finds no room is made up for by the
/// next.
const WAITING: usize = 100;

/// Runs the node to its end.
///
/// # Errors
/// [`RuntimeError`] where it cannot start, or its reader has ended.
pub async fn run(mut node: Node) -> Result<(), RuntimeError> {
    let params: Params = node.parameters()?;
    let mut source = Source::open(&mut node, &params)?;
    let mut encoder = Encoder::new(params.encoder);
    let motions = node.publish_on(&topics::FILAMENT_MOTION)?;
    let (clock, work, diagnostics) = (node.clock(), node.work(), node.diagnostics());
    let mut refused = Refused::new(node.diagnostics(), source.name());
    let mut live = node.live_parameters(&LIVE);
    node.activated().await;
    loop {
        tokio::select! {
            counts = source.next() => {
                let Some((stamp, counts)) = counts? else { continue };
                if let Ok(sample) = encoder.on_counts(clock.now(), stamp, counts) {
                    match convert::motion(&sample) {
                        Some(motion) => _ = motions.send(motion),
                        None => diagnostics.count("samples_without_speed"),
                    }
                }
                for (reason, total) in convert::reasons(&encoder.refusals()) {
                    refused.follow(reason, total);
                }
                diagnostics.set("rebases", encoder.rebases());
                work.done();
            }
            changed = live.next() => encoder.retune(changed.parse::<Params>()?.encoder),
            () = node.shutdown() => return Ok(()),
        }
    }
}

/// Where counts come from.
enum Source {
    Printer { reports: Box<Inlet<FilamentReport>>, quantum_m: f64 },
    Serial { line: SerialLine, refused: Refused },
}

impl Source {
    fn open(node: &mut Node, params: &Params) -> Result<Self, RuntimeError> {
        let quantum_m = params.encoder.quantum_m;
        match params.driver {
            Driver::Printer => {
                let oldest = Seconds(params.encoder.stamp_age_max_s);
                let reports = Box::new(node.inlet(&topics::FILAMENT_REPORT, oldest)?);
                Ok(Self::Printer { reports, quantum_m })
            }
            Driver::Serial => {
                let line = node.serial_line(&params.serial, LINE_MAX, WAITING)?;
                Ok(Self::Serial { line, refused: Refused::new(node.diagnostics(), "serial") })
            }
        }
    }

    /// Name of the source in the counters.
    fn name(&self) -> &'static str {
        match self {
            Self::Printer { .. } => topics::FILAMENT_REPORT.name(),
            Self::Serial { .. } => "serial",
        }
    }

    /// The next counts; `None` for what was refused, or is none. Cancelling loses nothing.
    async fn next(&mut self) -> Result<Option<(Seconds, i64)>, RuntimeError> {
        match self {
            Self::Printer { reports, quantum_m } => {
                let quantum_m = *quantum_m;
                Ok(reports.next(|wire| convert::report(wire, quantum_m)).await.ok())
            }
            Self::Serial { line, refused } => {
                let (stamp, event) = line.recv().await?;
                Ok(taken(&event, refused).map(|counts| (stamp, counts)))
            }
        }
    }
}

fn taken(event: &PortEvent, refused: &mut Refused) -> Option<i64> {
    match event {
        PortEvent::Line(line) => match parse(line) {
            Ok(counts) => return Some(counts),
            Err(LineError::Garbage) => refused.count(Reason::Malformed),
            Err(LineError::Other) => {}
        },
        PortEvent::Overlong => refused.count(Reason::Malformed),
        PortEvent::Connected | PortEvent::Lost { .. } => {}
    }
    None
}
