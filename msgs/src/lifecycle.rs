//! Messages and services of managed nodes, package `lifecycle_msgs`.

use crate::definition::{Definition, RosType};
use serde::{Deserialize, Serialize};

/// Where a managed node stands in its life.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct State {
    /// One of the constants.
    pub id: u8,
    /// Its name.
    pub label: String,
}

impl State {
    /// `PRIMARY_STATE_UNKNOWN` of the definition.
    pub const UNKNOWN: u8 = 0;
    /// `PRIMARY_STATE_UNCONFIGURED` of the definition.
    pub const UNCONFIGURED: u8 = 1;
    /// `PRIMARY_STATE_INACTIVE` of the definition.
    pub const INACTIVE: u8 = 2;
    /// `PRIMARY_STATE_ACTIVE` of the definition.
    pub const ACTIVE: u8 = 3;
    /// `PRIMARY_STATE_FINALIZED` of the definition.
    pub const FINALIZED: u8 = 4;
    /// `TRANSITION_STATE_CONFIGURING` of the definition.
    pub const CONFIGURING: u8 = 10;
    /// `TRANSITION_STATE_CLEANINGUP` of the definition.
    pub const CLEANINGUP: u8 = 11;
    /// `TRANSITION_STATE_SHUTTINGDOWN` of the definition.
    pub const SHUTTINGDOWN: u8 = 12;
    /// `TRANSITION_STATE_ACTIVATING` of the definition.
    pub const ACTIVATING: u8 = 13;
    /// `TRANSITION_STATE_DEACTIVATING` of the definition.
    pub const DEACTIVATING: u8 = 14;
    /// `TRANSITION_STATE_ERRORPROCESSING` of the definition.
    pub const ERRORPROCESSING: u8 = 15;
}

impl RosType for State {
    const DEFINITION: Definition = Definition {
        package: "lifecycle_msgs",
        name: "State",
        text: include_str!("../standard/lifecycle_msgs/State.msg"),
        dependencies: &[],
    };
}

/// A step in the life of a managed node.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Transition {
    /// One of the constants; 0 in a request: the label counts.
    pub id: u8,
    /// Its name.
    pub label: String,
}

