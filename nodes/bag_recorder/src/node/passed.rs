//! Simulated time beside a recorder that dates by the host's clock.

use runtime::{Node, topics};

/// Looks for simulated time that this recorder does not follow.
pub(crate) struct Passed {
    /// Where it would be published; `None` where there is nothing to tell, or it was told.
    topic: Option<String>,
}

impl Passed {
    pub(crate) fn new(node: &Node) -> Self {
        let follows = node.clock().is_simulated();
        Self { topic: (!follows).then(|| node.resolve(topics::CLOCK.name())) }
    }

    /// Tells once where somebody publishes it.
    pub(crate) fn look(&mut self, node: &Node) {
        if let Some(topic) = self.topic.take_if(|topic| node.published_topics().contains(topic)) {
            tracing::warn!(
                "{topic} is published, and this recorder dates by the host's clock: beside simulated stamps such a bag \
                 neither replays nor plays with --clock; start anew with use_sim_time:=true (fdm record --use-sim-time)"
            );
            node.diagnostics().count("simulated_time_passed_over");
        }
    }
}
