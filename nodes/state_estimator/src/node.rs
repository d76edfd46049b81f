//! The shell: sensors and printer state in, an estimate per tick out.

use models::material::Material;
use models::printer::Printer;
use models::units::Seconds;
use runtime::{Diagnostics, Node, ParamFileError, Parameters, Reason, Refused, RuntimeError, topics};

use crate::channel::Channel;
use crate::convert;
use crate::estimator::{Estimate, Estimator};
use crate::input::{Event, Refusals};
use crate::live::LIVE;
use crate::params::Params;

/// Runs the node to its end.
///
/// # Errors
/// [`RuntimeError`] where it cannot start.
pub async fn run(mut node: Node) -> Result<(), RuntimeError> {
    let mut setup = Setup::read(&node)?;
    let params = setup.params;
    let mut hotend = node.inlet(&topics::HOTEND_TEMPERATURE, Seconds(params.thermistor.trust.age_limit_s))?;
    let mut encoder = node.inlet(&topics::FILAMENT_MOTION, Seconds(params.encoder.trust.age_limit_s))?;
    let mut width = node.inlet(&topics::BEAD_WIDTH, Seconds(params.width.trust.age_limit_s))?;
    let mut printer = node.inlet(&topics::PRINTER_STATE, Seconds(params.telemetry.age_limit_s))?;
    let estimates = node.publish_on(&topics::ESTIMATE)?;
    let mut ticks = node.timer(Seconds(params.period_s));
    let (clock, work, diagnostics) = (node.clock(), node.work(), node.diagnostics());
    let (mut estimator, mut jumps) = (setup.estimator(), clock.jumps_back());
    let mut live = node.live_parameters(&LIVE);
    node.activated().await;
    loop {
        tokio::select! {
            taken = hotend.next(convert::hotend) => {
                pass(&mut estimator, taken);
                follow(&mut hotend.refused, estimator.refusals(), |all| &all.hotend);
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
            now = ticks.next() => {
                if std::mem::replace(&mut jumps, clock.jumps_back()) != clock.jumps_back() {
                    estimator = setup.estimator();
                }
                if let Some(estimate) = estimator.on_event(Event::Tick { now }) {
                    show(&diagnostics, &estimate);
                    estimates.send(convert::estimate(&estimate));
                }
                diagnostics.set("refused_ticks", estimator.refusals().tick.disordered);
                work.done();
            }
            changed = live.next() => {
                setup = Setup::of(&changed)?;
                estimator.retune(setup.params);
            }
            () = node.shutdown() => return Ok(()),
        }
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
        node.check_parameters(|parameters| Self::of(parameters).map(drop));
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
    diagnostics.set("steps", estimate.steps);
    diagnostics.set("resets", estimate.resets);
}
