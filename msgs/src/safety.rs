//! Supervision. The definitions in `msg/` and `srv/` are the truth.

use crate::definition::{Definition, RosService, RosType};
use crate::standard::Header;
use serde::{Deserialize, Serialize};

/// What the supervisor decided, why, and what a person can do (topic safety/state, latched).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SafetyState {
    /// stamp [s]: time of publication on the node's clock
    pub header: Header,
    /// Random id of the supervisor's run.
    pub session_id: u64,
    /// Counts up within a session: a late joiner keeps the highest.
    pub sequence: u64,
    /// One of MODE_*. Range `[0, 7]`.
    pub mode: u8,
    /// Mode as set by a person: observe, advise or act. Range `[1, 3]`.
    pub set_mode: u8,
    /// One of ATTENTION_*. Range `[0, 2]`.
    pub attention: u8,
    /// Fault ID and value that led to the mode; empty in a mode as set.
    pub cause: String,
    /// Time the mode was entered, on the node's clock `[s]`. Range `[0, inf)`.
    pub since_s: f64,
    /// Next step for a person; empty where nothing is to be done.
    pub what_to_do: String,
    /// The mode ends only by safety/acknowledge.
    pub latched: bool,
    /// Messages refused for NaN or infinity since start.
    pub refused_not_finite: u64,
    /// Messages refused for a value outside its range since start.
    pub refused_out_of_range: u64,
    /// Messages refused as older than their validity since start.
    pub refused_stale: u64,
    /// Messages refused as out of order or from a second publisher since start.
    pub refused_sequence: u64,
    /// Commands that had to be clamped since start.
    pub clamped: u64,
}

impl SafetyState {
    /// `MODE_INIT` of the definition.
    pub const MODE_INIT: u8 = 0;
    /// `MODE_OBSERVE` of the definition.
    pub const MODE_OBSERVE: u8 = 1;
    /// `MODE_ADVISE` of the definition.
    pub const MODE_ADVISE: u8 = 2;
    /// `MODE_ACT` of the definition.
    pub const MODE_ACT: u8 = 3;
    /// `MODE_DEGRADED` of the definition.
    pub const MODE_DEGRADED: u8 = 4;
    /// `MODE_PAUSED` of the definition.
    pub const MODE_PAUSED: u8 = 5;
    /// `MODE_SAFE_OFF` of the definition.
    pub const MODE_SAFE_OFF: u8 = 6;
    /// `MODE_ESTOP` of the definition.
    pub const MODE_ESTOP: u8 = 7;
    /// `ATTENTION_NORMAL` of the definition.
    pub const ATTENTION_NORMAL: u8 = 0;
    /// `ATTENTION_SOFT` of the definition.
    pub const ATTENTION_SOFT: u8 = 1;
    /// `ATTENTION_HARD` of the definition.
    pub const ATTENTION_HARD: u8 = 2;
}

impl RosType for SafetyState {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "SafetyState",
        text: include_str!("../msg/SafetyState.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// One decision or change worth a line in the print's log (topic events).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct PrintEvent {
    /// stamp [s]: time of the event on the node's clock
    pub header: Header,
    /// One of SEVERITY_*. Range `[0, 2]`.
    pub severity: u8,
    /// Node that decided.
    pub who: String,
    /// What changed, snake_case.
    pub what: String,
    /// Reason with the numbers it rests on.
    pub why: String,
    /// Value before, with its unit; empty where there was none.
    pub before: String,
    /// Value after, with its unit.
    pub after: String,
}

impl PrintEvent {
    /// `SEVERITY_INFO` of the definition.
    pub const SEVERITY_INFO: u8 = 0;
    /// `SEVERITY_WARN` of the definition.
    pub const SEVERITY_WARN: u8 = 1;
    /// `SEVERITY_ERROR` of the definition.
    pub const SEVERITY_ERROR: u8 = 2;
}

impl RosType for PrintEvent {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "PrintEvent",
        text: include_str!("../msg/PrintEvent.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// Proof of work of a node (topic heartbeat): an alive process whose work counter stands still hangs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Heartbeat {
    /// stamp [s]: time of sending on the node's clock
    pub header: Header,
    /// Fully qualified name of the node.
    pub node: String,
    /// Random id of the node's run: another one tells a restart.
    pub session_id: u64,
    /// Counts up by one per heartbeat.
    pub sequence: u64,
    /// Units of work done since start.
    pub work_counter: u64,
    /// False until the first own message came back through DDS.
    pub self_loop_established: bool,
    /// Age of the newest own message that came back `[s]`. Range `[0, inf)`; invalid where
    /// self_loop_established is false.
    pub self_loop_age_s: f64,
}

impl RosType for Heartbeat {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "Heartbeat",
        text: include_str!("../msg/Heartbeat.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// Sets the mode of the supervisor (service safety/set_mode): the request.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SetModeRequest {
    /// Wanted mode, one of MODE_*. Range `[1, 3]`.
    pub mode: u8,
}

impl SetModeRequest {
    /// `MODE_OBSERVE` of the definition.
    pub const MODE_OBSERVE: u8 = 1;
    /// `MODE_ADVISE` of the definition.
    pub const MODE_ADVISE: u8 = 2;
    /// `MODE_ACT` of the definition.
    pub const MODE_ACT: u8 = 3;
}

/// Answer of [`SetMode`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SetModeResponse {
    /// The mode is set.
    pub accepted: bool,
    /// The mode in force, or the reason of the refusal.
    pub message: String,
}

/// Sets the mode of the supervisor (service safety/set_mode).
#[derive(Debug, Clone, Copy)]
pub struct SetMode;

impl RosService for SetMode {
    type Request = SetModeRequest;
    type Response = SetModeResponse;
    const PACKAGE: &'static str = "fdm_loop_msgs";
    const NAME: &'static str = "SetMode";
    const TEXT: &'static str = include_str!("../srv/SetMode.srv");
}
