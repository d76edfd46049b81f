//! The state that services and driver share; each change is told on `transition_event`.

use super::machine::{Machine, Outcome, Step};
use crate::clock::Clock;
use crate::diagnostics::Diagnostics;
use crate::publisher::Publisher;
use fdm_loop_msgs::{State, Transition, TransitionDescription, TransitionEvent};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The life of one node; clones are one.
#[derive(Clone)]
pub(crate) struct Life(Arc<Mutex<Inner>>);

struct Inner {
    machine: Machine,
    /// `None` in a node that nobody manages.
    told: Option<Told>,
}

/// Who hears of changes.
struct Told {
    events: Publisher<TransitionEvent>,
    clock: Clock,
    diagnostics: Diagnostics,
}

/// Nanoseconds in a second.
const NANOS_PER_S: f64 = 1e9;

impl Default for Life {
    fn default() -> Self {
        Self(Arc::new(Mutex::new(Inner { machine: Machine::default(), told: None })))
    }
}

impl Life {
    /// Tells every change from now on.
    pub(crate) fn tell(&self, events: Publisher<TransitionEvent>, clock: Clock, diagnostics: Diagnostics) {
        self.inner().told = Some(Told { events, clock, diagnostics });
    }

    /// The state now; `None` for a node that nobody manages.
    pub(crate) fn managed_state(&self) -> Option<State> {
        let inner = self.inner();
        inner.told.as_ref().map(|_| inner.machine.state())
    }

    /// The state now.
    pub(crate) fn state(&self) -> State {
        self.inner().machine.state()
    }

    /// The ways from here.
    pub(crate) fn available(&self) -> Vec<TransitionDescription> {
        self.inner().machine.available()
    }

    /// Begins a step that somebody asks for; `None` where it cannot be taken from here.
    pub(crate) fn request(&self, asked: &Transition) -> Option<Step> {
        let mut inner = self.inner();
        let (step, way) = inner.machine.request(asked)?;
        inner.told(way);
        Some(step)
    }

    /// Begins a step of the node's own; false where it cannot be taken from here.
    pub(crate) fn begin(&self, step: Step) -> bool {
        let mut inner = self.inner();
        let way = inner.machine.begin(step);
        let begun = way.is_some();
        way.into_iter().for_each(|way| inner.told(way));
        begun
    }

    /// Ends the step under way. After an error the node is back at the start.
    pub(crate) fn finish(&self, outcome: Outcome) {
        let mut inner = self.inner();
        if let Some(way) = inner.machine.finish(outcome) {
            inner.told(way);
        }
        if outcome == Outcome::Error
            && let Some(way) = inner.machine.finish(Outcome::Success)
        {
            inner.told(way);
        }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inner {
    fn told(&self, way: TransitionDescription) {
        let Some(Told { events, clock, diagnostics }) = &self.told else { return };
        diagnostics.set("lifecycle", &way.goal_state.label);
        tracing::info!("{} -> {}", way.start_state.label, way.goal_state.label);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "time since the clock's epoch"
        )]
        let timestamp = (clock.stamp().0 * NANOS_PER_S) as u64;
        let TransitionDescription { transition, start_state, goal_state } = way;
        events.send(TransitionEvent { timestamp, transition, start_state, goal_state });
    }
}
