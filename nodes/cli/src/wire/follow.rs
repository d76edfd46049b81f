//! `fdm` as a participant of a wire machine's graph: follows the wall, and gathers its figures from the truth.

use crate::output;
use crate::up::ending;
use crate::up::fleet::{Fleet, Recipe};
use crate::up::words::{mode_name, text};
use anyhow::bail;
use fdm_loop_msgs::{Heartbeat, PrinterState, SafetyState, SimWire};
use models::status::JobPhase;
use models::units::Seconds;
use runtime::{Args, Node, Subscription, topics};
use safety_supervisor::Cause;
use serde::Serialize;
use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// How often processes and topics are looked at `[s]`.
const LOOK_S: f64 = 0.05;
/// Time to hear a graph that already runs `[s]`.
const LISTEN_S: f64 = 1.0;
/// The machine's state stays away this long: the simulation is over or dead `[s]`.
const LOST_S: f64 = 20.0;

/// How a wall ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum WallEnded {
    /// Its last layer is laid.
    Done,
    /// The job was given up.
    Failed,
    /// A person ended it.
    Interrupted,
    /// The machine went silent.
    Lost,
}

/// The figures of a wall.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Built {
    /// How it ended.
    ended: WallEnded,
    /// Mode of the supervisor as asked for.
    mode: String,
    /// Seed of all scatter and noise.
    seed: u64,
    /// Height RMS against the plan, layer by layer.
    layers_rms_mm: Vec<f64>,
    /// The same over all layers; none before the first layer is laid.
    rms_mm: Option<f64>,
    /// Time of the process.
    time_s: f64,
    /// Modes of the supervisor in their order.
    modes: Vec<String>,
}

impl Built {
    /// Whether the last layer is laid, or a person ended it.
    #[must_use]
    pub fn is_done(&self) -> bool {
        matches!(self.ended, WallEnded::Done | WallEnded::Interrupted)
    }

    /// How it ended, for people.
    #[must_use]
    pub fn ended(&self) -> &'static str {
        match self.ended {
            WallEnded::Done => "done",
            WallEnded::Failed => "the job was given up",
            WallEnded::Interrupted => "ended by a person",
            WallEnded::Lost => "the machine went silent",
        }
    }

    /// The figures for people.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        _ = writeln!(text, "wall         {} in mode {}, seed {}", self.ended(), self.mode, self.seed);
        _ = writeln!(text, "time         {:.0} s of the process", self.time_s);
        _ = writeln!(text, "supervisor   {}", self.modes.join(", "));
        for (index, rms_mm) in self.layers_rms_mm.iter().enumerate() {
            _ = writeln!(text, "layer {:>3}    height RMS {rms_mm:.3} mm", index + 1);
        }
        _ = match self.rms_mm {
            Some(rms_mm) => write!(text, "all layers   height RMS {rms_mm:.3} mm (simulated truth)"),
            None => write!(text, "all layers   no figure: no layer was laid to its end"),
        };
        text
    }
}

/// The graph as `fdm` sees it.
pub struct Follow {
    node: Node,
    /// Nothing is heard any more, as after a stop of the process.
    deaf: Arc<AtomicBool>,
    state: Subscription<PrinterState>,
    safety: Subscription<SafetyState>,
    truth: Subscription<SimWire>,
    heartbeats: Subscription<Heartbeat>,
    quiet: bool,
    phase: Option<u8>,
    newest: SimWire,
    layers_rms_mm: Vec<f64>,
    modes: Vec<String>,
    /// A person ended the job, by `fdm stop` say.
    stopped: bool,
}

/// Height RMS over the layers laid; 0 before the first one is no figure of a wall.
fn rms_mm(truth: &SimWire) -> Option<f64> {
    (truth.layers_complete > 0).then_some(1e3 * truth.rms_m)
}

impl Follow {
    /// Joins the graph.
    ///
    /// # Errors
    /// What keeps the participant from starting.
    pub fn start(namespace: &str, quiet: bool) -> anyhow::Result<Self> {
        let namespace = Some(namespace.to_owned());
        let deaf = Arc::new(AtomicBool::new(false));
        let told = Arc::clone(&deaf);
        let mut node = Node::start_or("fdm", Args { namespace, ..Args::default() }, move || {
            told.store(true, Ordering::Relaxed);
        })?;
        Ok(Self {
            state: node.subscribe(&topics::PRINTER_STATE)?,
            safety: node.subscribe(&topics::SAFETY_STATE)?,
            truth: node.subscribe(&topics::SIM_WIRE)?,
            heartbeats: node.subscribe(&topics::HEARTBEAT)?,
            node,
            deaf,
            quiet,
            phase: None,
            newest: SimWire::default(),
            layers_rms_mm: Vec::new(),
            modes: Vec::new(),
            stopped: false,
        })
    }

