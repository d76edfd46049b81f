//! The shell: reports of the printer or a serial line in, checked temperatures out.

use fdm_loop_msgs::{Temperature, TemperatureReport};
use models::units::{Celsius, Seconds};
use runtime::serial::{PortEvent, SerialLine};
use runtime::topics::{self, Topic};
use runtime::{Inlet, Node, Publisher, Reason, Refused, RuntimeError};

use crate::channel::Channel;
use crate::convert;
use crate::params::{ChannelParams, Driver, Params};
use crate::serial_line::{LINE_MAX, LineError, Reading, parse};

/// Lines that may wait: a second of reports at 10 Hz; an old temperature is of no use.
const WAITING: usize = 10;

/// What may change while the node is active: how a value is judged, not where it comes from.
const LIVE: [&str; 15] = [
    "hotend.min_c",
    "hotend.max_c",
    "hotend.rate_max_k_s",
    "hotend.sigma_k",
    "hotend.quantum_k",
    "bed.min_c",
    "bed.max_c",
    "bed.rate_max_k_s",
    "bed.sigma_k",
    "bed.quantum_k",
    "nozzle.min_c",
    "nozzle.max_c",
    "nozzle.rate_max_k_s",
    "nozzle.sigma_k",
    "nozzle.quantum_k",
];

/// Runs the node to its end.
///
/// # Errors
/// [`RuntimeError`] where it cannot start, or its reader has ended.
pub async fn run(mut node: Node) -> Result<(), RuntimeError> {
    let params: Params = node.parameters()?;
    let mut source = Source::open(&mut node, &params)?;
    let mut hotend =
        Outlet::open(&mut node, params.driver, (&topics::HOTEND_TEMPERATURE, "hotend"), params.hotend)?;
    let mut bed = Outlet::open(&mut node, params.driver, (&topics::BED_TEMPERATURE, "bed"), params.bed)?;
    let at_nozzle = (&topics::NOZZLE_TEMPERATURE, "nozzle");
    let mut nozzle = params
        .nozzle_fitted
        .then(|| Outlet::open(&mut node, params.driver, at_nozzle, params.nozzle))
        .transpose()?;
    let mut live = node.live_parameters(&LIVE);
    let (clock, work) = (node.clock(), node.work());
    // Who watches the others is watched too.
    node.witness_supervisor()?;
    node.activated().await;
    loop {
        tokio::select! {
            reading = source.next() => {
                if let Some((stamp, reading)) = reading? {
                    hotend.pass(clock.now(), stamp, reading.hotend);
                    bed.pass(clock.now(), stamp, reading.bed);
                    if let Some(nozzle) = &mut nozzle {
                        nozzle.pass(clock.now(), stamp, reading.nozzle);
                    }
                    work.done();
                }
            }
            changed = live.next() => {
                let params: Params = changed.parse()?;
                hotend.channel.retune(params.hotend);
                bed.channel.retune(params.bed);
                if let Some(nozzle) = &mut nozzle {
                    nozzle.channel.retune(params.nozzle);
                }
            }
            () = node.shutdown() => return Ok(()),
        }
    }
}

/// Where reports come from.
enum Source {
    Printer(Box<Inlet<TemperatureReport>>),
    Serial { line: SerialLine, refused: Refused },
}

impl Source {
    fn open(node: &mut Node, params: &Params) -> Result<Self, RuntimeError> {
        match params.driver {
            Driver::Printer => {
                let channels = [params.hotend, params.bed, params.nozzle];
                let oldest_s =
                    channels.map(|channel| channel.stamp_age_max_s).into_iter().fold(0.0, f64::max);
                Ok(Self::Printer(Box::new(node.inlet(&topics::TEMPERATURE_REPORT, Seconds(oldest_s))?)))
            }
            Driver::Serial => {
                let line = node.serial_line(&params.serial, LINE_MAX, WAITING)?;
                Ok(Self::Serial { line, refused: Refused::new(node.diagnostics(), "serial") })
            }
        }
    }

    /// The next report; `None` for what was refused, or is none. Cancelling loses nothing.
    async fn next(&mut self) -> Result<Option<(Seconds, Reading)>, RuntimeError> {
        match self {
            Self::Printer(reports) => Ok(reports.next(convert::report).await.ok()),
            Self::Serial { line, refused } => {
                let (stamp, event) = line.recv().await?;
                Ok(taken(&event, refused).map(|reading| (stamp, reading)))
            }
        }
    }
}

fn taken(event: &PortEvent, refused: &mut Refused) -> Option<Reading> {
    match event {
        PortEvent::Line(line) => match parse(line) {
            Ok(reading) => return Some(reading),
            Err(LineError::Garbage) => refused.count(Reason::Malformed),
            Err(LineError::Other) => {}
        },
        PortEvent::Overlong => refused.count(Reason::Malformed),
        PortEvent::Connected | PortEvent::Lost { .. } => {}
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
    fn open(
        node: &mut Node,
        driver: Driver,
        (topic, frame): (&Topic<Temperature>, &'static str),
        params: ChannelParams,
    ) -> Result<Self, RuntimeError> {
        let source = match driver {
            Driver::Printer => topics::TEMPERATURE_REPORT.name(),
            Driver::Serial => "serial",
        };
        Ok(Self {
            frame,
            channel: Channel::new(params),
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
