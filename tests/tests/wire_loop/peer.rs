//! A participant that sees what machine, controller and supervisor say, and speaks in their place once they are gone.

use fdm_loop_msgs::{ControlCommand, Header, PrinterState, SafetyState, SimWire};
use models::units::Seconds;
use runtime::{Args, Node, Publisher, Subscription, Timer, topics};
use std::time::Duration;

/// Longest wait for anything: the walls of this test take some 30 s each.
const PATIENCE: Duration = Duration::from_secs(150);

/// The newest of everything.
#[derive(Debug, Default)]
pub(crate) struct Seen {
    pub(crate) machine: Option<PrinterState>,
    pub(crate) safety: Option<SafetyState>,
    pub(crate) truth: Option<SimWire>,
    pub(crate) permit: Option<ControlCommand>,
    /// Largest flow of all permits of the supervisor since it was last set.
    pub(crate) flow_max: f64,
}

/// The participant.
pub(crate) struct Peer {
    machine: Subscription<PrinterState>,
    safety: Subscription<SafetyState>,
    truth: Subscription<SimWire>,
    permits: Subscription<ControlCommand>,
    wishes: Publisher<ControlCommand>,
    orders: Option<Publisher<ControlCommand>>,
    ticks: Timer,
    node: Node,
    sequence: u64,
    pub(crate) seen: Seen,
}

impl Peer {
    pub(crate) fn join() -> Self {
        let mut node = Node::start_with("peer", Args::default()).unwrap();
        Self {
            machine: node.subscribe(&topics::PRINTER_STATE).unwrap(),
            safety: node.subscribe(&topics::SAFETY_STATE).unwrap(),
            truth: node.subscribe(&topics::SIM_WIRE).unwrap(),
            permits: node.subscribe(&topics::SAFETY_COMMAND).unwrap(),
            wishes: node.publish_on(&topics::CONTROL_COMMAND).unwrap(),
            orders: None,
            ticks: node.timer(Seconds(0.01)),
            node,
            sequence: 0,
            seen: Seen::default(),
        }
    }

    /// Looks on until `done`; false when that takes too long.
    pub(crate) async fn until(&mut self, mut done: impl FnMut(&Seen) -> bool) -> bool {
        let limit = tokio::time::sleep(PATIENCE);
        tokio::pin!(limit);
        while !done(&self.seen) {
            tokio::select! {
                state = self.machine.recv() => self.seen.machine = Some(state.message),
                state = self.safety.recv() => self.seen.safety = Some(state.message),
                truth = self.truth.recv() => self.seen.truth = Some(truth.message),
                permit = self.permits.recv() => {
                    self.seen.flow_max = self.seen.flow_max.max(permit.message.flow_factor);
                    self.seen.permit = Some(permit.message);
                }
                () = &mut limit => return false,
            }
        }
        true
    }

    /// Sends a flow in the controller's place, or in the supervisor's, every 10 ms until `done`.
    pub(crate) async fn speak_until(
        &mut self,
        (as_supervisor, flow): (bool, f64),
        mut done: impl FnMut(&Seen) -> bool,
    ) -> bool {
        if as_supervisor && self.orders.is_none() {
            self.orders = Some(self.node.publish_on(&topics::SAFETY_COMMAND).unwrap());
        }
        let limit = tokio::time::sleep(PATIENCE);
        tokio::pin!(limit);
        while !done(&self.seen) {
            tokio::select! {
                _ = self.ticks.next() => self.speak(as_supervisor, flow),
                state = self.machine.recv() => self.seen.machine = Some(state.message),
                state = self.safety.recv() => self.seen.safety = Some(state.message),
                permit = self.permits.recv() => {
                    if permit.message.session_id != SESSION {
                        self.seen.flow_max = self.seen.flow_max.max(permit.message.flow_factor);
                    }
                }
                () = &mut limit => return false,
            }
        }
        true
    }

    fn speak(&mut self, as_supervisor: bool, flow: f64) {
        let Some(stamp) = self.seen.machine.as_ref().map(|state| state.header.stamp.clone()) else { return };
        self.sequence += 1;
        let message = ControlCommand {
            header: Header { stamp, ..Header::default() },
            session_id: SESSION,
            sequence: self.sequence,
            validity_s: if as_supervisor { 0.25 } else { 1.0 },
            mode: if as_supervisor { ControlCommand::MODE_ACT } else { ControlCommand::MODE_INIT },
            flow_factor: flow,
            speed_factor: 1.0,
            ..ControlCommand::default()
        };
        match self.orders.as_ref().filter(|_| as_supervisor) {
            Some(orders) => _ = orders.send(message),
            None => _ = self.wishes.send(message),
        }
    }
}

/// Session of what the peer itself says.
const SESSION: u64 = 99;

/// The machine is at its planned speeds.
pub(crate) fn is_neutral(state: &PrinterState) -> bool {
    (state.flow_factor, state.speed_factor) == (1.0, 1.0)
}

/// Time of a state `[s]`.
pub(crate) fn stamp_s(state: &PrinterState) -> f64 {
    state.header.stamp.seconds().unwrap()
}
