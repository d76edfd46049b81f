//! The shell: reports of the printer or a serial line in, checked temperatures out.

use fdm_loop_msgs::{Temperature, TemperatureReport};
use models::units::{Celsius, Seconds};
use runtime::{Inlet, Node, Publisher, Reason, Refused, RuntimeError, topics};
use tokio::sync::mpsc;

use crate::channel::Channel;
use crate::convert;
use crate::params::{Driver, Params, SerialParams};
use crate::serial_line::{LineError, Reading};
use crate::serial_port::{PortEvent, SerialReader};

/// Events of the serial line that may wait: a second of reports at 10 Hz.
const WAITING: usize = 10;

/// Runs the node to its end.
///
/// # Errors
/// [`RuntimeError`] where it cannot start, or its reader has ended.
pub async fn run(mut node: Node) -> Result<(), RuntimeError> {
    let params: Params = node.parameters()?;
    let mut source = Source::open(&mut node, &params)?;
    let mut hotend = Outlet::open(&mut node, &params, "hotend")?;
    let mut bed = Outlet::open(&mut node, &params, "bed")?;
    let (clock, work) = (node.clock(), node.work());
    loop {
        tokio::select! {
            reading = source.next() => {
                if let Some((stamp, reading)) = reading? {
                    hotend.pass(clock.now(), stamp, reading.hotend);
                    bed.pass(clock.now(), stamp, reading.bed);
                    work.done();
                }
            }
            () = node.shutdown() => return Ok(()),
        }
    }
}

/// Where reports come from.
enum Source {
    Printer(Box<Inlet<TemperatureReport>>),
    Serial { events: mpsc::Receiver<(Seconds, PortEvent)>, refused: Refused, _reader: SerialReader },
}

impl Source {
    fn open(node: &mut Node, params: &Params) -> Result<Self, RuntimeError> {
        match params.driver {
            Driver::Printer => {
                let oldest_s = params.hotend.stamp_age_max_s.max(params.bed.stamp_age_max_s);
                Ok(Self::Printer(Box::new(node.inlet(&topics::TEMPERATURE_REPORT, Seconds(oldest_s))?)))
            }
            Driver::Serial => {
                let (events, _reader) = serial(node, &params.serial)?;
                Ok(Self::Serial { events, refused: Refused::new(node.diagnostics(), "serial"), _reader })
            }
        }
    }

    /// The next report; `None` for what was refused, or is none. Cancelling loses nothing.
    async fn next(&mut self) -> Result<Option<(Seconds, Reading)>, RuntimeError> {
        match self {
            Self::Printer(reports) => Ok(reports.next(convert::report).await.ok()),
            Self::Serial { events, refused, .. } => {
                let Some((stamp, event)) = events.recv().await else {
                    let source = std::io::Error::other("its thread is gone");
                    return Err(RuntimeError::System { what: "the serial reader has ended", source });
                };
                Ok(taken(event, refused).map(|reading| (stamp, reading)))
            }
        }
    }
}

/// Starts the reader's thread; a reading is dated when its line is complete.
fn serial(
    node: &Node,
    params: &SerialParams,
) -> Result<(mpsc::Receiver<(Seconds, PortEvent)>, SerialReader), RuntimeError> {
    let (clock, diagnostics) = (node.clock(), node.diagnostics());
    let (sender, events) = mpsc::channel(WAITING);
    let sink = move |event| {
        // Where the shell does not keep up: an old temperature is of no use.
        if sender.try_send((clock.now(), event)).is_err() {
            diagnostics.count("serial_dropped");
        }
    };
    SerialReader::spawn(params.clone(), sink)
        .map(|reader| (events, reader))
        .map_err(|source| RuntimeError::System { what: "cannot start the serial reader", source })
}

fn taken(event: PortEvent, refused: &mut Refused) -> Option<Reading> {
    match event {
        PortEvent::Reading(reading) => return Some(reading),
        PortEvent::Refused(LineError::Garbage) => refused.count(Reason::Malformed),
        PortEvent::Refused(LineError::Other) => {}
        PortEvent::Connected => tracing::info!("serial line connected"),
        PortEvent::Lost { reason, retry_s } => {
            tracing::warn!("serial line lost: {reason}; next try in {retry_s} s");
        }
    }
    None
}

/// One thermistor: brain, topic, counters.
struct Outlet {
    frame: &'static str,
    channel: Channel,
    publisher: Publisher<Temperature>,
    refused: Refused,
}

impl Outlet {
    fn open(node: &mut Node, params: &Params, frame: &'static str) -> Result<Self, RuntimeError> {
        let hotend = frame == "hotend";
        let topic = if hotend { &topics::HOTEND_TEMPERATURE } else { &topics::BED_TEMPERATURE };
        let source = match params.driver {
            Driver::Printer => topics::TEMPERATURE_REPORT.name(),
            Driver::Serial => "serial",
        };
        Ok(Self {
            frame,
            channel: Channel::new(if hotend { params.hotend } else { params.bed }),
            publisher: node.publish_on(topic)?,
            refused: Refused::new(node.diagnostics(), source),
        })
    }

    fn pass(&mut self, now: Seconds, stamp: Seconds, temp: Option<Celsius>) {
        let Some(temp) = temp else { return };
        if let Ok(sample) = self.channel.on_report(now, stamp, temp) {
            self.publisher.send(convert::temperature(&sample, self.frame));
        }
        for (reason, total) in convert::reasons(&self.channel.refusals()) {
            self.refused.follow(reason, total);
        }
    }
}
