//! Quality of service, both ends in one value, so that two nodes cannot disagree.
//!
//! A reliable publisher of RustDDS 0.15.1 holds up to 8192 samples that a reliable subscriber has not acknowledged,
//! whatever its depth, and then refuses the next one for all. A killed subscriber counts until its lease ends, up to a
//! minute later: a reliable topic must stay below 136 messages a second of real time.

use ros2_client::QosProfile;
use ros2_client::qos::{Durability as RosDurability, History, Reliability as RosReliability, WhenFull};

/// Whether lost samples are sent again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reliability {
    /// Lost samples stay lost.
    BestEffort,
    /// Lost samples are sent again; a full send window refuses the next one at once.
    Reliable,
}

/// Whether a late joiner gets what was sent before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Durability {
    /// Only what is sent while subscribed.
    Volatile,
    /// The last `depth` samples.
    TransientLocal,
}

/// One end of a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct End {
    /// Whether lost samples are sent again.
    pub reliability: Reliability,
    /// Whether a late joiner gets what was sent before.
    pub durability: Durability,
    /// Samples kept (`KEEP_LAST`).
    pub depth: usize,
}

impl End {
    /// The client's form. A publisher never waits for a slow reader: the window is full, the sample is dropped and
    /// counted (waiting starves the loop, and the client ignores the limit of its asynchronous form).
    pub(crate) fn profile(self) -> QosProfile {
        let profile = match self.reliability {
            Reliability::BestEffort => QosProfile::subscription_default().reliability_best_effort(),
            Reliability::Reliable => QosProfile::subscription_default()
                .reliability(RosReliability::Reliable { when_full: WhenFull::Fail }),
        };
        let durability = match self.durability {
            Durability::Volatile => RosDurability::Volatile,
            Durability::TransientLocal => RosDurability::TransientLocal,
        };
        profile.durability(durability).history(History::KeepLast { depth: self.depth })
    }
}

/// Both ends of a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Qos {
    /// What a publisher offers.
    pub offered: End,
    /// What a subscriber requests.
    pub requested: End,
}

/// A reliable, volatile end.
const fn reliable(depth: usize) -> End {
    End { reliability: Reliability::Reliable, durability: Durability::Volatile, depth }
}

/// A best effort, volatile end.
const fn best_effort(depth: usize) -> End {
    End { reliability: Reliability::BestEffort, durability: Durability::Volatile, depth }
}

/// A reliable end that keeps its newest sample for late joiners.
const fn transient_local(depth: usize) -> End {
    End { reliability: Reliability::Reliable, durability: Durability::TransientLocal, depth }
}

/// Raw samples: offered reliable, requested best effort (REP-2003), newest wins. The depth covers a subscriber that
/// is away for 0.1 s at 100 Hz.
pub const SENSOR: Qos = Qos { offered: reliable(10), requested: best_effort(10) };

/// Raw samples of which many come at once, as out of a device's own buffer. Where nobody asks for reliability RustDDS 0.15.1
/// forgets what is older than `depth` samples whether it was sent or not: the depth covers 0.5 s at 2 kHz.
pub const SENSOR_BURSTS: Qos = Qos { offered: reliable(1000), requested: best_effort(1000) };

/// What a printer's own hardware says, from its bridge to the sensor nodes beside it, which pass it on as [`SENSOR`]: nobody
/// else asks. Offered as it is requested: a reliable publisher of RustDDS 0.15.1 asks each subscriber of best effort ten times
/// a second for an acknowledgement that never comes.
pub const REPORT: Qos = Qos { offered: best_effort(10), requested: best_effort(10) };

/// Beats: two in a row may be lost before the supervisor misses anybody (`stale.hang_s`), five before the witness does, so
/// nobody acknowledges them, and nobody can: a reliable publisher of RustDDS 0.15.1 asks every subscriber ten times a second
/// for an acknowledgement that one of best effort never sends, and ten nodes that beat were asked for more than they said.
/// The depth covers ten nodes for 1 s.
pub const BEAT: Qos = Qos { offered: best_effort(100), requested: best_effort(100) };

/// Results of which none may be lost; the depth covers 1 s of short moves at 500 Hz and two times real time.
pub const RELIABLE: Qos = Qos { offered: reliable(1000), requested: reliable(1000) };

/// Commands: the newest counts, what is older than its validity is refused by the receiver. Requested best effort, so
/// that a receiver that was killed never holds up the stream to the others.
pub const COMMAND: Qos = Qos { offered: reliable(10), requested: best_effort(10) };

/// Trims of coming moves, of which many come at once where a host reads ahead. Requested best effort, as commands; one
/// that is lost leaves its move to the trims of the permit.
pub const SCHEDULE: Qos = Qos { offered: reliable(1000), requested: best_effort(1000) };

/// States that a late joiner must know. The client replays old samples too, oldest first: keep the highest sequence.
pub const LATCHED: Qos = Qos { offered: transient_local(1), requested: transient_local(1) };

/// Simulated time, both ends as `rclcpp::ClockQoS` has them.
pub const CLOCK: Qos = Qos { offered: best_effort(10), requested: best_effort(10) };

/// Diagnostics and log lines, as the ROS tools expect them.
pub const STANDARD: Qos = Qos { offered: reliable(100), requested: reliable(100) };

/// Log lines: `rclcpp` offers them transient local.
pub const ROSOUT: Qos = Qos { offered: transient_local(100), requested: reliable(100) };

/// Changes that a tool follows, as `rcl_lifecycle` offers them.
pub const EVENT: Qos = Qos { offered: reliable(10), requested: reliable(10) };

/// Service requests and replies.
pub(crate) const SERVICE: End = reliable(10);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topics::ALL;

    /// A subscriber that asks for more than is offered hears nothing.
    #[test]
    fn no_topic_asks_for_more_than_it_offers() {
        for topic in ALL {
            let Qos { offered, requested } = topic.qos;
            let reliable = |end: End| end.reliability == Reliability::Reliable;
            let keeps = |end: End| end.durability == Durability::TransientLocal;
            assert!(reliable(offered) || !reliable(requested), "{}", topic.name);
            assert!(keeps(offered) || !keeps(requested), "{}", topic.name);
        }
    }
}
