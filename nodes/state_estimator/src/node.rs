//! The shell: sensors and printer state in, an estimate per tick out, and one at once on a temperature of the hot end.

use fdm_loop_msgs::StateEstimate;
use models::material::Material;
use models::printer::Printer;
use models::units::Seconds;
use runtime::{
    Clock, Diagnostics, FRAMES_HANDOVER, HANDOVER, Node, ParamFileError, Parameters, Publisher, Reason,
    Refused, RuntimeError, Timer, Work, topics,
};

use crate::channel::Channel;
use crate::convert;
use crate::estimator::{Estimate, Estimator};
use crate::input::{Event, Refusals};
use crate::live::LIVE;
use crate::pace::Pace;
use crate::params::Params;

/// Runs the node to its end.
///
/// # Errors
/// [`RuntimeError`] where it cannot start.
pub async fn run(mut node: Node) -> Result<(), RuntimeError> {
    let mut setup = Setup::read(&node)?;
    let params = setup.params;
    let mut hotend = node
        .inlet(&topics::HOTEND_TEMPERATURE, Seconds(params.thermistor.trust.age_limit_s))?
        .from_one_source(HANDOVER);
    let mut nozzle = node
        .inlet(&topics::NOZZLE_TEMPERATURE, Seconds(params.nozzle_sensor.trust.age_limit_s))?
        .from_one_source(HANDOVER);
    let mut encoder = node
        .inlet(&topics::FILAMENT_MOTION, Seconds(params.encoder.trust.age_limit_s))?
        .from_one_source(HANDOVER);
    let mut width = node
        .inlet(&topics::BEAD_WIDTH, Seconds(params.width.trust.age_limit_s))?
        .from_one_source(FRAMES_HANDOVER);
    let mut printer =
        node.inlet(&topics::PRINTER_STATE, Seconds(params.telemetry.age_limit_s))?.from_one_source(HANDOVER);
    let mut rhythm = Rhythm::open(&mut node, params.period_s)?;
    let mut estimator = setup.estimator();
    let mut live = node.live_parameters(&LIVE);
    node.activated().await;
    loop {
        tokio::select! {
            taken = hotend.next(convert::hotend) => {
                let sampled = taken.is_ok();
                pass(&mut estimator, taken);
                follow(&mut hotend.refused, estimator.refusals(), |all| &all.hotend);
                if sampled {
                    rhythm.answer(&setup, &mut estimator);
                }
            }
            taken = nozzle.next(convert::nozzle) => {
                pass(&mut estimator, taken);
                follow(&mut nozzle.refused, estimator.refusals(), |all| &all.nozzle);
            }
            taken = encoder.next(convert::encoder) => {
                pass(&mut estimator, taken);
                follow(&mut encoder.refused, estimator.refusals(), |all| &all.encoder);
            }
            taken = width.next(convert::width) => {
                pass(&mut estimator, taken);
                follow(&mut width.refused, estimator.refusals(), |all| &all.width);
            }
            taken = printer.next(convert::printer) => {
                pass(&mut estimator, taken);
                follow(&mut printer.refused, estimator.refusals(), |all| &all.printer);
            }
            now = rhythm.ticks.next() => rhythm.tick(now, &setup, &mut estimator),
            changed = live.next() => {
                setup = Setup::of(&changed)?;
                estimator.retune(setup.params);
            }
            () = node.shutdown() => return Ok(()),
        }
    }
}

/// When the filter turns, and what it tells then.
struct Rhythm {
    pace: Pace,
    ticks: Timer,
    jumps: u64,
    clock: Clock,
    work: Work,
    estimates: Publisher<StateEstimate>,
    diagnostics: Diagnostics,
}

impl Rhythm {
    fn open(node: &mut Node, period_s: f64) -> Result<Self, RuntimeError> {
        Ok(Self {
            pace: Pace::new(Seconds(period_s)),
            ticks: node.timer(Seconds(period_s)),
            jumps: node.clock().jumps_back(),
            clock: node.clock(),
            work: node.work(),
            estimates: node.publish_on(&topics::ESTIMATE)?,
            diagnostics: node.diagnostics(),
        })
    }

    /// Answers a sample with an estimate, at once where the pace allows it.
    fn answer(&mut self, setup: &Setup, estimator: &mut Estimator) {
        let now = self.clock.now();
        match self.pace.asked(now) {
            Some(after) => self.ticks.put_off(after),
            None => self.tick(now, setup, estimator),
        }
    }

    /// A turn of the filter; one that a sample waited for counts as an answer.
    fn tick(&mut self, now: Seconds, setup: &Setup, estimator: &mut Estimator) {
        self.turn(now, setup, estimator);
        if let Some(after) = self.pace.turned(now) {
            self.ticks.put_off(after);
        }
    }

    fn turn(&mut self, now: Seconds, setup: &Setup, estimator: &mut Estimator) {
        if std::mem::replace(&mut self.jumps, self.clock.jumps_back()) != self.clock.jumps_back() {
            *estimator = setup.estimator();
        }
        if let Some(estimate) = estimator.on_event(Event::Tick { now }) {
            show(&self.diagnostics, &estimate);
            self.estimates.send(convert::estimate(&estimate));
            self.work.done();
        }
        self.diagnostics.set("refused_ticks", estimator.refusals().tick.disordered);
    }
}

/// What an estimator is made of.
struct Setup {
    params: Params,
    printer: Printer,
    material: Material,
}

impl Setup {
    fn read(node: &Node) -> Result<Self, RuntimeError> {
        node.check_parameters(|parameters| Self::of(parameters).map(drop))?;
        Ok(Self::of(node.raw_parameters())?)
    }

    fn of(parameters: &Parameters) -> Result<Self, ParamFileError> {
        Ok(Self {
            params: parameters.without(&["printer", "material"]).parse()?,
            printer: parameters.block("printer")?,
            material: parameters.block("material")?,
        })
    }

    /// An estimator that has seen nothing: at the start, and when time jumped back.
    fn estimator(&self) -> Estimator {
        Estimator::new(self.params, (&self.printer.hotend, &self.printer.extruder), &self.material)
    }
}

fn pass(estimator: &mut Estimator, taken: Result<Event, Reason>) {
    if let Ok(event) = taken {
        // Only ticks yield an estimate.
        _ = estimator.on_event(event);
    }
}

fn follow(refused: &mut Refused, all: &Refusals, of: fn(&Refusals) -> &crate::input::Refused) {
    for (reason, total) in convert::reasons(of(all)) {
        refused.follow(reason, total);
    }
}

fn show(diagnostics: &Diagnostics, estimate: &Estimate) {
    for (index, name) in runtime::wire::CHANNELS.iter().enumerate() {
        if let Some(mean) = estimate.nis_mean[index] {
            diagnostics.set(&format!("nis_mean_{name}"), format_args!("{mean:.3}"));
        }
        diagnostics.set(&format!("gated_{name}"), estimate.gated[index]);
    }
    diagnostics
        .set("noise_scale_width", format_args!("{:.2}", estimate.noise_scale[Channel::Width as usize]));
    diagnostics.set("melt_lag", format_args!("{:.3}", estimate.melt_lag));
    diagnostics.set("steps", estimate.steps);
    diagnostics.set("resets", estimate.resets);
}
