//! P7: the run-out switch sees no filament while the job runs.

use models::units::Seconds;

use crate::params::RunOutParams;

/// Watches the switch, with a debounce.
#[derive(Debug, Clone)]
pub struct RunOutCheck {
    params: RunOutParams,
    empty_since: Option<Seconds>,
}

impl RunOutCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: RunOutParams) -> Self {
        Self { params, empty_since: None }
    }

    /// Takes the switch; `None` where none is fitted.
    pub fn on_switch(&mut self, now: Seconds, present: Option<bool>) {
        self.empty_since = match present {
            Some(false) => self.empty_since.or(Some(now)),
            Some(true) | None => None,
        };
    }

    /// Forgets since when it has been away.
    pub fn reset(&mut self) {
        self.empty_since = None;
    }

    /// Whether the filament has been away for longer than the debounce.
    #[must_use]
    pub fn tripped(&self, now: Seconds) -> bool {
        self.empty_since.is_some_and(|since| now.0 - since.0 >= self.params.debounce_s)
    }
}
