//! The shell: batches of the printer or of Linux industrial I/O in, checked batches and a stream for tools out.

pub mod iio;

use fdm_loop_msgs::{Imu, ImuBatch};
use models::units::Seconds;
use runtime::{Clock, Diagnostics, Inlet, Level, Node, Presence, Publisher, Refused, RuntimeError, topics};

use crate::accelerometer::{Accelerometer, Refusal, Report};
use crate::convert;
use crate::params::{Driver, LIVE, Params};
use crate::window::Verdict;
use iio::{Iio, IioEvent};

/// Looks at the clock within the time after which the source counts as lost.
const LOOKS: f64 = 4.0;

/// Runs the node to its end.
///
/// # Errors
/// [`RuntimeError`] where it cannot start.
pub async fn run(mut node: Node) -> Result<(), RuntimeError> {
    let params: Params = node.parameters()?;
    let mut source = Source::open(&mut node, &params)?;
    let mut outlet = Outlet::open(&mut node, &params, source.name())?;
    let mut looks = node.timer(Seconds(params.unit.lost_after_s / LOOKS));
    let work = node.work();
    let mut live = node.live_parameters(&LIVE);
    node.activated().await;
    loop {
        tokio::select! {
            report = source.next(&mut outlet.presence) => if let Some(report) = report {
                outlet.pass(report);
            },
            _ = looks.next() => outlet.look(),
            changed = live.next() => outlet.unit.retune(changed.parse::<Params>()?.unit),
            () = node.shutdown() => return Ok(()),
        }
        work.done();
    }
}

/// Where batches come from.
enum Source {
    Printer(Box<Inlet<ImuBatch>>),
    Iio { device: Box<Iio>, clock: Clock, frame: String, sequence: u64 },
}

impl Source {
    fn open(node: &mut Node, params: &Params) -> Result<Self, RuntimeError> {
        let unit = &params.unit;
        Ok(match params.driver {
            Driver::Printer => {
                let oldest = Seconds(unit.stamp_age_max_s + unit.window_s);
                Self::Printer(Box::new(node.inlet(&topics::IMU_REPORT, oldest)?))
            }
            Driver::Iio => Self::Iio {
                device: Box::new(Iio::new(params.iio.clone(), unit.clone())),
                clock: node.clock(),
                frame: unit.frame.to_string(),
                sequence: 0,
            },
        })
    }

    /// Name of the source in counters and events.
    fn name(&self) -> &'static str {
        match self {
            Self::Printer(_) => topics::IMU_REPORT.name(),
            Self::Iio { .. } => "iio",
        }
    }

    /// The next batch; `None` for what was refused, or is none. Cancelling loses nothing.
    async fn next(&mut self, presence: &mut Presence) -> Option<Report> {
        match self {
            Self::Printer(reports) => reports.next(convert::report).await.ok(),
            Self::Iio { device, clock, frame, sequence } => match device.next().await {
                IioEvent::Found { text } => {
                    tracing::info!("{text}");
                    None
                }
                IioEvent::Lost { reason, retry_s } => {
                    tracing::warn!("{reason}; next try in {retry_s} s");
                    presence.explain(&reason);
                    None
                }
                IioEvent::Batch { samples, period, range_m_s2 } => {
                    let first_sequence = *sequence;
                    *sequence += samples.len() as u64;
                    #[allow(clippy::cast_precision_loss, reason = "samples of a batch")]
                    let span = Seconds(samples.len().saturating_sub(1) as f64 * period.0);
                    // The device gives no time: the newest sample was complete when it was read.
                    let first = clock.now() - span;
                    Some(Report { frame: frame.clone(), first, first_sequence, period, range_m_s2, samples })
                }
            },
        }
    }
}

/// Brain, topics, counters.
struct Outlet {
    unit: Accelerometer,
    frame: String,
    clock: Clock,
    batches: Publisher<ImuBatch>,
    samples: Publisher<Imu>,
    presence: Presence,
    refused: Refused,
    diagnostics: Diagnostics,
}

impl Outlet {
    fn open(node: &mut Node, params: &Params, source: &str) -> Result<Self, RuntimeError> {
        Ok(Self {
            unit: Accelerometer::new(params.unit.clone()),
            frame: params.unit.frame.to_string(),
            clock: node.clock(),
            batches: node.publish_on(&topics::IMU_BATCH)?,
            samples: node.publish_on(&topics::IMU_DATA)?,
            presence: node.presence(source, Seconds(params.unit.lost_after_s))?,
            refused: Refused::new(node.diagnostics(), source),
            diagnostics: node.diagnostics(),
        })
    }

    fn pass(&mut self, report: Report) {
        match self.unit.on_report(self.clock.now(), report) {
            Ok(checked) => {
                self.presence.seen();
                for thinned in &checked.thinned {
                    self.samples.send(convert::thinned(thinned, &self.frame));
                }
                self.batches.send(convert::batch(checked));
            }
            Err(Refusal::Unproven) => self.presence.expect(),
            Err(_counted) => {}
        }
        for (reason, total) in convert::reasons(&self.unit.refusals()) {
            self.refused.follow(reason, total);
        }
    }

    fn look(&mut self) {
        let verdict = self.unit.verdict();
        if let Verdict::Unit { .. } | Verdict::Axes { .. } | Verdict::Rate { .. } = verdict {
            self.presence.explain(&verdict.to_string());
        }
        self.presence.look();
        let diagnostics = &self.diagnostics;
        match self.presence.loss() {
            Some(loss) => diagnostics.report(Level::Error, &loss),
            None => diagnostics.report(Level::Ok, "ok"),
        }
        let (totals, refusals) = (self.unit.totals(), self.unit.refusals());
        for (name, value) in [
            ("saturated_samples", totals.saturated),
            ("lost_samples", totals.lost),
            ("restarts_of_device", totals.restarts),
            ("batches_before_proof", refusals.unproven),
            ("batches_of_untrue_unit", refusals.untrue),
            ("source_losses", self.presence.losses()),
        ] {
            diagnostics.set(name, value);
        }
        diagnostics.set("verdict", verdict);
        if let Some(figures) = self.unit.figures() {
            diagnostics.set("mean_m_s2", format_args!("{:.3}", figures.mean_m_s2));
            diagnostics.set("tilt_deg", format_args!("{:.1}", figures.tilt_deg));
            diagnostics.set("rate_hz", format_args!("{:.1}", figures.rate_hz));
        }
    }
}
