//! The states of a managed node and the ways between them, as `rcl_lifecycle` has them. Knows no clock and no middleware.

use fdm_loop_msgs::{State, Transition, TransitionDescription};

/// A step that can be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Step {
    Configure,
    Cleanup,
    Activate,
    Deactivate,
    Shutdown,
}

/// How a step ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    Success,
    Failure,
    Error,
}

/// Every state with its name, in the order of `rcl_lifecycle`.
const STATES: [(u8, &str); 11] = [
    (State::UNKNOWN, "unknown"),
    (State::UNCONFIGURED, "unconfigured"),
    (State::INACTIVE, "inactive"),
    (State::ACTIVE, "active"),
    (State::FINALIZED, "finalized"),
    (State::CONFIGURING, "configuring"),
    (State::CLEANINGUP, "cleaningup"),
    (State::SHUTTINGDOWN, "shuttingdown"),
    (State::ACTIVATING, "activating"),
    (State::DEACTIVATING, "deactivating"),
    (State::ERRORPROCESSING, "errorprocessing"),
];

/// A way from one state to another.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Way {
    id: u8,
    label: &'static str,
    from: u8,
    to: u8,
}

const fn way(id: u8, label: &'static str, from: u8, to: u8) -> Way {
    Way { id, label, from, to }
}

const SUCCESS: &str = "transition_success";
const FAILURE: &str = "transition_failure";
const ERROR: &str = "transition_error";

/// Every way, in the order of `rcl_lifecycle`.
const WAYS: [Way; 25] = [
    way(Transition::CONFIGURE, "configure", State::UNCONFIGURED, State::CONFIGURING),
    way(Transition::ON_CONFIGURE_SUCCESS, SUCCESS, State::CONFIGURING, State::INACTIVE),
    way(Transition::ON_CONFIGURE_FAILURE, FAILURE, State::CONFIGURING, State::UNCONFIGURED),
    way(Transition::ON_CONFIGURE_ERROR, ERROR, State::CONFIGURING, State::ERRORPROCESSING),
    way(Transition::CLEANUP, "cleanup", State::INACTIVE, State::CLEANINGUP),
    way(Transition::ON_CLEANUP_SUCCESS, SUCCESS, State::CLEANINGUP, State::UNCONFIGURED),
    way(Transition::ON_CLEANUP_FAILURE, FAILURE, State::CLEANINGUP, State::INACTIVE),
    way(Transition::ON_CLEANUP_ERROR, ERROR, State::CLEANINGUP, State::ERRORPROCESSING),
    way(Transition::ACTIVATE, "activate", State::INACTIVE, State::ACTIVATING),
    way(Transition::ON_ACTIVATE_SUCCESS, SUCCESS, State::ACTIVATING, State::ACTIVE),
    way(Transition::ON_ACTIVATE_FAILURE, FAILURE, State::ACTIVATING, State::INACTIVE),
    way(Transition::ON_ACTIVATE_ERROR, ERROR, State::ACTIVATING, State::ERRORPROCESSING),
    way(Transition::DEACTIVATE, "deactivate", State::ACTIVE, State::DEACTIVATING),
    way(Transition::ON_DEACTIVATE_SUCCESS, SUCCESS, State::DEACTIVATING, State::INACTIVE),
    way(Transition::ON_DEACTIVATE_FAILURE, FAILURE, State::DEACTIVATING, State::ACTIVE),
    way(Transition::ON_DEACTIVATE_ERROR, ERROR, State::DEACTIVATING, State::ERRORPROCESSING),
    way(Transition::UNCONFIGURED_SHUTDOWN, "shutdown", State::UNCONFIGURED, State::SHUTTINGDOWN),
    way(Transition::INACTIVE_SHUTDOWN, "shutdown", State::INACTIVE, State::SHUTTINGDOWN),
    way(Transition::ACTIVE_SHUTDOWN, "shutdown", State::ACTIVE, State::SHUTTINGDOWN),
    way(Transition::ON_SHUTDOWN_SUCCESS, SUCCESS, State::SHUTTINGDOWN, State::FINALIZED),
    way(Transition::ON_SHUTDOWN_FAILURE, FAILURE, State::SHUTTINGDOWN, State::FINALIZED),
    way(Transition::ON_SHUTDOWN_ERROR, ERROR, State::SHUTTINGDOWN, State::ERRORPROCESSING),
    way(Transition::ON_ERROR_SUCCESS, SUCCESS, State::ERRORPROCESSING, State::UNCONFIGURED),
    way(Transition::ON_ERROR_FAILURE, FAILURE, State::ERRORPROCESSING, State::FINALIZED),
    way(Transition::ON_ERROR_ERROR, ERROR, State::ERRORPROCESSING, State::FINALIZED),
];

