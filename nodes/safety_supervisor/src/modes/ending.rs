//! How a pause and a latched mode end: as a person says, and where nothing stands against it.

use models::units::Seconds;

use super::{Modes, Pause};
use crate::cause::{Cause, Reaction};

/// Why a person's request is refused, with what to do, and the cause that stands against it, where one does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Refused {
    /// Why, for people.
    pub why: &'static str,
    /// What stands against it.
    pub cause: Option<Cause>,
}

impl From<&'static str> for Refused {
    fn from(why: &'static str) -> Self {
        Self { why, cause: None }
    }
}

/// Whether the printer may go on after a pause.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Readiness {
    /// All axes know their place.
    pub homed: bool,
    /// Filament is there, or no switch is fitted.
    pub filament: bool,
    /// The hot end is near its set-point.
    pub hot: bool,
}

impl Modes {
    /// Ends a pause as soon as the printer is ready; the hot end is heated again for it.
    ///
    /// # Errors
    /// What stands against it.
    pub fn resume(&mut self, now: Seconds, ready: Readiness) -> Result<(), Refused> {
        if let Some(latch) = self.latch {
            return Err(Refused { why: "latched: `fdm acknowledge` first", cause: Some(latch.cause) });
        }
        self.none_stands(Reaction::Pause)?;
        if !ready.homed {
            return Err("not homed: home the printer, then `fdm resume`".into());
        }
        if !ready.filament {
            return Err("no filament: load some, then `fdm resume`".into());
        }
        let Some(pause) = self.pause.as_mut().or(self.hold.as_mut()) else {
            return Err("not paused: nothing to resume".into());
        };
        pause.resuming = true;
        self.try_resume(now, ready);
        Ok(())
    }

    /// Carries out a resume that waits for the hot end. Returns whether the pause has ended.
    pub fn try_resume(&mut self, now: Seconds, ready: Readiness) -> bool {
        let waits = self.pause.or(self.hold).is_some_and(|pause| pause.resuming);
        let ended = waits && self.latch.is_none() && ready.hot && ready.homed && ready.filament;
        if ended {
            self.pause = None;
            self.hold = None;
            self.note_mode(now);
        }
        ended
    }

    /// Ends a latched mode. A job that still waits goes on only after a resume.
    ///
    /// # Errors
    /// What stands against it.
    pub fn acknowledge(&mut self, now: Seconds, job_waits: bool) -> Result<(), Refused> {
        let Some(latch) = self.latch else { return Err("not latched: nothing to acknowledge".into()) };
        self.none_stands(Reaction::SafeOff)?;
        self.latch = None;
        self.pause = None;
        self.hold = job_waits.then_some(Pause { cause: latch.cause, since: now, resuming: false });
        self.note_mode(now);
        Ok(())
    }

    /// What calls for most, and for what.
    pub(super) fn worst(&self) -> Option<(Reaction, Cause)> {
        Cause::ALL
            .iter()
            .filter_map(|cause| self.raised[*cause as usize].map(|reaction| (reaction, *cause)))
            .max_by_key(|(reaction, _)| *reaction)
    }

    fn none_stands(&self, least: Reaction) -> Result<(), Refused> {
        let standing = self.worst().filter(|(reaction, _)| *reaction >= least);
        standing
            .map_or(Ok(()), |(_, cause)| Err(Refused { why: "the cause is still there", cause: Some(cause) }))
    }
}
