//! Permits of somebody else: the printer believes one publisher, which may not be this one.
//!
//! They are listened to only while another process publishes the topic. A process that listens to what it publishes itself
//! reaches itself by multicast, where `lo` carries it, and so wakes every process of the domain for each permit.

use fdm_loop_msgs::ControlCommand;
use runtime::{Gid, Node, Reason, Refused, Subscription, topics};
use std::time::Duration;

/// Real time between two looks at who publishes permits; discovery takes as long.
pub(super) const LOOK: Duration = Duration::from_millis(250);

/// The ear for them.
pub(super) struct Rivals {
    permits: Option<Subscription<ControlCommand>>,
    own: Gid,
    /// What was heard.
    pub(super) refused: Refused,
}

impl Rivals {
    /// Nobody is known yet.
    pub(super) fn new(node: &Node) -> Self {
        let refused = Refused::new(node.diagnostics(), topics::SAFETY_COMMAND.name());
        Self { permits: None, own: node.identity(), refused }
    }

    /// Looks who publishes permits. Where listening fails it is tried again with the next look, and counted.
    pub(super) fn look(&mut self, node: &mut Node) {
        let topic = node.resolve(topics::SAFETY_COMMAND.name());
        match (node.published_topics().contains(&topic), &self.permits) {
            (true, None) => {
                self.permits = node.subscribe(&topics::SAFETY_COMMAND).ok();
                node.diagnostics().add("rivals_not_heard", u64::from(self.permits.is_none()));
            }
            (false, Some(_)) => self.permits = None,
            (true, Some(_)) | (false, None) => {}
        }
    }

    /// Waits for a permit that another process has sent, and counts it. Cancelling loses none.
    pub(super) async fn next(&mut self) {
        let Some(permits) = &mut self.permits else { return std::future::pending().await };
        while permits.recv().await.publisher.process() == self.own.process() {}
        self.refused.count(Reason::Gate);
    }
}
