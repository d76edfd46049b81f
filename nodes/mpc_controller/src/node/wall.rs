//! The shell of the wire profile: heights and states in, commands out.

use models::command::{Command, Trims};
use models::units::Seconds;
use models::wire::Process;
use runtime::params::Parameters;
use runtime::wire::command_to_wire;
use runtime::{Diagnostics, Node, ParamFileError, Reason, Refused, RuntimeError, topics};

use crate::convert;
use crate::wire::{LoopParams, Params, WireControl, WireEvent, WireReport};

/// What a loop is made of.
struct Setup {
    params: LoopParams,
    profile: Params,
    process: Process,
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
            params: parameters.without(&["wire_controller", "wire_process"]).parse()?,
            profile: parameters.block("wire_controller")?,
            process: parameters.block("wire_process")?,
            session,
        })
    }

    /// A loop that has seen nothing: at the start, and when time jumped back.
    fn control(&self) -> Result<WireControl, RuntimeError> {
        let nominal = (self.process.law, self.process.limits);
        WireControl::new(self.params, self.profile, nominal, self.session).map_err(|error| {
            let at = "wire_process.law".to_owned();
            ParamFileError::Refused { at, message: error.to_string() }.into()
        })
    }
}

/// Runs the profile to its end; its last word are the planned speeds.
pub(super) async fn run(mut node: Node) -> Result<(), RuntimeError> {
    let setup = Setup::read(&node)?;
    let params = setup.params;
    let mut height = node.inlet(&topics::LAYER_HEIGHT, Seconds(params.height_age_limit_s))?;
    let mut printer = node.inlet(&topics::PRINTER_STATE, Seconds(params.status_age_limit_s))?;
    let commands = node.publish_on(&topics::CONTROL_COMMAND)?;
    let mut ticks = node.timer(Seconds(params.period_s));
    let (clock, work, diagnostics) = (node.clock(), node.work(), node.diagnostics());
    let (mut control, mut jumps) = (setup.control()?, clock.jumps_back());
    let mut sequence = 0;
    node.activated().await;
    loop {
        tokio::select! {
            taken = height.next(convert::height) => {
                pass(&mut control, taken);
                follow_heights(&mut height.refused, &control.report());
            }
            taken = printer.next(convert::wire_printer) => {
                pass(&mut control, taken);
                for (reason, total) in convert::reasons(&control.report().printer) {
                    printer.refused.follow(reason, total);
                }
            }
            now = ticks.next() => {
                if std::mem::replace(&mut jumps, clock.jumps_back()) != clock.jumps_back() {
                    control = setup.control()?;
                }
                if let Some(command) = control.on_event(WireEvent::Tick { now }) {
                    // A loop made anew counts from one; the session's sequence goes on.
                    sequence += 1;
                    commands.send(command_to_wire(clock.now(), &Command { sequence, ..command }));
                }
                show(&diagnostics, &control.report());
                work.done();
            }
            () = node.shutdown() => break,
        }
    }
    let last = Command {
        session: setup.session,
        sequence: sequence + 1,
        validity: Seconds(params.validity_s),
        trims: Trims::NEUTRAL,
    };
    commands.send(command_to_wire(clock.now(), &last));
    Ok(())
}

fn pass(control: &mut WireControl, taken: Result<WireEvent, Reason>) {
    // Only ticks yield a command.
    _ = taken.ok().and_then(|event| control.on_event(event));
}

fn follow_heights(refused: &mut Refused, report: &WireReport) {
    let heights = report.heights;
    for (reason, total) in [
        (Reason::NotFinite, heights.not_finite),
        (Reason::OutOfRange, heights.out_of_range),
        (Reason::Order, heights.old_layer),
    ] {
        refused.follow(reason, total);
    }
}

fn show(diagnostics: &Diagnostics, report: &WireReport) {
    diagnostics.set("corrected", report.corrected);
    diagnostics.set("limited", report.limited);
    diagnostics.set("unmeasured", report.unmeasured);
    diagnostics.set("starved", report.starved);
    diagnostics.set("flow", format_args!("{:.4}", report.flow));
}
