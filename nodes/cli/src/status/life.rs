//! Who of a graph is there without a heartbeat, and in which state those are that have one.

use super::Seen;
use crate::up::recipes::{FORESIGHT, NODES};
use fdm_loop_msgs::{GetStateRequest, State};
use models::units::Seconds;
use runtime::{CallError, Node, RuntimeError, topics};
use std::collections::{BTreeMap, BTreeSet};

/// Time for all states to be told `[s]`; each is asked at the same time.
const ANSWERED_S: f64 = 1.0;
/// Who stands in the simulated printer's place.
const BRIDGE: &str = "printer_bridge";
const SIMULATED: &str = "printer_sim";

/// The states that those tell that are heard, and whether nobody answered who should.
pub(super) async fn states(
    node: &mut Node,
    heard: &mut BTreeMap<String, Seen>,
) -> Result<bool, RuntimeError> {
    let names: Vec<String> = heard.keys().cloned().collect();
    let asked =
        names.iter().map(|name| node.client_of(name, &topics::GET_STATE)).collect::<Result<Vec<_>, _>>()?;
    let answers = futures::future::join_all(
        asked.iter().map(|client| client.call(GetStateRequest::default(), Seconds(ANSWERED_S))),
    )
    .await;
    let nobody = !answers.is_empty()
        && answers.iter().all(|answer| !matches!(answer, Ok(_) | Err(CallError::NoServer(_))));
    for (name, answer) in names.iter().zip(answers) {
        if let (Some(seen), Ok(answer)) = (heard.get_mut(name), answer) {
            seen.state = Some(word(answer.current_state));
        }
    }
    Ok(nobody)
}

/// A state for people.
fn word(state: State) -> String {
    if state.id == State::ACTIVE { "active".to_owned() } else { state.label }
}

/// Nodes of `namespace` whose heart is not heard: they publish, or the graph that is heard has them in all cases.
pub(super) fn silent(
    namespace: &str,
    heard: &BTreeMap<String, Seen>,
    published: &BTreeSet<String>,
) -> Vec<String> {
    let base = namespace.trim_end_matches('/');
    let path = |name: &str| format!("{base}/{name}");
    // `~/transition_event`: every node of ours has it.
    let on_graph = published.iter().filter_map(|topic| topic.strip_suffix("/transition_event"));
    let on_graph = on_graph.filter(|node| node.rsplit_once('/').is_some_and(|(of, _)| of == base));
    let of_graph =
        |name: &&str| *name != FORESIGHT && !(*name == SIMULATED && heard.contains_key(&path(BRIDGE)));
    // A part of it may have been started for itself; more than half is the whole, and misses who is not heard.
    let fleet = NODES.iter().filter(|name| heard.contains_key(&path(name))).count() * 2 > NODES.len();
    let expected = NODES.iter().copied().filter(|name| fleet && of_graph(name)).map(path);
    let all: BTreeSet<String> = on_graph.map(str::to_owned).chain(expected).collect();
    all.into_iter().filter(|node| !heard.contains_key(node)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(names: &[&str]) -> BTreeMap<String, Seen> {
        names.iter().map(|name| (format!("/a/{name}"), Seen::default())).collect()
    }

    fn published(topics: &[&str]) -> BTreeSet<String> {
        topics.iter().map(|topic| (*topic).to_owned()).collect()
    }

    /// A node whose loop hangs is still on the graph; of another namespace it is another's.
    #[test]
    fn who_publishes_and_does_not_beat_is_silent() {
        let topics = ["/a/imu/transition_event", "/a/camera/transition_event", "/b/imu/transition_event"];
        assert_eq!(silent("/a", &heard(&["imu"]), &published(&topics)), ["/a/camera"]);
        assert_eq!(silent("/b/", &heard(&["imu"]), &published(&topics)), ["/b/imu"]);
    }

    /// A process that was stopped announces nothing to who comes later: the others tell that it should be there.
    #[test]
    fn who_is_missing_from_a_graph_is_silent() {
        let all: Vec<&str> = NODES.into_iter().filter(|name| *name != FORESIGHT).collect();
        let but =
            |missing: &str| heard(&all.iter().copied().filter(|name| *name != missing).collect::<Vec<_>>());
        assert!(silent("/a", &but(""), &published(&[])).is_empty());
        assert_eq!(silent("/a", &but("mpc_controller"), &published(&[])), ["/a/mpc_controller"]);
        assert!(silent("/a", &heard(&["imu", "camera"]), &published(&[])).is_empty(), "two for themselves");
        let mut real = but(SIMULATED);
        real.insert("/a/printer_bridge".to_owned(), Seen::default());
        assert!(silent("/a", &real, &published(&[])).is_empty());
    }
}
