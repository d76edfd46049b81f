//! The shell: estimates and measurements in, commands out.

use fdm_loop_msgs::{
    AdvancePrediction, BeadWidth, ControlCommand, FilamentMotion, MotionSegment, MotionTrim as TrimMessage,
    PrinterState, StateEstimate,
};
use models::command::{AdvanceLaw, Command, MotionTrim, Scheduled, Trims};
use models::material::Material;
use models::printer::Printer;
use models::units::Seconds;
use runtime::wire::{command_to_wire, schedule_to_wire};
use runtime::{
    FRAMES_HANDOVER, HANDOVER, Inlet, Node, ParamFileError, Parameters, Publisher, Reason, Refused,
    RuntimeError, topics,
};
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::controller::Controller;
use crate::convert;
use crate::input::{self, Coming, Event, Refusals};
use crate::params::{AdvanceSource, Params};
use crate::qp::BuildError;
use crate::wire::WireLevel;
use narrowing::Narrowing;

mod diagnostics;
mod narrowing;
mod wall;

/// What may change while the node is active: what an error costs, how far and how fast a trim may go.
const LIVE: [&str; 24] = [
    "cost.width_scale",
    "cost.temperature_scale_k",
    "cost.temperature_weight",
    "cost.speed_scale",
    "cost.feed_scale",
    "cost.setpoint_weight_1_k2",
    "cost.change_weight",
    "cost.feed_change",
    "cost.speed_change",
    "cost.setpoint_change_k",
    "limits.feed",
    "limits.speed_low",
    "limits.speed_high",
    "limits.setpoint_k",
    "limits.feed_rate",
    "limits.speed_rate",
    "limits.setpoint_rate_k",
    "limits.force_margin",
    "deadband.start",
    "deadband.full",
    "deadband.start_k",
    "deadband.full_k",
    "trims.feed_gain",
    "trims.speed_gain",
];

/// Runs the node to its end; its last word are the slicer's own values.
///
/// # Errors
/// [`RuntimeError`] where it cannot start.
pub async fn run(node: Node) -> Result<(), RuntimeError> {
    match node.raw_parameters().block::<Kind>("control")? {
        Kind::Wire(WireLevel::Wire) => wall::run(node).await,
        Kind::Extrusion(_) => extrude(node).await,
    }
}

/// What is controlled, before any parameter of it is read.
#[derive(Deserialize)]
#[serde(untagged)]
enum Kind {
    /// The wire process.
    Wire(WireLevel),
    /// Any level of extrusion; its own parameters tell which.
    Extrusion(IgnoredAny),
}

async fn extrude(mut node: Node) -> Result<(), RuntimeError> {
    let mut setup = Setup::read(&node)?;
    let Inlets { mut estimate, mut printer, mut encoder, mut width, mut predictions, mut coming } =
        Inlets::open(&mut node, &setup.params)?;
    let commands = node.publish_on(&topics::CONTROL_COMMAND)?;
    let mut schedule = Schedule::open(&mut node, &setup.params)?;
    let mut ticks = node.timer(Seconds(setup.params.period_s));
    let (clock, work, diagnostics) = (node.clock(), node.work(), node.diagnostics());
    let (mut controller, mut jumps) = (setup.controller()?, clock.jumps_back());
    let mut live = node.live_parameters(&LIVE);
    let (mut newest, mut narrowing) = (setup.neutral(), Narrowing::SOUND);
    node.activated().await;
    loop {
        tokio::select! {
            taken = estimate.next(convert::estimate) => {
                if let Some(mut command) = pass(&mut controller, taken) {
                    // A controller made anew counts from one; the session's sequence goes on.
                    command.sequence = newest.sequence + 1;
                    newest = command;
                    commands.send(told(clock.now(), &command, &controller));
                }
                follow(&mut estimate.refused, &controller, |all| &all.estimate);
            }
            taken = printer.next(convert::printer) => {
                pass(&mut controller, taken);
                follow(&mut printer.refused, &controller, |all| &all.printer);
            }
            taken = encoder.next(convert::encoder) => {
                pass(&mut controller, taken);
                follow(&mut encoder.refused, &controller, |all| &all.encoder);
            }
            taken = width.next(convert::width) => {
                pass(&mut controller, taken);
                schedule.send_anew(clock.now(), &mut controller);
                follow(&mut width.refused, &controller, |all| &all.width);
            }
            taken = predictions.next(convert::prediction) => {
                pass(&mut controller, taken);
                follow(&mut predictions.refused, &controller, |all| &all.prediction);
            }
            taken = coming.next(convert::coming) => schedule.plan(clock.now(), taken, &mut controller),
            now = ticks.next() => {
                if std::mem::replace(&mut jumps, clock.jumps_back()) != clock.jumps_back() {
                    controller = setup.controller()?;
                }
                pass(&mut controller, Ok(Event::Tick { now }));
                diagnostics::show(&diagnostics, &mut narrowing, &controller.report());
                work.done();
            }
            changed = live.next() => {
                setup = Setup::of(&changed, setup.session)?;
                controller.retune(setup.params).map_err(refused)?;
            }
            () = node.shutdown() => break,
        }
    }
    let last = Command { sequence: newest.sequence + 1, trims: Trims::NEUTRAL, ..newest };
    commands.send(command_to_wire(clock.now(), &last));
    node.spoken().await;
    Ok(())
}

/// Every stream.
struct Inlets {
    estimate: Inlet<StateEstimate>,
    printer: Inlet<PrinterState>,
    encoder: Inlet<FilamentMotion>,
    width: Inlet<BeadWidth>,
    predictions: Inlet<AdvancePrediction>,
    coming: Inlet<MotionSegment>,
}

