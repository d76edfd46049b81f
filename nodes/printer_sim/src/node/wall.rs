//! Shell of the wire machine: the same pace, clock and permits as a printer that extrudes.

use super::time::TimeBase;
use super::{LOOK_PERIOD_S, LOOKS_PER_CLOCK, permit};
use crate::convert;
use crate::load::LoadError;
use crate::load::wall::{LoadedWall, load};
use crate::wire::{Machine, MachineOutput};
use fdm_loop_msgs::{ControlCommand, LayerHeight, PrintEvent, PrintInfo, PrinterState, SimWire};
use models::units::Seconds;
use runtime::{Node, Publisher, Reason, Refused, RuntimeError, Sessions, Subscription, topics, wire};

/// Everything that the machine says.
struct Outlets {
    height: Publisher<LayerHeight>,
    state: Publisher<PrinterState>,
    truth: Publisher<SimWire>,
    events: Publisher<PrintEvent>,
    // Latched: kept alive for late joiners.
    info: Publisher<PrintInfo>,
}

struct Shell {
    machine: Machine,
    time: TimeBase,
    outlets: Outlets,
    refused: Refused,
    sessions: Sessions,
    name: String,
    looks: u32,
}

/// Runs until a signal ends it; the machine stays on the graph after its wall is done.
pub(super) async fn run(mut node: Node) -> Result<(), LoadError> {
    let LoadedWall { machine, info, speed } = load(node.raw_parameters())?;
    let mut permits = node.subscribe(&topics::SAFETY_COMMAND)?;
    let time = TimeBase::of(&mut node, false)?;
    let outlets = Outlets::new(&mut node)?;
    let refused = Refused::new(node.diagnostics(), topics::SAFETY_COMMAND.name());
    let (work, diagnostics, name) = (node.work(), node.diagnostics(), node.name());
    let mut shell = Shell { machine, time, outlets, refused, sessions: Sessions::default(), name, looks: 0 };
    node.activated().await;
    shell.outlets.info.send(info);
    let mut pace = shell.time.pace(LOOK_PERIOD_S, speed);
    loop {
        tokio::select! {
            _ = pace.tick() => {
                shell.take_permits(&mut permits);
                shell.advance();
                diagnostics.set("clamped_permits", shell.machine.dead_man().clamped());
                work.done();
            }
            () = node.shutdown() => return Ok(()),
        }
    }
}

impl Outlets {
    fn new(node: &mut Node) -> Result<Self, RuntimeError> {
        Ok(Self {
            height: node.publish_on(&topics::LAYER_HEIGHT)?,
            state: node.publish_on(&topics::PRINTER_STATE)?,
            truth: node.publish_on(&topics::SIM_WIRE)?,
            events: node.publish_on(&topics::EVENTS)?,
            info: node.publish_on(&topics::PRINT_INFO)?,
        })
    }
}

impl Shell {
    fn take_permits(&mut self, permits: &mut Subscription<ControlCommand>) {
        while let Some(received) = permits.try_recv() {
            let taken = permit(self.machine.now(), &received, &self.sessions)
                .and_then(|permit| self.machine.on_permit(permit).map_err(|_| Reason::Gate));
            if let Err(reason) = taken {
                self.refused.count(reason);
            }
        }
    }

    fn advance(&mut self) {
        self.machine.step(Seconds(LOOK_PERIOD_S));
        self.looks += 1;
        let reads = self.looks.is_multiple_of(LOOKS_PER_CLOCK);
        if reads {
            self.time.tell(self.machine.now());
        }
        while let Some(output) = self.machine.poll() {
            self.pass_on(output);
        }
        if reads {
            self.outlets.truth.send(convert::wire_truth(&self.machine.truth()));
        }
    }

    fn pass_on(&self, output: MachineOutput) {
        let outlets = &self.outlets;
        match output {
            MachineOutput::Height { sample, sigma_m } => {
                outlets.height.send(convert::layer_height(&sample, sigma_m));
            }
            MachineOutput::Status(status) => _ = outlets.state.send(wire::status_to_wire(&status)),
            MachineOutput::Note { stamp, text } => {
                tracing::info!("{text}");
                outlets.events.send(convert::note(&self.name, stamp, text));
            }
        }
    }
}