    /// Two graphs in one domain and namespace would command one machine.
    ///
    /// # Errors
    /// Names a node that is already there.
    pub async fn refuse_second_graph(&mut self, recipes: &[Recipe]) -> anyhow::Result<()> {
        let mut ticks = self.node.timer(Seconds(LOOK_S));
        let begin = self.node.clock().now();
        while (self.node.clock().now() - begin).0 < LISTEN_S {
            _ = ticks.next().await;
            while let Some(beat) = self.heartbeats.try_recv() {
                let node = beat.message.node;
                let name = node.rsplit('/').next().unwrap_or_default();
                if recipes.iter().any(|recipe| recipe.name == name) {
                    bail!(
                        "{node} already runs in this domain: stop it, or set another ROS_DOMAIN_ID or --namespace"
                    );
                }
            }
        }
        Ok(())
    }

    /// Follows the wall to its end.
    pub async fn to_the_end(&mut self, fleet: &mut Fleet) -> WallEnded {
        let mut ticks = self.node.timer(Seconds(LOOK_S));
        let mut heard = self.node.clock().now();
        loop {
            let now = tokio::select! {
                now = ticks.next() => now,
                () = self.node.shutdown() => return WallEnded::Interrupted,
            };
            for happening in fleet.tend(now) {
                output::note(&text(&happening));
            }
            if self.deaf.load(Ordering::Relaxed) {
                output::note("fdm was stopped and continued, or hears nothing any more: it ends the nodes");
                return WallEnded::Lost;
            }
            if self.listen() {
                heard = now;
            }
            match self.phase {
                Some(phase) if phase == JobPhase::Done as u8 => return WallEnded::Done,
                Some(phase) if phase == JobPhase::Failed as u8 => return WallEnded::Failed,
                _ if fleet.has_lost("printer_sim") || (now - heard).0 > LOST_S => return WallEnded::Lost,
                _ => {}
            }
        }
    }

    /// Ends the nodes in order, and hears what they say last.
    pub async fn stop(&mut self, fleet: &mut Fleet) {
        ending::end(fleet, &self.node).await;
        self.listen();
    }

    /// The figures.
    #[must_use]
    pub fn built(self, ended: WallEnded, mode: &str, seed: u64) -> Built {
        // The cause may come after the phase.
        let by_a_person = ended == WallEnded::Failed && self.stopped;
        Built {
            ended: if by_a_person { WallEnded::Interrupted } else { ended },
            mode: mode.to_owned(),
            seed,
            layers_rms_mm: self.layers_rms_mm,
            rms_mm: rms_mm(&self.newest),
            time_s: self.newest.header.stamp.seconds().unwrap_or(0.0),
            modes: self.modes,
        }
    }

    /// Takes everything that came in; whether the machine was heard.
    fn listen(&mut self) -> bool {
        while let Some(safety) = self.safety.try_recv() {
            let name = mode_name(safety.message.mode);
            self.stopped |= safety.message.cause.ends_with(Cause::OperatorStop.text());
            let changed = self.modes.last().is_none_or(|last| !last.starts_with(name));
            if changed {
                let cause = safety.message.cause;
                self.modes.push(if cause.is_empty() { name.to_owned() } else { format!("{name} ({cause})") });
            }
        }
        while let Some(truth) = self.truth.try_recv() {
            self.take(truth.message);
        }
        let newest = self.state.drain_newest();
        let heard = newest.is_some();
        self.phase = newest.map(|state| state.message.phase).or(self.phase);
        heard
    }

    fn take(&mut self, truth: SimWire) {
        let complete = usize::try_from(truth.layers_complete).unwrap_or(usize::MAX);
        if complete > self.layers_rms_mm.len() && complete <= self.layers_rms_mm.len() + 1 {
            self.layers_rms_mm.push(1e3 * truth.layer_rms_m);
            if !self.quiet {
                output::note(&format!("layer {complete}: height RMS {:.3} mm", 1e3 * truth.layer_rms_m));
            }
        }
        self.newest = truth;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn built(truth: &SimWire, ended: WallEnded) -> Built {
        let (layers_rms_mm, modes) = (Vec::new(), Vec::new());
        let mode = "act".to_owned();
        Built { ended, mode, seed: 1, layers_rms_mm, rms_mm: rms_mm(truth), time_s: 3.0, modes }
    }

    #[test]
    fn a_wall_without_a_layer_has_no_figure() {
        let none = built(&SimWire::default(), WallEnded::Interrupted);
        assert!(none.text().contains("no figure") && !none.text().contains("0.000 mm"), "{}", none.text());
        assert!(serde_json::to_value(&none).unwrap()["rms_mm"].is_null());
        let one = built(&SimWire { layers_complete: 1, rms_m: 2e-4, ..SimWire::default() }, WallEnded::Lost);
        assert!(one.text().contains("height RMS 0.200 mm"), "{}", one.text());
        assert!(none.is_done() && !one.is_done());
    }
}
