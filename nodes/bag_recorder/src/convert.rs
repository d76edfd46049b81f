//! Between the graph's types and the bag's.

use crate::clock::{CLOCK, MONOTONIC, SIMULATED};
use crate::contents::Channel;
use crate::offered_qos::OfferedQos;
use crate::params::Params;
use crate::writer::Recorded;
use fdm_loop_msgs::PrintInfo;
use runtime::Node;
use runtime::qos::{self, Durability, Reliability};
use runtime::topics::TopicInfo;
use std::collections::BTreeMap;
use std::time::{SystemTime, UNIX_EPOCH};

/// Version and commit of this program.
fn build() -> String {
    let commit = option_env!("FDM_LOOP_COMMIT").unwrap_or("unknown");
    format!("{} {commit}", env!("CARGO_PKG_VERSION"))
}

/// How a topic stands in a bag; `resolved` is its name on the graph.
pub fn recorded(resolved: String, topic: &TopicInfo) -> Recorded {
    let offered = topic.qos.offered;
    let qos = OfferedQos {
        reliable: offered.reliability == Reliability::Reliable,
        transient_local: offered.durability == Durability::TransientLocal,
        depth: offered.depth,
    };
    let channel =
        Channel { topic: resolved, type_name: topic.definition.full_name(), offered_qos: qos.text() };
    Recorded { channel, schema: topic.definition.schema_text() }
}

/// The topic as the recorder asks for it: all that is offered, and deep enough for a busy moment. But a reliable reader
/// that stands still fills its publishers' send windows, and where these are short (commands, sensors) or full within
/// seconds (bursts of sensors) the others would lose messages for the recorder's sake: those topics are asked for best
/// effort.
pub(crate) fn requested(topic: &TopicInfo, params: &Params) -> TopicInfo {
    let mut asked = *topic;
    let latched = topic.qos.offered.durability == Durability::TransientLocal;
    let soon_full = topic.qos.offered.depth < params.window_min || topic.qos == qos::SENSOR_BURSTS;
    if !latched && soon_full {
        asked.qos.requested.reliability = Reliability::BestEffort;
    }
    // The middleware keeps as many, taken or not: a thousand pictures are 0.1 GB.
    let depth =
        if are_pictures(&topic.definition.full_name()) { params.image_depth } else { params.reader_depth };
    asked.qos.requested.depth = depth.max(topic.qos.requested.depth);
    asked
}

/// Whether messages of this type are pictures.
pub(crate) fn are_pictures(type_name: &str) -> bool {
    type_name.ends_with("/CompressedImage")
}

/// What a `fdm_loop` record says of the recorder. Log times count from the host's start, or from the simulation's: the
/// wall time at the start dates them.
pub(crate) fn note_of_run(node: &Node) -> BTreeMap<String, String> {
    let parameters = node.raw_parameters();
    let wall_ns = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
    let clock = node.clock();
    let kind = if clock.is_simulated() { SIMULATED } else { MONOTONIC };
    text([
        ("recorder_build", build()),
        ("recorder_parameters", parameters.text()),
        ("recorder_parameters_sha256", parameters.sha256()),
        (CLOCK, kind.to_owned()),
        ("start_clock_s", clock.now().0.to_string()),
        ("start_wall_ns", wall_ns.to_string()),
    ])
}

/// What it says of the print.
pub(crate) fn note_of_print(info: &PrintInfo) -> BTreeMap<String, String> {
    text([
        ("print_id", info.print_id.clone()),
        ("gcode_file", info.gcode_file.clone()),
        ("gcode_sha256", info.gcode_sha256.clone()),
        ("config", info.config.clone()),
        ("config_sha256", info.config_sha256.clone()),
        ("build", info.build.clone()),
        ("scenario", info.scenario.clone()),
    ])
}

fn text<const N: usize>(pairs: [(&str, String); N]) -> BTreeMap<String, String> {
    pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// Number of a message as MCAP holds it: modulo 2^32.
pub(crate) fn sequence(number: i64) -> u32 {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // the low half is what is wanted
    let low = number as u32;
    low
}
