//! S7: a stream stops. Age counts from receipt on the node's clock.

use models::units::Seconds;

use crate::cause::Reaction;
use crate::params::StaleParams;

/// Watches the age of one stream.
#[derive(Debug, Clone)]
pub struct StaleCheck {
    params: StaleParams,
    newest: Option<Seconds>,
}

impl StaleCheck {
    /// A stream that has not been seen.
    #[must_use]
    pub fn new(params: StaleParams) -> Self {
        Self { params, newest: None }
    }

    /// Notes a message received at `now`.
    pub fn note(&mut self, now: Seconds) {
        self.newest = Some(now);
    }

    /// Whether any message came.
    #[must_use]
    pub fn is_seen(&self) -> bool {
        self.newest.is_some()
    }

    /// Starts the age of a stream that must come but has not.
    pub fn expect(&mut self, now: Seconds) {
        self.newest.get_or_insert(now);
    }

    /// Starts the age of a stream anew that has been heard before.
    pub fn restart(&mut self, now: Seconds) {
        self.newest = self.newest.map(|_| now);
    }

    /// Time in which the supervisor itself stood still does not count as silence of others; where the clock was set back,
    /// with a `gap` below zero, the age stays what it was. What came since is as old as it is.
    pub fn forgive(&mut self, now: Seconds, gap: Seconds) {
        self.newest = self.newest.map(|newest| match newest + gap {
            _ if gap < Seconds(0.0) && newest <= now => newest,
            later if later > now => now,
            moved => moved,
        });
    }

    /// Time since the newest message, or since it was due.
    #[must_use]
    pub fn age(&self, now: Seconds) -> Option<Seconds> {
        self.newest.map(|newest| now - newest)
    }

    /// The limit `[s]` that the age is beyond, the longest; `None` where it is beyond none.
    #[must_use]
    pub fn limit_s(&self, now: Seconds) -> Option<f64> {
        match self.reaction(now)? {
            Reaction::Degrade => Some(self.params.degraded_s),
            Reaction::Pause => self.params.pause_s,
            Reaction::SafeOff | Reaction::Estop => self.params.safe_off_s,
        }
    }

    /// What the age calls for.
    #[must_use]
    pub fn reaction(&self, now: Seconds) -> Option<Reaction> {
        let age_s = self.age(now)?.0;
        let beyond = |limit_s: Option<f64>| limit_s.is_some_and(|limit_s| age_s > limit_s);
        if beyond(self.params.safe_off_s) {
            Some(Reaction::SafeOff)
        } else if beyond(self.params.pause_s) {
            Some(Reaction::Pause)
        } else if age_s > self.params.degraded_s {
            Some(Reaction::Degrade)
        } else {
            None
        }
    }
}
