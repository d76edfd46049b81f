//! The quality of service that a topic of a bag was offered with, as the recorders of ROS 2 write it.

use runtime::qos::{Durability, End, Reliability};

/// Depth of a topic whose quality of service the bag does not say.
const DEPTH: usize = 10;

/// The first of the profiles in a text, in words (since Iron) or in the numbers of `rmw`; where it says nothing, what
/// most topics have.
pub(crate) fn offered(text: &str) -> End {
    let value = |key: &str| {
        text.lines().find_map(|line| line.trim().trim_start_matches("- ").strip_prefix(key)).map(str::trim)
    };
    let says = |key: &str, words: [&str; 2]| value(key).is_some_and(|value| words.contains(&value));
    End {
        reliability: match says("reliability:", ["best_effort", "2"]) {
            true => Reliability::BestEffort,
            false => Reliability::Reliable,
        },
        durability: match says("durability:", ["transient_local", "1"]) {
            true => Durability::TransientLocal,
            false => Durability::Volatile,
        },
        depth: value("depth:").and_then(|depth| depth.parse().ok()).unwrap_or(DEPTH).clamp(1, 1000),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Reliability, Durability, usize) {
        let End { reliability, durability, depth } = offered(text);
        (reliability, durability, depth)
    }

    #[test]
    fn quality_of_service_is_read_as_our_recorder_writes_it() {
        let written =
            bag_recorder::offered_qos::OfferedQos { reliable: false, transient_local: true, depth: 7 };
        assert_eq!(read(&written.text()), (Reliability::BestEffort, Durability::TransientLocal, 7));
        assert_eq!(read(""), (Reliability::Reliable, Durability::Volatile, DEPTH));
    }

    /// Humble writes the numbers of `rmw`: a latched topic stays one.
    #[test]
    fn quality_of_service_is_read_as_older_recorders_write_it() {
        let latched =
            "- history: 3\n  depth: 0\n  reliability: 1\n  durability: 1\n  deadline:\n    sec: 2147483647";
        assert_eq!(read(latched), (Reliability::Reliable, Durability::TransientLocal, 1));
        let sensor = "- history: 1\n  depth: 5\n  reliability: 2\n  durability: 2";
        assert_eq!(read(sensor), (Reliability::BestEffort, Durability::Volatile, 5));
    }
}
