//! K6, C8: trims of coming moves: only beside commands of the same publisher, in order, inside the limits.

use models::command::{Limits, Refusal, ScheduleGate, Scheduled, Trims};

use crate::params::ScheduleParams;

/// Holds a controller's schedule to the limits of its commands.
#[derive(Debug, Clone)]
pub struct Schedule {
    params: ScheduleParams,
    limits: Limits,
    gate: ScheduleGate,
    clamped: u64,
}

impl Schedule {
    /// Nothing scheduled yet.
    #[must_use]
    pub fn new(params: ScheduleParams, limits: Limits) -> Self {
        Self { params, limits, gate: ScheduleGate::new(params.validity_max()), clamped: 0 }
    }

    /// What may be sent on of a scheduled trim, and whether a limit has moved it; `bound` is the session whose command
    /// is in force.
    ///
    /// The advance is a law over the feed: its limit is taken at one feed, and moves both parts of the law alike.
    ///
    /// # Errors
    /// The [`Refusal`], which is counted.
    pub fn on_scheduled(
        &mut self,
        bound: Option<u64>,
        scheduled: Scheduled,
    ) -> Result<(Scheduled, bool), Refusal> {
        self.gate.offer(bound, &scheduled)?;
        let mut trim = scheduled.trim;
        let wished = Trims { flow: trim.flow, speed: trim.speed, ..Trims::NEUTRAL };
        let kept = self.limits.clamp(&wished).map_err(|_| Refusal::NotFinite)?;
        let advance_s = trim.advance.advance_s(self.params.feed_m_s);
        if !advance_s.is_finite() {
            return Err(Refusal::NotFinite);
        }
        let far = advance_s > self.params.advance_max_s;
        if far {
            let factor = self.params.advance_max_s / advance_s;
            trim.advance = trim.advance.scaled(factor);
            trim.carried_m *= factor;
        }
        let heavy = trim.carried_m > self.params.carried_max_m;
        trim.carried_m = trim.carried_m.min(self.params.carried_max_m);
        let moved = far || heavy || kept.changed.any();
        self.clamped = self.clamped.saturating_add(u64::from(moved));
        (trim.flow, trim.speed) = (kept.trims.flow, kept.trims.speed);
        Ok((Scheduled { trim, ..scheduled }, moved))
    }

    /// Refused so far.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.gate.refusals().total()
    }

    /// Moved by a limit so far.
    #[must_use]
    pub fn clamped(&self) -> u64 {
        self.clamped
    }
}
