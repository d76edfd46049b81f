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
    /// The advance is a law over the feed: its limit is that of a command's `K_A`, taken at the feed of `params`, and
    /// moves both parts of the law alike.
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
        let advance_s = trim.advance.advance_s(self.params.feed_m_s);
        let wished =
            Trims { flow: trim.flow, speed: trim.speed, advance_s: Some(advance_s), ..Trims::NEUTRAL };
        let kept = self.limits.clamp(&wished).map_err(|_| Refusal::NotFinite)?;
        let moved = kept.changed.any();
        if moved {
            self.clamped = self.clamped.saturating_add(1);
            trim.flow = kept.trims.flow;
            trim.speed = kept.trims.speed;
        }
        if let Some(kept_s) = kept.trims.advance_s.filter(|_| kept.changed.advance) {
            trim.advance = trim.advance.scaled(kept_s / advance_s);
        }
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
