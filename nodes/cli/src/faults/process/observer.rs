//! A participant that sees what the printer does and what the supervisor says. Its clock is the host's.

use crate::up::fleet::Happening;
use fdm_loop_msgs::{
    Clock as ClockMessage, ControlCommand, DiagnosticArray, Heartbeat, PrinterState, SafetyState, SimTruth,
    Trigger,
};
use models::units::Seconds;
use runtime::{Args, Client, Node, Shutdown, Subscription, Timer, topics};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// How often it looks up where nothing comes `[s]`.
const LOOK_S: f64 = 0.01;

/// Something that was observed.
#[derive(Debug)]
pub(super) enum Seen {
    Printer(Box<PrinterState>),
    /// What the simulated printer really does.
    Truth(Box<SimTruth>),
    Safety(SafetyState),
    /// Node and session.
    Heart(String, u64),
    Permit(Box<ControlCommand>),
    /// The graph's clock `[s]`.
    Clock(f64),
    Report(DiagnosticArray),
    Happened(Happening),
    /// Nothing, but time passes.
    Tick,
}

/// What a person asks for.
pub(super) struct Hand {
    pub(super) estop: Client<Trigger>,
    pub(super) acknowledge: Client<Trigger>,
}

/// The observer.
pub(super) struct Observer {
    printer: Subscription<PrinterState>,
    truth: Subscription<SimTruth>,
    safety: Subscription<SafetyState>,
    hearts: Subscription<Heartbeat>,
    reports: Subscription<DiagnosticArray>,
    clock: Subscription<ClockMessage>,
    permits: Subscription<ControlCommand>,
    shutdown: Shutdown,
    /// Nothing is heard through DDS any more.
    deaf: Arc<AtomicBool>,
    ticks: Timer,
    node: Node,
}

impl Observer {
    /// Joins the graph.
    pub(super) fn join() -> anyhow::Result<Self> {
        let args = Args { namespace: Some(super::NAMESPACE.to_owned()), ..Args::default() };
        let deaf = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&deaf);
        let mut node = Node::start_or("observer", args, move || told.store(true, Ordering::Relaxed))?;
        Ok(Self {
            deaf,
            printer: node.subscribe(&topics::PRINTER_STATE)?,
            truth: node.subscribe(&topics::SIM_TRUTH)?,
            safety: node.subscribe(&topics::SAFETY_STATE)?,
            hearts: node.subscribe(&topics::HEARTBEAT)?,
            reports: node.subscribe(&topics::DIAGNOSTICS)?,
            clock: node.subscribe(&topics::CLOCK)?,
            permits: node.subscribe(&topics::SAFETY_COMMAND)?,
            shutdown: node.shutdown_handle(),
            ticks: node.timer(Seconds(LOOK_S)),
            node,
        })
    }

    /// Prepares a person's calls.
    pub(super) fn hand(&mut self) -> anyhow::Result<Hand> {
        let estop = self.node.client(&topics::SAFETY_ESTOP)?;
        Ok(Hand { estop, acknowledge: self.node.client(&topics::SAFETY_ACKNOWLEDGE)? })
    }

    /// Time now on the observer's clock.
    pub(super) fn now(&self) -> Seconds {
        self.node.clock().now()
    }

    /// Whether a person wants an end.
    pub(super) fn interrupted(&self) -> bool {
        self.shutdown.is_demanded()
    }

    /// Whether nothing is heard through DDS any more, as on a machine that has far too much to do.
    pub(super) fn is_deaf(&self) -> bool {
        self.deaf.load(Ordering::Relaxed)
    }

    /// What comes next with its time of arrival, at most 10 ms later.
    pub(super) async fn next(&mut self) -> anyhow::Result<(Seconds, Seen)> {
        Ok(tokio::select! {
            message = self.printer.recv() => (message.received, Seen::Printer(Box::new(message.message))),
            message = self.truth.recv() => (message.received, Seen::Truth(Box::new(message.message))),
            message = self.safety.recv() => (message.received, Seen::Safety(message.message)),
            message = self.reports.recv() => (message.received, Seen::Report(message.message)),
            message = self.clock.recv() => {
                (message.received, Seen::Clock(message.message.clock.seconds().unwrap_or(f64::NAN)))
            }
            message = self.permits.recv() => (message.received, Seen::Permit(Box::new(message.message))),
            beat = self.hearts.recv() => {
                let name = beat.message.node.rsplit('/').next().unwrap_or_default().to_owned();
                (beat.received, Seen::Heart(name, beat.message.session_id))
            }
            now = self.ticks.next() => (now, Seen::Tick),
        })
    }
}

/// The printer is at the slicer's own values.
pub(super) fn is_neutral(state: &PrinterState) -> bool {
    // Exact: these are the values themselves, not results.
    #[allow(clippy::float_cmp, reason = "set, not computed")]
    let trims = (state.flow_factor, state.speed_factor, state.nozzle_setpoint_offset_k) == (1.0, 1.0, 0.0);
    trims && !state.set_advance && !state.close_extruder_loop
}
