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
use tokio::sync::oneshot::error::TryRecvError;
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

/// A step under way, who asked for it, and where its end is told.
struct UnderWay<A>(Option<(A, oneshot::Receiver<bool>)>);

impl<A> UnderWay<A> {
    /// Waits for the end: who asked, and whether the step succeeded. For ever where none is under way.
    async fn ended(&mut self) -> (A, bool) {
        let success = match &mut self.0 {
            Some((_, end)) => end.await.unwrap_or(false),
            None => std::future::pending().await,
        };
        match self.0.take() {
            Some((asked, _)) => (asked, success),
            None => std::future::pending().await,
        }
    }

    /// The same where the end is there already.
    fn try_ended(&mut self) -> Option<(A, bool)> {
        let (_, end) = self.0.as_mut()?;
        let success = match end.try_recv() {
            Ok(success) => success,
            Err(TryRecvError::Closed) => false,
            Err(TryRecvError::Empty) => return None,
        };
        self.0.take().map(|(asked, _)| (asked, success))
    }
}

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
        let mut pending = UnderWay(None);
        loop {
            tokio::select! {
                asked = self.change.next() => self.change(asked, &life, (&orders, &mut pending)),
                (asked, success) = pending.ended() => {
                    self.change.answer(&asked, ChangeStateResponse { success });
                }
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

    /// Begins a step, or refuses it at once. A step that has just ended is answered first: nobody waits in vain because
    /// another client was quick.
    fn change(
        &self,
        asked: Asked<ChangeState>,
        life: &Life,
        (orders, pending): (&mpsc::Sender<Order>, &mut UnderWay<Asked<ChangeState>>),
    ) {
        if let Some((first, success)) = pending.try_ended() {
            self.change.answer(&first, ChangeStateResponse { success });
        }
        let wanted = &asked.request.transition;
        if pending.0.is_none()
            && let Some(step) = life.request(wanted)
        {
            let (ended, end) = oneshot::channel();
            // The driver takes one order at a time and none is begun while another is under way: there is room.
            if orders.try_send(Order { step, ended }).is_ok() {
                pending.0 = Some((asked, end));
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::future::poll_fn;
    use std::pin::pin;
    use std::task::Poll;

    /// Whoever asked gets the end of the step, however it is looked for; where the driver has gone, the step has failed.
    #[tokio::test]
    async fn the_end_of_a_step_is_told_to_who_asked_for_it() {
        let (ended, end) = oneshot::channel();
        let mut pending = UnderWay(Some(("first", end)));
        assert_eq!(pending.try_ended(), None, "the step is under way");
        // Another request is looked at in between: the wait is given up and taken up again.
        poll_fn(|context| {
            assert!(pin!(pending.ended()).poll(context).is_pending());
            Poll::Ready(())
        })
        .await;
        ended.send(true).unwrap();
        assert_eq!(pending.try_ended(), Some(("first", true)));
        assert_eq!(pending.try_ended(), None, "told once");

        let (ended, end) = oneshot::channel();
        pending.0 = Some(("second", end));
        drop(ended);
        assert_eq!(pending.ended().await, ("second", false));
    }
}
