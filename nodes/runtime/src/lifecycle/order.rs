//! A node that starts by itself may wait for others: the printer prints when everybody is there.

use crate::node::Node;
use crate::topics;
use fdm_loop_msgs::{GetStateRequest, State};
use models::units::Seconds;
use std::time::Duration;
use tokio::time::{Instant, sleep};

/// Time for one answer `[s]`.
const ANSWER_S: f64 = 1.0;
/// Pause between two questions.
const PAUSE: Duration = Duration::from_millis(100);
/// Who is waited for so long is named, and again as often.
const LATE: Duration = Duration::from_secs(3);

/// Waits until every node of `names`, of this node's namespace, is active.
pub(super) async fn all_active(node: &Node, names: &[String]) {
    let mut asked = Vec::new();
    for name in names {
        match node.client_at(&node.resolve(name), &topics::GET_STATE) {
            Ok(client) => asked.push((name, client)),
            Err(error) => tracing::error!("cannot wait for {name}: {error}"),
        }
    }
    let mut told = Instant::now();
    for (index, (_, client)) in asked.iter().enumerate() {
        loop {
            let state = client.call(GetStateRequest::default(), Seconds(ANSWER_S)).await;
            if state.is_ok_and(|answer| answer.current_state.id == State::ACTIVE) {
                break;
            }
            if told.elapsed() >= LATE {
                told = Instant::now();
                let rest: Vec<&str> = asked.iter().skip(index).map(|(name, _)| name.as_str()).collect();
                tracing::warn!("not active yet, or not asked yet: {}", rest.join(", "));
            }
            sleep(PAUSE).await;
        }
    }
}
