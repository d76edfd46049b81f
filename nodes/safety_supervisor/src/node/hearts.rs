//! Whose heart beats. Not heard one by one: a dozen nodes beat a hundred times a second.

use fdm_loop_msgs::Heartbeat;
use runtime::{Node, RuntimeError, Subscription, topics};
use std::time::Duration;
use tokio::time::{Interval, MissedTickBehavior, interval};

use crate::checks::hearts::LOOK_S;
use crate::convert;
use crate::event::{Event, Worker};

/// Beats that one look hears at most: of all nodes, and then some that were late.
const MOST: usize = 200;

/// The ear for them.
pub(super) struct Hearts {
    beats: Subscription<Heartbeat>,
    names: [String; Worker::ALL.len()],
    looks: Interval,
}

impl Hearts {
    pub(super) fn open(node: &mut Node) -> Result<Self, RuntimeError> {
        let names = Worker::ALL.map(|worker| node.resolve(convert::node_of(worker)));
        let mut looks = interval(Duration::from_secs_f64(LOOK_S));
        // A look that was missed is not made up for: what came in the meantime is heard with the next one.
        looks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        Ok(Self { beats: node.subscribe(&topics::HEARTBEAT)?, names, looks })
    }

    /// Waits until it is time for a look. Cancelling loses none.
    pub(super) async fn next_look(&mut self) {
        self.looks.tick().await;
    }

    /// Tells who was heard since the last look.
    pub(super) fn look(&mut self, mut tell: impl FnMut(Event)) {
        for beat in std::iter::from_fn(|| self.beats.try_recv()).take(MOST) {
            let known = self.names.iter().position(|name| *name == beat.message.node);
            let work = beat.message.work_counter;
            known.into_iter().for_each(|index| tell(Event::Beat { worker: Worker::ALL[index], work }));
        }
        tell(Event::Look);
    }
}
