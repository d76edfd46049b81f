//! Brings the graph up in order: all nodes are configured side by side, then activated one after another, who records
//! and who guards first, the printer last. A node that is started again goes to active by itself.

use super::fleet::Fleet;
use super::watch::Watch;
use crate::output;
use anyhow::bail;
use fdm_loop_msgs::{ChangeState, ChangeStateRequest, GetState, GetStateRequest, State, Transition};
use futures::future::join_all;
use models::units::Seconds;
use runtime::{Client, Node, RuntimeError, topics};
use std::cell::Cell;
use std::path::Path;
use std::pin::pin;

/// How often processes are looked at meanwhile `[s]`.
const LOOK_S: f64 = 0.05;
/// A node that is not there after this time is named `[s]`: discovery takes 0.5 s.
const LATE_S: f64 = 3.0;
/// Then it is given up `[s]`.
const GIVE_UP_S: f64 = 60.0;
/// Time for one answer: who was asked may have ended meanwhile `[s]`.
const ANSWER_S: f64 = 2.0;

/// One node.
struct Charge {
    name: &'static str,
    change: Client<ChangeState>,
    state: Client<GetState>,
    /// The newest state that it was brought to.
    reached: Cell<u8>,
}

impl Charge {
    fn new(node: &mut Node, namespace: &str, name: &'static str) -> Result<Self, RuntimeError> {
        let path = format!("{}/{name}", namespace.trim_end_matches('/'));
        Ok(Self {
            name,
            change: node.client_of(&path, &topics::CHANGE_STATE)?,
            state: node.client_of(&path, &topics::GET_STATE)?,
            reached: Cell::new(State::UNCONFIGURED),
        })
    }

    /// Takes a step; a node that has been started again may be further already.
    async fn step(&self, step: u8, goal: u8, logs: &Path) -> anyhow::Result<()> {
        loop {
            let transition = Transition { id: step, label: String::new() };
            let answer = self.change.call(ChangeStateRequest { transition }, Seconds(ANSWER_S)).await;
            if answer.as_ref().is_ok_and(|answer| answer.success) {
                break;
            }
            let state = self.state.call(GetStateRequest::default(), Seconds(ANSWER_S)).await;
            match (answer, state.map(|answer| answer.current_state.id)) {
                (_, Ok(state)) if (goal..=State::ACTIVE).contains(&state) => break,
                (Ok(_), Ok(state)) if state <= State::FINALIZED => {
                    let log = logs.join(format!("{}.log", self.name));
                    let what = if goal == State::INACTIVE { "configured" } else { "activated" };
                    bail!("{} could not be {what}: see {}", self.name, log.display());
                }
                // No answer, or another step is under way: again.
                _ => {}
            }
        }
        self.reached.set(goal);
        Ok(())
    }
}

/// Brings all nodes to active; false where a person wants an end before.
///
/// # Errors
/// The node that refuses or does not answer.
pub(super) async fn bring_up(watch: &mut Watch, fleet: &mut Fleet, logs: &Path) -> anyhow::Result<bool> {
    let namespace = watch.namespace.clone();
    let names = fleet.pids().into_iter().map(|(name, _)| name);
    let charges: Vec<Charge> =
        names.map(|name| Charge::new(&mut watch.ears.node, &namespace, name)).collect::<Result<_, _>>()?;
    let mut all = pin!(in_order(&charges, logs));
    let mut ticks = watch.ears.node.timer(Seconds(LOOK_S));
    let (clock, mut told) = (watch.ears.node.clock(), false);
    let from = clock.now();
    loop {
        let now = tokio::select! {
            done = &mut all => return done.map(|()| true),
            now = ticks.next() => now,
            () = watch.ears.node.shutdown() => return Ok(false),
        };
        watch.tend(fleet, now);
        if watch.ears.are_deaf() {
            bail!("fdm was stopped, or hears nothing any more, while the graph came up: start it again");
        }
        let elapsed_s = (now - from).0;
        if elapsed_s > GIVE_UP_S {
            bail!("not up within {GIVE_UP_S} s: {}", late(&charges));
        }
        if elapsed_s > LATE_S && !std::mem::replace(&mut told, true) {
            output::note(&format!("waiting for {}", late(&charges)));
        }
    }
}

async fn in_order(charges: &[Charge], logs: &Path) -> anyhow::Result<()> {
    let configured = charges.iter().map(|charge| charge.step(Transition::CONFIGURE, State::INACTIVE, logs));
    for result in join_all(configured).await {
        result?;
    }
    for charge in charges {
        charge.step(Transition::ACTIVATE, State::ACTIVE, logs).await?;
    }
    Ok(())
}

/// Who is not there yet, and how far they are.
fn late(charges: &[Charge]) -> String {
    let far = |charge: &Charge| match charge.reached.get() {
        State::ACTIVE => None,
        State::INACTIVE => Some(format!("{} (not active)", charge.name)),
        _ => Some(format!("{} (not configured)", charge.name)),
    };
    charges.iter().filter_map(far).collect::<Vec<_>>().join(", ")
}