impl Inlets {
    fn open(node: &mut Node, params: &Params) -> Result<Self, RuntimeError> {
        let limits = [params.status_age_limit_s, params.estimate_age_limit_s, params.advance.age_limit_s];
        let [telemetry, estimate, prediction] = limits.map(Seconds);
        Ok(Self {
            estimate: node.inlet(&topics::ESTIMATE, estimate)?.from_one_source(HANDOVER),
            printer: node.inlet(&topics::PRINTER_STATE, telemetry)?.from_one_source(HANDOVER),
            encoder: node.inlet(&topics::FILAMENT_MOTION, telemetry)?.from_one_source(HANDOVER),
            width: node
                .inlet(&topics::BEAD_WIDTH, params.frame_age_limit())?
                .from_one_source(FRAMES_HANDOVER),
            predictions: node
                .inlet(&topics::ADVANCE_PREDICTION, longest_silence(params.advance.source, prediction))?
                .with_stamps_within(prediction),
            // A host that attaches nothing to moves is silent here.
            coming: node
                .inlet(&topics::PRINTER_COMING, Seconds(f64::INFINITY))?
                .with_stamps_within(telemetry),
        })
    }
}

/// Silence of the advance predictor that is told: it runs only where it is asked.
fn longest_silence(source: AdvanceSource, age_limit: Seconds) -> Seconds {
    match source {
        AdvanceSource::Predicted => age_limit,
        AdvanceSource::None | AdvanceSource::File | AdvanceSource::Material | AdvanceSource::Planned => {
            Seconds(f64::INFINITY)
        }
    }
}

/// What is sent of coming moves.
struct Schedule {
    outlet: Publisher<TrimMessage>,
    newest: Scheduled,
}

impl Schedule {
    fn open(node: &mut Node, params: &Params) -> Result<Self, RuntimeError> {
        let advance = AdvanceLaw { linear_s: 0.0, shear: 0.0, index: 1.0 };
        let newest = Scheduled {
            session: node.session(),
            sequence: 0,
            validity: Seconds(params.advance.schedule_validity_s),
            trim: MotionTrim { sequence: 0, flow: 1.0, speed: 1.0, advance, carried_m: 0.0 },
        };
        Ok(Self { outlet: node.publish_on(&topics::CONTROL_SCHEDULE)?, newest })
    }

    /// Sends the controller's trim of a coming move, where it has one.
    fn plan(&mut self, now: Seconds, taken: Result<Coming, Reason>, controller: &mut Controller) {
        let trim = taken.ok().and_then(|coming| controller.on_coming(now, &coming));
        if let Some(trim) = trim {
            self.send(now, trim);
        }
    }

    /// Sends the trims that are others since they were sent.
    fn send_anew(&mut self, now: Seconds, controller: &mut Controller) {
        controller.take_anew(now).into_iter().for_each(|trim| self.send(now, trim));
    }

    fn send(&mut self, now: Seconds, trim: MotionTrim) {
        self.newest = Scheduled { sequence: self.newest.sequence + 1, trim, ..self.newest };
        self.outlet.send(schedule_to_wire(now, &self.newest));
    }
}

/// A command as sent, with how the controller's work goes.
fn told(now: Seconds, command: &Command, controller: &Controller) -> ControlCommand {
    ControlCommand { health: controller.health() as u8, ..command_to_wire(now, command) }
}

/// What a controller is made of.
struct Setup {
    params: Params,
    printer: Printer,
    material: Material,
    session: u64,
}

impl Setup {
    fn read(node: &Node) -> Result<Self, RuntimeError> {
        let session = node.session();
        node.check_parameters(move |parameters| Self::of(parameters, session).map(drop))?;
        Ok(Self::of(node.raw_parameters(), session)?)
    }

    fn of(parameters: &Parameters, session: u64) -> Result<Self, ParamFileError> {
        Ok(Self {
            params: parameters.without(&["printer", "material"]).parse()?,
            printer: parameters.block("printer")?,
            material: parameters.block("material")?,
            session,
        })
    }

    /// The slicer's own values, before the first command.
    fn neutral(&self) -> Command {
        let validity = Seconds(self.params.validity_s);
        Command { session: self.session, sequence: 0, validity, trims: Trims::NEUTRAL }
    }

    /// A controller that has seen nothing: at the start, and when time jumped back.
    fn controller(&self) -> Result<Controller, RuntimeError> {
        let printer = (&self.printer.hotend, &self.printer.extruder);
        Controller::new(self.params, printer, &self.material, self.session).map_err(refused)
    }
}

fn refused(error: BuildError) -> RuntimeError {
    let at = "parameters of mpc_controller".to_owned();
    ParamFileError::Refused { at, message: error.to_string() }.into()
}

fn pass(controller: &mut Controller, taken: Result<Event, Reason>) -> Option<Command> {
    taken.ok().and_then(|event| controller.on_event(event))
}

fn follow(refused: &mut Refused, controller: &Controller, of: fn(&Refusals) -> &input::Refused) {
    for (reason, total) in convert::reasons(of(&controller.report().refusals)) {
        refused.follow(reason, total);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// No warning of a node that was never to be started.
    #[test]
    fn a_predictor_that_is_not_asked_may_be_silent() {
        use AdvanceSource::{File, Material, None, Planned, Predicted};
        for source in [None, File, Material, Planned] {
            assert_eq!(longest_silence(source, Seconds(10.0)), Seconds(f64::INFINITY), "{source:?}");
        }
        assert_eq!(longest_silence(Predicted, Seconds(10.0)), Seconds(10.0));
    }
}
