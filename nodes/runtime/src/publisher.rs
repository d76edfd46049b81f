//! Publishing: synchronous, never waiting, drops counted.

use crate::lifecycle::Gate;
use crate::stats::TopicStats;
use fdm_loop_msgs::RosType;
use std::sync::Arc;

/// One end of a topic that this node publishes on.
pub struct Publisher<T: RosType> {
    writer: ros2_client::Publisher<T>,
    stats: Arc<TopicStats>,
    gate: Gate,
}

impl<T: RosType> std::fmt::Debug for Publisher<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Publisher").field("stats", &self.stats).finish_non_exhaustive()
    }
}

impl<T: RosType> Publisher<T> {
    pub(crate) fn new(writer: ros2_client::Publisher<T>, stats: Arc<TopicStats>, gate: Gate) -> Self {
        Self { writer, stats, gate }
    }

    /// Sends a message; false where it was dropped because a reliable subscriber does not keep up (or the middleware
    /// failed). Drops are counted and shown in `/diagnostics`. Takes no longer than a copy into the send window.
    ///
    /// A managed node that is not active sends nothing: false.
    pub fn send(&self, message: T) -> bool {
        if !self.gate.is_open() {
            return false;
        }
        let sent = self.writer.publish(message).is_ok();
        if sent {
            self.stats.sent();
        } else {
            self.stats.lose();
        }
        sent
    }

    /// Messages sent so far.
    #[must_use]
    pub fn sent(&self) -> u64 {
        self.stats.passed_count()
    }

    /// Messages dropped so far.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.stats.lost_count()
    }
}
