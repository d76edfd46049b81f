//! What a printer does with the supervisor's permits, and without them. Stands in the bridge and in the simulator.
//!
//! No fresh permit: back to the slicer's values at once. What follows a longer silence is policy. A demand once
//! made is held: it is lowered only by a session of the supervisor that has made it itself, so that a restarted
//! supervisor which has forgotten a pause or a trip cannot undo it by chance. Heaters off and an emergency stop are
//! taken from every session, in force or not: whoever has taken the printer over must not keep it from being stopped.

use serde::Deserialize;

use super::{Gate, Limits, Mode, Permit, Refusal, Refusals, Request, Trims};
use crate::params::{ParamError, in_range};
use crate::units::Seconds;

/// What follows when the supervisor stays silent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OnLoss {
    /// Print on with the slicer's values; the firmware still protects.
    Baseline,
    /// Pause the job.
    Pause,
    /// Switch the heaters off.
    HeatersOff,
}

/// Behaviour on loss of the supervisor. Built only from valid [`RawDeadManParams`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawDeadManParams")]
pub struct DeadManParams {
    on_loss: OnLoss,
    pause_delay_s: f64,
    heaters_off_delay_s: f64,
}

/// The `dead_man` block of a parameter file as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawDeadManParams {
    /// `baseline`, `pause` or `heaters_off`.
    pub on_supervisor_loss: OnLoss,
    /// Silence after the last permit lapsed until `pause` pauses `[s]`.
    pub pause_delay_s: f64,
    /// Silence after the last permit lapsed until `heaters_off` switches off `[s]`.
    pub heaters_off_delay_s: f64,
}

impl TryFrom<RawDeadManParams> for DeadManParams {
    type Error = ParamError;

    fn try_from(raw: RawDeadManParams) -> Result<Self, ParamError> {
        Ok(Self {
            on_loss: raw.on_supervisor_loss,
            pause_delay_s: in_range("pause_delay_s", raw.pause_delay_s, "s", (0.01, 3600.0))?,
            heaters_off_delay_s: in_range(
                "heaters_off_delay_s",
                raw.heaters_off_delay_s,
                "s",
                (0.01, 8.64e4),
            )?,
        })
    }
}

/// What the printer has to do now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InForce {
    /// Corrections, inside the printer's own limits and slew; neutral when lapsed.
    pub trims: Trims,
    /// Demand beyond trims. From `HeatersOff` on the printer sets its targets to zero and gives the job up, so
    /// that a later release re-energises nothing.
    pub request: Request,
    /// Mode of the newest permit; `Init` before the first.
    pub mode: Mode,
    /// No permit is in force.
    pub lapsed: bool,
}

/// Holds the newest permit and decides what counts.
#[derive(Debug, Clone)]
pub struct DeadMan {
    params: DeadManParams,
    limits: Limits,
    gate: Gate<Permit>,
    trims: Trims,
    /// What is in force of them: it moves no faster than the printer's own slew.
    moving: Trims,
    moved: Option<Seconds>,
    held: Request,
    /// Highest request that the bound session itself has made.
    stated: Request,
    clamped: u64,
}

impl DeadMan {
    /// A dead-man that has not heard of any supervisor: the slicer's values. `limits` are the printer's own.
    #[must_use]
    pub fn new(params: DeadManParams, limits: Limits) -> Self {
        Self {
            params,
            limits,
            gate: Gate::new(limits.validity_max()),
            trims: Trims::NEUTRAL,
            moving: Trims::NEUTRAL,
            moved: None,
            held: Request::Run,
            stated: Request::Run,
            clamped: 0,
        }
    }

    /// Takes a permit received at `now`, or refuses and counts it.
    ///
    /// # Errors
    /// The [`Refusal`]. A demand to stop that comes with broken trims is refused with them; the silence that
    /// follows ends at the slicer's values. One that comes from another session than that in force, or asks to count for
    /// longer than this printer lets permits count, is counted as refused, but held.
    pub fn on_permit(&mut self, now: Seconds, permit: Permit) -> Result<(), Refusal> {
        self.apply_policy(now);
        let newest = self.gate.newest().copied();
        let session = newest.map(|newest| newest.session);
        if let Err(refusal) = self.gate.offer(now, permit) {
            let again =
                newest.is_some_and(|last| last.session == permit.session && permit.sequence <= last.sequence);
            let counts = refusal == Refusal::OtherSession || (refusal == Refusal::Validity && !again);
            if counts && permit.request >= Request::HeatersOff {
                self.held = self.held.max(permit.request);
            }
            return Err(refusal);
        }
        let clamped = self.limits.clamp(&permit.trims).map_err(|_| Refusal::NotFinite)?;
        self.clamped = self.clamped.saturating_add(u64::from(clamped.changed.any()));
        self.trims = clamped.trims;
        if session != Some(permit.session) {
            self.stated = Request::Run;
        }
        self.stated = self.stated.max(permit.request);
        // Standby is the later half of a pause: who has asked for the pause may end either.
        let needed = if self.held == Request::Standby { Request::Pause } else { self.held };
        if permit.request >= self.held || self.stated >= needed {
            self.held = permit.request;
            // The next demand has to be earned anew.
            self.stated = permit.request;
        }
        Ok(())
    }

    /// What the printer has to do at `now`. Call it at the pace at which the printer acts: trims move from one call to the
    /// next.
    pub fn in_force(&mut self, now: Seconds) -> InForce {
        self.apply_policy(now);
        let lapsed = self.gate.in_force(now).is_none();
        let since = self.moved.replace(now).map_or(Seconds(0.0), |moved| now - moved);
        // Back to the slicer's values no slew counts.
        self.moving =
            if lapsed { Trims::NEUTRAL } else { self.limits.slew(&self.moving, &self.trims, since).trims };
        InForce {
            trims: self.moving,
            request: self.held,
            mode: self.gate.newest().map_or(Mode::Init, |permit| permit.mode),
            lapsed,
        }
    }

    /// Session of the supervisor whose permit is in force.
    #[must_use]
    pub fn session(&self, now: Seconds) -> Option<u64> {
        self.gate.in_force(now).map(|permit| permit.session)
    }

    /// Refused permits so far.
    #[must_use]
    pub fn refusals(&self) -> Refusals {
        self.gate.refusals()
    }

    /// Permits so far whose trims lay outside of the printer's own limits.
    #[must_use]
    pub fn clamped(&self) -> u64 {
        self.clamped
    }

    /// The policy's step once it is due; before the first permit there is nobody to lose.
    fn apply_policy(&mut self, now: Seconds) {
        let Some(lapse) = self.gate.lapse() else { return };
        let silent_s = now.0 - lapse.0;
        let due = match self.params.on_loss {
            OnLoss::Baseline => Request::Run,
            OnLoss::Pause if silent_s > self.params.pause_delay_s => Request::Pause,
            OnLoss::HeatersOff if silent_s > self.params.heaters_off_delay_s => Request::HeatersOff,
            OnLoss::Pause | OnLoss::HeatersOff => Request::Run,
        };
        if due > self.held {
            self.held = due;
            self.stated = Request::Run;
        }
    }
}

#[cfg(test)]
#[path = "dead_man_tests.rs"]
mod tests;
