//! Services of managed nodes, package `lifecycle_msgs`.

use crate::definition::{Definition, RosService, RosType};
use crate::lifecycle::{State, Transition, TransitionDescription};
use serde::{Deserialize, Serialize};

/// Request of [`ChangeState`].
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ChangeStateRequest {
    /// The step.
    pub transition: Transition,
}

/// Response of [`ChangeState`].
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ChangeStateResponse {
    /// Whether it was taken to its end.
    pub success: bool,
}

/// Asks for a transition.
#[derive(Debug, Clone, Copy)]
pub struct ChangeState;

impl RosService for ChangeState {
    type Request = ChangeStateRequest;
    type Response = ChangeStateResponse;
    const PACKAGE: &'static str = "lifecycle_msgs";
    const NAME: &'static str = "ChangeState";
    const TEXT: &'static str = include_str!("../standard/lifecycle_msgs/ChangeState.srv");
    const DEPENDENCIES: &'static [&'static Definition] = &[&Transition::DEFINITION];
}

/// Request of [`GetState`].
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct GetStateRequest {
    /// An empty structure is one byte on the wire.
    pub structure_needs_at_least_one_member: u8,
}

/// Response of [`GetState`].
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct GetStateResponse {
    /// The state now.
    pub current_state: State,
}

/// Asks for the state.
#[derive(Debug, Clone, Copy)]
pub struct GetState;

impl RosService for GetState {
    type Request = GetStateRequest;
    type Response = GetStateResponse;
    const PACKAGE: &'static str = "lifecycle_msgs";
    const NAME: &'static str = "GetState";
    const TEXT: &'static str = include_str!("../standard/lifecycle_msgs/GetState.srv");
    const DEPENDENCIES: &'static [&'static Definition] = &[&State::DEFINITION];
}

/// Request of [`GetAvailableStates`].
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct GetAvailableStatesRequest {
    /// An empty structure is one byte on the wire.
    pub structure_needs_at_least_one_member: u8,
}

/// Response of [`GetAvailableStates`].
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct GetAvailableStatesResponse {
    /// Every state.
    pub available_states: Vec<State>,
}

/// Asks for all states.
#[derive(Debug, Clone, Copy)]
pub struct GetAvailableStates;

impl RosService for GetAvailableStates {
    type Request = GetAvailableStatesRequest;
    type Response = GetAvailableStatesResponse;
    const PACKAGE: &'static str = "lifecycle_msgs";
    const NAME: &'static str = "GetAvailableStates";
    const TEXT: &'static str = include_str!("../standard/lifecycle_msgs/GetAvailableStates.srv");
    const DEPENDENCIES: &'static [&'static Definition] = &[&State::DEFINITION];
}

/// Request of [`GetAvailableTransitions`].
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct GetAvailableTransitionsRequest {
    /// An empty structure is one byte on the wire.
    pub structure_needs_at_least_one_member: u8,
}

/// Response of [`GetAvailableTransitions`].
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct GetAvailableTransitionsResponse {
    /// Each with its two ends.
    pub available_transitions: Vec<TransitionDescription>,
}

/// Asks for transitions: those that can be taken now, or the whole graph.
#[derive(Debug, Clone, Copy)]
pub struct GetAvailableTransitions;

impl RosService for GetAvailableTransitions {
    type Request = GetAvailableTransitionsRequest;
    type Response = GetAvailableTransitionsResponse;
    const PACKAGE: &'static str = "lifecycle_msgs";
    const NAME: &'static str = "GetAvailableTransitions";
    const TEXT: &'static str = include_str!("../standard/lifecycle_msgs/GetAvailableTransitions.srv");
    const DEPENDENCIES: &'static [&'static Definition] =
        &[&TransitionDescription::DEFINITION, &Transition::DEFINITION, &State::DEFINITION];
}