impl Transition {
    /// `TRANSITION_CREATE` of the definition.
    pub const CREATE: u8 = 0;
    /// `TRANSITION_CONFIGURE` of the definition.
    pub const CONFIGURE: u8 = 1;
    /// `TRANSITION_CLEANUP` of the definition.
    pub const CLEANUP: u8 = 2;
    /// `TRANSITION_ACTIVATE` of the definition.
    pub const ACTIVATE: u8 = 3;
    /// `TRANSITION_DEACTIVATE` of the definition.
    pub const DEACTIVATE: u8 = 4;
    /// `TRANSITION_UNCONFIGURED_SHUTDOWN` of the definition.
    pub const UNCONFIGURED_SHUTDOWN: u8 = 5;
    /// `TRANSITION_INACTIVE_SHUTDOWN` of the definition.
    pub const INACTIVE_SHUTDOWN: u8 = 6;
    /// `TRANSITION_ACTIVE_SHUTDOWN` of the definition.
    pub const ACTIVE_SHUTDOWN: u8 = 7;
    /// `TRANSITION_DESTROY` of the definition.
    pub const DESTROY: u8 = 8;
    /// `TRANSITION_ON_CONFIGURE_SUCCESS` of the definition.
    pub const ON_CONFIGURE_SUCCESS: u8 = 10;
    /// `TRANSITION_ON_CONFIGURE_FAILURE` of the definition.
    pub const ON_CONFIGURE_FAILURE: u8 = 11;
    /// `TRANSITION_ON_CONFIGURE_ERROR` of the definition.
    pub const ON_CONFIGURE_ERROR: u8 = 12;
    /// `TRANSITION_ON_CLEANUP_SUCCESS` of the definition.
    pub const ON_CLEANUP_SUCCESS: u8 = 20;
    /// `TRANSITION_ON_CLEANUP_FAILURE` of the definition.
    pub const ON_CLEANUP_FAILURE: u8 = 21;
    /// `TRANSITION_ON_CLEANUP_ERROR` of the definition.
    pub const ON_CLEANUP_ERROR: u8 = 22;
    /// `TRANSITION_ON_ACTIVATE_SUCCESS` of the definition.
    pub const ON_ACTIVATE_SUCCESS: u8 = 30;
    /// `TRANSITION_ON_ACTIVATE_FAILURE` of the definition.
    pub const ON_ACTIVATE_FAILURE: u8 = 31;
    /// `TRANSITION_ON_ACTIVATE_ERROR` of the definition.
    pub const ON_ACTIVATE_ERROR: u8 = 32;
    /// `TRANSITION_ON_DEACTIVATE_SUCCESS` of the definition.
    pub const ON_DEACTIVATE_SUCCESS: u8 = 40;
    /// `TRANSITION_ON_DEACTIVATE_FAILURE` of the definition.
    pub const ON_DEACTIVATE_FAILURE: u8 = 41;
    /// `TRANSITION_ON_DEACTIVATE_ERROR` of the definition.
    pub const ON_DEACTIVATE_ERROR: u8 = 42;
    /// `TRANSITION_ON_SHUTDOWN_SUCCESS` of the definition.
    pub const ON_SHUTDOWN_SUCCESS: u8 = 50;
    /// `TRANSITION_ON_SHUTDOWN_FAILURE` of the definition.
    pub const ON_SHUTDOWN_FAILURE: u8 = 51;
    /// `TRANSITION_ON_SHUTDOWN_ERROR` of the definition.
    pub const ON_SHUTDOWN_ERROR: u8 = 52;
    /// `TRANSITION_ON_ERROR_SUCCESS` of the definition.
    pub const ON_ERROR_SUCCESS: u8 = 60;
    /// `TRANSITION_ON_ERROR_FAILURE` of the definition.
    pub const ON_ERROR_FAILURE: u8 = 61;
    /// `TRANSITION_ON_ERROR_ERROR` of the definition.
    pub const ON_ERROR_ERROR: u8 = 62;
    /// `TRANSITION_CALLBACK_SUCCESS` of the definition.
    pub const CALLBACK_SUCCESS: u8 = 97;
    /// `TRANSITION_CALLBACK_FAILURE` of the definition.
    pub const CALLBACK_FAILURE: u8 = 98;
    /// `TRANSITION_CALLBACK_ERROR` of the definition.
    pub const CALLBACK_ERROR: u8 = 99;
}

impl RosType for Transition {
    const DEFINITION: Definition = Definition {
        package: "lifecycle_msgs",
        name: "Transition",
        text: include_str!("../standard/lifecycle_msgs/Transition.msg"),
        dependencies: &[],
    };
}

/// A transition with its two ends.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct TransitionDescription {
    /// The step.
    pub transition: Transition,
    /// From here.
    pub start_state: State,
    /// To there.
    pub goal_state: State,
}

impl RosType for TransitionDescription {
    const DEFINITION: Definition = Definition {
        package: "lifecycle_msgs",
        name: "TransitionDescription",
        text: include_str!("../standard/lifecycle_msgs/TransitionDescription.msg"),
        dependencies: &[&Transition::DEFINITION, &State::DEFINITION],
    };
}

/// A transition that took place.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct TransitionEvent {
    /// When, on the node's clock `[ns]`.
    pub timestamp: u64,
    /// The step.
    pub transition: Transition,
    /// From here.
    pub start_state: State,
    /// To there.
    pub goal_state: State,
}

impl RosType for TransitionEvent {
    const DEFINITION: Definition = Definition {
        package: "lifecycle_msgs",
        name: "TransitionEvent",
        text: include_str!("../standard/lifecycle_msgs/TransitionEvent.msg"),
        dependencies: &[&Transition::DEFINITION, &State::DEFINITION],
    };
}