/// Where a node stands.
#[derive(Debug)]
pub(crate) struct Machine {
    state: u8,
}

impl Default for Machine {
    fn default() -> Self {
        Self { state: State::UNCONFIGURED }
    }
}

impl Machine {
    /// The state now.
    pub(crate) fn state(&self) -> State {
        named(self.state)
    }

    /// Every state.
    pub(crate) fn states() -> Vec<State> {
        STATES.iter().map(|(id, _)| named(*id)).collect()
    }

    /// Every way there is.
    pub(crate) fn graph() -> Vec<TransitionDescription> {
        WAYS.iter().map(Way::description).collect()
    }

    /// The ways from here.
    pub(crate) fn available(&self) -> Vec<TransitionDescription> {
        WAYS.iter().filter(|way| way.from == self.state).map(Way::description).collect()
    }

    /// Takes a step that is asked for by number, or by name where the number is 0. `None`: not from here.
    pub(crate) fn request(&mut self, asked: &Transition) -> Option<(Step, TransitionDescription)> {
        let is_asked = |way: &&Way| if asked.id == 0 { way.label == asked.label } else { way.id == asked.id };
        let way = WAYS.iter().filter(|way| way.from == self.state).find(is_asked)?;
        let step = step(way.id)?;
        self.state = way.to;
        Some((step, way.description()))
    }

    /// Takes a step that the node wants itself.
    pub(crate) fn begin(&mut self, step: Step) -> Option<TransitionDescription> {
        let label = match step {
            Step::Configure => "configure",
            Step::Cleanup => "cleanup",
            Step::Activate => "activate",
            Step::Deactivate => "deactivate",
            Step::Shutdown => "shutdown",
        };
        self.request(&Transition { id: 0, label: label.to_owned() }).map(|(_, way)| way)
    }

    /// Ends the step that is under way. `None`: none is.
    pub(crate) fn finish(&mut self, outcome: Outcome) -> Option<TransitionDescription> {
        let label = match outcome {
            Outcome::Success => SUCCESS,
            Outcome::Failure => FAILURE,
            Outcome::Error => ERROR,
        };
        let way = WAYS.iter().find(|way| way.from == self.state && way.label == label)?;
        self.state = way.to;
        Some(way.description())
    }
}

impl Way {
    fn description(&self) -> TransitionDescription {
        TransitionDescription {
            transition: Transition { id: self.id, label: self.label.to_owned() },
            start_state: named(self.from),
            goal_state: named(self.to),
        }
    }
}

/// A state with its name.
fn named(id: u8) -> State {
    let label = STATES.iter().find(|(known, _)| *known == id).map_or("unknown", |(_, label)| label);
    State { id, label: label.to_owned() }
}

/// What a number asks for; only the first steps can be asked for, not their ends.
fn step(id: u8) -> Option<Step> {
    match id {
        Transition::CONFIGURE => Some(Step::Configure),
        Transition::CLEANUP => Some(Step::Cleanup),
        Transition::ACTIVATE => Some(Step::Activate),
        Transition::DEACTIVATE => Some(Step::Deactivate),
        Transition::UNCONFIGURED_SHUTDOWN | Transition::INACTIVE_SHUTDOWN | Transition::ACTIVE_SHUTDOWN => {
            Some(Step::Shutdown)
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests;
