//! What `fdm` hears of the graph. It does not end where it hears nothing any more: it joins anew.

use fdm_loop_msgs::{DiagnosticArray, Heartbeat, PrintEvent, PrinterState, SafetyState, SimTruth};
use runtime::{Args, Node, Subscription, topics};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The participant and its streams.
pub(super) struct Ears {
    pub(super) state: Subscription<PrinterState>,
    pub(super) safety: Subscription<SafetyState>,
    pub(super) truth: Subscription<SimTruth>,
    pub(super) heartbeats: Subscription<Heartbeat>,
    pub(super) events: Subscription<PrintEvent>,
    pub(super) reports: Subscription<DiagnosticArray>,
    pub(super) node: Node,
    deaf: Arc<AtomicBool>,
}

impl Ears {
    /// Joins the graph.
    ///
    /// # Errors
    /// What keeps the participant from starting.
    pub(super) fn join(namespace: &str) -> anyhow::Result<Self> {
        let args = Args { namespace: Some(namespace.to_owned()), ..Args::default() };
        let deaf = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&deaf);
        let mut node = Node::start_or("fdm", args, move || told.store(true, Ordering::Relaxed))?;
        Ok(Self {
            state: node.subscribe(&topics::PRINTER_STATE)?,
            safety: node.subscribe(&topics::SAFETY_STATE)?,
            truth: node.subscribe(&topics::SIM_TRUTH)?,
            heartbeats: node.subscribe(&topics::HEARTBEAT)?,
            events: node.subscribe(&topics::EVENTS)?,
            reports: node.subscribe(&topics::DIAGNOSTICS)?,
            node,
            deaf,
        })
    }

    /// Whether nothing is heard any more.
    pub(super) fn are_deaf(&self) -> bool {
        self.deaf.load(Ordering::Relaxed)
    }
}
