//! A participant that sees what the printer does, what the supervisor says, and who is alive.

use crate::graph::{Graph, Said};
use crate::judge::Record;
use fdm_loop_msgs::{ControlCommand, Heartbeat, PrinterState, SafetyState, Trigger, TriggerRequest};
use models::units::Seconds;
use runtime::{Args, Client, Node, Subscription, Timer, topics};

/// Something that was observed.
#[derive(Debug)]
pub(crate) enum Seen {
    Printer(Box<PrinterState>),
    Safety(SafetyState),
    Permit(Box<ControlCommand>),
    /// A node that beats.
    Heart(String),
    Said(Said),
    /// Nothing, but time passes.
    Tick,
}

/// The observer.
pub(crate) struct Observer {
    printer: Subscription<PrinterState>,
    safety: Subscription<SafetyState>,
    permits: Subscription<ControlCommand>,
    hearts: Subscription<Heartbeat>,
    acknowledge: Client<Trigger>,
    resume: Client<Trigger>,
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
            permits: node.subscribe(&topics::SAFETY_COMMAND).unwrap(),
            hearts: node.subscribe(&topics::HEARTBEAT).unwrap(),
            acknowledge: node.client(&topics::SAFETY_ACKNOWLEDGE).unwrap(),
            resume: node.client(&topics::SAFETY_RESUME).unwrap(),
            ticks: node.timer(Seconds(0.01)),
            node,
        }
    }

    /// Time now on the host's clock.
    pub(crate) fn now(&self) -> Seconds {
        self.node.clock().now()
    }

    /// What comes next, at most 10 ms later.
    pub(crate) async fn next(&mut self, graph: &mut Graph, record: &mut Record) -> Seen {
        let seen = tokio::select! {
            message = self.printer.recv() => Seen::Printer(Box::new(message.message)),
            message = self.safety.recv() => Seen::Safety(message.message),
            message = self.permits.recv() => Seen::Permit(Box::new(message.message)),
            beat = self.hearts.recv() => {
                Seen::Heart(beat.message.node.rsplit('/').next().unwrap_or_default().to_owned())
            }
            said = graph.next() => Seen::Said(said),
            _ = self.ticks.next() => Seen::Tick,
        };
        match &seen {
            Seen::Printer(state) => record.on_state(state),
            Seen::Permit(permit) => record.on_permit(permit),
            _ => {}
        }
        seen
    }

    /// Until the supervisor acts, the printer prints and corrections are in force.
    pub(crate) async fn wait_for_print(&mut self, graph: &mut Graph, limit: Seconds) {
        let (mut acts, mut prints, mut ignored) = (false, false, Record::default());
        let begin = self.now();
        while !(acts && prints) {
            match self.next(graph, &mut ignored).await {
                Seen::Safety(state) => acts = state.mode == SafetyState::MODE_ACT,
                Seen::Printer(state) => {
                    prints = state.phase == PrinterState::PHASE_PRINTING && !is_neutral(&state);
                }
                _ => {}
            }
            let waited_s = (self.now() - begin).0;
            assert!(waited_s < limit.0, "no closed loop after {waited_s:.0} s: acts {acts}, prints {prints}");
        }
        println!("closed loop after {:.1} s", (self.now() - begin).0);
    }

    /// What a person does about a mode that does not end by itself; whether it was granted.
    pub(crate) async fn ask(&self, mode: u8) -> bool {
        let client = if mode == SafetyState::MODE_PAUSED { &self.resume } else { &self.acknowledge };
        client.call(TriggerRequest::default(), Seconds(1.0)).await.is_ok_and(|answer| answer.success)
    }

    /// Ctrl-C, and the end of all processes.
    pub(crate) async fn end(mut self, graph: &mut Graph, limit: Seconds, record: &mut Record) {
        graph.interrupt();
        let begin = self.now();
        while graph.ended().is_none() && (self.now() - begin).0 < limit.0 {
            self.next(graph, record).await;
        }
        assert!(graph.ended().is_some(), "fdm does not end");
        assert_eq!(graph.alive(), Vec::<&String>::new(), "processes are left");
    }
}

/// The printer is at the slicer's own values.
pub(crate) fn is_neutral(state: &PrinterState) -> bool {
    (state.flow_factor, state.speed_factor, state.nozzle_setpoint_offset_k) == (1.0, 1.0, 0.0)
        && !state.set_advance
        && !state.close_extruder_loop
}
