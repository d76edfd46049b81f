//! The five services of a managed node.

use super::life::Life;
use super::machine::{Machine, Step};
use crate::error::RuntimeError;
use crate::node::Node;
use crate::service::{Asked, Server};
use crate::topics;
use fdm_loop_msgs::{
    ChangeState, ChangeStateResponse, GetAvailableStates, GetAvailableStatesResponse,
    GetAvailableTransitions, GetAvailableTransitionsResponse, GetState, GetStateResponse,
};
use tokio::sync::{mpsc, oneshot};

/// A step to be taken, and where its end is told: whether it succeeded.
pub(crate) struct Order {
    pub(super) step: Step,
    pub(super) ended: oneshot::Sender<bool>,
}

/// The answering ends. They work beside the shell: what it does takes no longer for them.
pub(crate) struct LifecycleServices {
    change: Server<ChangeState>,
    state: Server<GetState>,
    states: Server<GetAvailableStates>,
    transitions: Server<GetAvailableTransitions>,
    graph: Server<GetAvailableTransitions>,
}

/// A step under way whose end somebody waits for.
type Pending = Option<(Asked<ChangeState>, oneshot::Receiver<bool>)>;

impl LifecycleServices {
    /// Offers all of them.
    pub(crate) fn open(node: &mut Node) -> Result<Self, RuntimeError> {
        Ok(Self {
            change: node.serve(&topics::CHANGE_STATE)?,
            state: node.serve(&topics::GET_STATE)?,
            states: node.serve(&topics::GET_AVAILABLE_STATES)?,
            transitions: node.serve(&topics::GET_AVAILABLE_TRANSITIONS)?,
            graph: node.serve(&topics::GET_TRANSITION_GRAPH)?,
        })
    }

    /// Answers for ever; steps go to `orders`.
    pub(crate) async fn serve(mut self, life: Life, orders: mpsc::Sender<Order>) {
        let mut pending: Pending = None;
        loop {
            tokio::select! {
                asked = self.change.next() => self.change(asked, &life, (&orders, &mut pending)),
                success = ended(&mut pending) => if let Some((asked, _)) = pending.take() {
                    self.change.answer(&asked, ChangeStateResponse { success });
                },
                asked = self.state.next() => {
                    self.state.answer(&asked, GetStateResponse { current_state: life.state() });
                }
                asked = self.states.next() => {
                    self.states.answer(&asked, GetAvailableStatesResponse { available_states: Machine::states() });
                }
                asked = self.transitions.next() => {
                    let available_transitions = life.available();
                    self.transitions.answer(&asked, GetAvailableTransitionsResponse { available_transitions });
                }
                asked = self.graph.next() => {
                    let available_transitions = Machine::graph();
                    self.graph.answer(&asked, GetAvailableTransitionsResponse { available_transitions });
                }
            }
        }
    }

    /// Begins a step, or refuses it at once.
    fn change(
        &self,
        asked: Asked<ChangeState>,
        life: &Life,
        (orders, pending): (&mpsc::Sender<Order>, &mut Pending),
    ) {
        let wanted = &asked.request.transition;
        if let Some(step) = life.request(wanted) {
            let (ended, end) = oneshot::channel();
            // The driver takes one order at a time and none is begun while another is under way: there is room.
            if orders.try_send(Order { step, ended }).is_ok() {
                *pending = Some((asked, end));
                return;
            }
        }
        tracing::warn!(
            "transition {} '{}' refused: the node is {}",
            wanted.id,
            wanted.label,
            life.state().label
        );
        self.change.answer(&asked, ChangeStateResponse { success: false });
    }
}

/// Waits for the end of the step under way.
async fn ended(pending: &mut Pending) -> bool {
    match pending {
        Some((_, end)) => end.await.unwrap_or(false),
        None => std::future::pending().await,
    }
}
