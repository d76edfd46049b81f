//! A participant that sees what the printer does and what the supervisor says. Its clock is the host's.

use crate::graph::{Graph, Said};
use fdm_loop_msgs::{Heartbeat, PrinterState, SafetyState, Trigger, TriggerRequest};
use models::units::Seconds;
use runtime::{Args, Client, Node, Subscription, Timer, topics};

/// Something that was observed, with its time of arrival.
#[derive(Debug)]
pub(crate) enum Seen {
    Printer(Box<PrinterState>),
    Safety(SafetyState),
    /// Node and session.
    Heart(String, u64),
    Said(Said),
    /// Nothing, but time passes.
    Tick,
}

/// The observer.
pub(crate) struct Observer {
    printer: Subscription<PrinterState>,
    safety: Subscription<SafetyState>,
    hearts: Subscription<Heartbeat>,
    acknowledge: Client<Trigger>,
    ticks: Timer,
    node: Node,
}

impl Observer {
    /// Joins the graph.
    pub(crate) fn join() -> Self {
        let args = Args { namespace: Some("/printer".to_owned()), ..Args::default() };
        let mut node = Node::start_with("observer", args).unwrap();
        Self {
            printer: node.subscribe(&topics::PRINTER_STATE).unwrap(),
            safety: node.subscribe(&topics::SAFETY_STATE).unwrap(),
            hearts: node.subscribe(&topics::HEARTBEAT).unwrap(),
            acknowledge: node.client(&topics::SAFETY_ACKNOWLEDGE).unwrap(),
            ticks: node.timer(Seconds(0.01)),
            node,
        }
    }

    /// Time now on the observer's clock.
    pub(crate) fn now(&self) -> Seconds {
        self.node.clock().now()
    }

    /// What comes next, at most 10 ms later.
    pub(crate) async fn next(&mut self, graph: &mut Graph) -> (Seconds, Seen) {
        let clock = self.node.clock();
        tokio::select! {
            message = self.printer.recv() => (message.received, Seen::Printer(Box::new(message.message))),
            message = self.safety.recv() => (message.received, Seen::Safety(message.message)),
            beat = self.hearts.recv() => {
                let name = beat.message.node.rsplit('/').next().unwrap_or_default().to_owned();
                (beat.received, Seen::Heart(name, beat.message.session_id))
            }
            said = graph.next() => (clock.now(), Seen::Said(said)),
            now = self.ticks.next() => (now, Seen::Tick),
        }
    }

    /// Looks on until `done` or until `limit` has passed; whether it was done.
    pub(crate) async fn until(
        &mut self,
        graph: &mut Graph,
        limit: Seconds,
        mut done: impl FnMut(Seconds, &Seen) -> bool,
    ) -> bool {
        let end = self.now() + limit;
        loop {
            let (at, seen) = self.next(graph).await;
            if done(at, &seen) {
                return true;
            }
            if self.now() > end {
                return false;
            }
        }
    }

    /// Asks for `safety/acknowledge`; whether it was granted, and the answer.
    pub(crate) async fn acknowledge(&self) -> (bool, String) {
        match self.acknowledge.call(TriggerRequest::default(), Seconds(2.0)).await {
            Ok(answer) => (answer.success, answer.message),
            Err(error) => (false, error.to_string()),
        }
    }
}

/// The printer is at the slicer's own values.
pub(crate) fn is_neutral(state: &PrinterState) -> bool {
    (state.flow_factor, state.speed_factor, state.nozzle_setpoint_offset_k) == (1.0, 1.0, 0.0)
        && !state.set_advance
        && !state.close_extruder_loop
}
