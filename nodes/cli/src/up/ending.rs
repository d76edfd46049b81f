//! The orderly end of all node processes, the recorder last, in the 2 s that a person waits after Ctrl-C.

use super::fleet::Fleet;
use crate::output;
use models::units::Seconds;
use runtime::Node;

/// Who ends last: what the others say at their end belongs into the bag.
const LAST: Option<&str> = Some("bag_recorder");
/// How often processes are looked at `[s]`.
const LOOK_S: f64 = 0.02;
/// After this time the recorder is asked to end whether the others have or not `[s]`. They take 0.2 s on a busy host; what is
/// said after that nobody waits for.
const NODES_END_S: f64 = 0.3;
/// Longest time until all have ended `[s]`. `fdm` is a node too, and ends 1.7 s after Ctrl-C whatever it waits for: before
/// that it has to close what a recorder leaves that was ended by force.
const END_S: f64 = 1.4;

/// Ends the nodes in order, by force what does not end by itself. `node` is who waits for them.
pub(crate) async fn end(fleet: &mut Fleet, node: &Node) {
    let (clock, mut ticks) = (node.clock(), node.timer(Seconds(LOOK_S)));
    let asked = clock.now();
    for (except, until_s) in [(LAST, NODES_END_S), (None, END_S)] {
        fleet.ask_to_end(except);
        while !fleet.all_ended(except) && (clock.now() - asked).0 < until_s {
            _ = ticks.next().await;
        }
    }
    for name in fleet.kill_rest(None) {
        output::note(&format!("{name} did not end in {END_S} s and was killed"));
    }
}
