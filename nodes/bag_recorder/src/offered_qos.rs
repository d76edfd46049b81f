//! Quality of service as `rosbag2` writes it since Jazzy: a YAML list of one profile, names in words.
//!
//! The same text stands in the metadata of each channel (`offered_qos_profiles`) and, indented, in `metadata.yaml`.
//! Readers match the two: where they differ, `rosbags` reads 0 messages without an error.

/// The part of a publisher's offer that is ours to choose; the rest is the default of DDS.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OfferedQos {
    /// Lost samples are sent again.
    pub reliable: bool,
    /// The newest samples are kept for late joiners.
    pub transient_local: bool,
    /// Samples kept (`keep_last`).
    pub depth: usize,
}

/// What `rmw` writes for a time without limit.
const INFINITE: &str = "\n    sec: 9223372036\n    nsec: 854775807";

impl OfferedQos {
    /// The YAML list.
    #[must_use]
    pub fn text(&self) -> String {
        let reliability = if self.reliable { "reliable" } else { "best_effort" };
        let durability = if self.transient_local { "transient_local" } else { "volatile" };
        let depth = self.depth;
        format!(
            "- history: keep_last\n  depth: {depth}\n  reliability: {reliability}\n  durability: {durability}\n  \
             deadline:{INFINITE}\n  lifespan:{INFINITE}\n  liveliness: automatic\n  \
             liveliness_lease_duration:{INFINITE}\n  avoid_ros_namespace_conventions: false"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_latched_topic_in_words() {
        let text = OfferedQos { reliable: true, transient_local: true, depth: 1 }.text();
        let expected = "\
- history: keep_last
  depth: 1
  reliability: reliable
  durability: transient_local
  deadline:
    sec: 9223372036
    nsec: 854775807
  lifespan:
    sec: 9223372036
    nsec: 854775807
  liveliness: automatic
  liveliness_lease_duration:
    sec: 9223372036
    nsec: 854775807
  avoid_ros_namespace_conventions: false";
        assert_eq!(text, expected);
    }
}
