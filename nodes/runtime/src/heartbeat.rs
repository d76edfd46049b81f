//! Proof of work: a node that hangs stops beating, and one whose loop turns without work shows a counter that stands still.

use crate::clock::Clock;
use crate::publisher::Publisher;
use crate::self_loop::SelfLoopAge;
use fdm_loop_msgs::{Header, Heartbeat};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Real time between two beats: a hang must be seen within 0.5 s (C4), so four may be lost.
const PERIOD: Duration = Duration::from_millis(100);

/// Counts units of work; clones count together.
#[derive(Debug, Clone, Default)]
pub struct Work(Arc<AtomicU64>);

impl Work {
    /// One unit of work is done: an estimate, a plan, a permit, a frame, a recorded message.
    pub fn done(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    /// Units of work so far.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

/// Who beats.
pub(crate) struct Heart {
    pub(crate) node: String,
    pub(crate) session: u64,
    pub(crate) work: Work,
    pub(crate) clock: Clock,
    pub(crate) self_loop: SelfLoopAge,
}

/// Beats on the executor of the shell, so that it stops where the shell hangs.
pub(crate) async fn beat(heart: Heart, publisher: Publisher<Heartbeat>) {
    let mut ticks = tokio::time::interval(PERIOD);
    ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
    let mut sequence = 0;
    loop {
        ticks.tick().await;
        sequence += 1;
        let age = heart.self_loop.age();
        publisher.send(Heartbeat {
            header: Header::at(heart.clock.stamp().0),
            node: heart.node.clone(),
            session_id: heart.session,
            sequence,
            work_counter: heart.work.count(),
            self_loop_established: age.is_some(),
            self_loop_age_s: age.map_or(0.0, |age| age.0),
        });
    }
}
