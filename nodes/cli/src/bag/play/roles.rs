//! Which topics of a bag another graph would obey, and which it takes in.

use runtime::topics;

/// What a printer obeys.
pub(super) const OBEYED: [&str; 4] = [
    topics::SAFETY_COMMAND.name(),
    topics::CONTROL_COMMAND.name(),
    topics::SAFETY_SCHEDULE.name(),
    topics::CONTROL_SCHEDULE.name(),
];
/// What printer and sensors say, and what is known of the print.
pub(super) const INPUTS: [&str; 9] = [
    "sensors/",
    "printer/state",
    "printer/motion",
    "printer/coming",
    "printer/report/",
    "sim/truth/",
    "print/info",
    "tf_static",
    "tf",
];
