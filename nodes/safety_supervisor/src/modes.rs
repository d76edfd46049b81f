//! The mode machine: what was raised goes in, mode and request come out.
//!
//! One pause per cause: while the cause lasts no resume is granted, and one that waits for heat is taken back. What
//! lasts keeps the mode at least degraded, until it has been gone for the hold time. Latched modes end by acknowledge
//! alone, and a job that waits after it is bounded in time as any pause.

use models::command::{Mode, Request};
use models::units::Seconds;
use serde::{Deserialize, Serialize};

use crate::cause::{Cause, Reaction};
use crate::params::{ModeParams, StartMode};

mod ending;
mod standing;
pub use ending::{Readiness, Refused};
pub use standing::Standing;

/// What each cause calls for now.
pub type Raised = [Option<Reaction>; Cause::COUNT];

/// A latched mode; the shell keeps it in a file, so that a restart cannot end it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Latch {
    /// Emergency stop; otherwise heaters off.
    pub estop: bool,
    /// Why.
    pub cause: Cause,
}

impl Latch {
    /// The latched mode.
    #[must_use]
    pub fn mode(self) -> Mode {
        if self.estop { Mode::Estop } else { Mode::SafeOff }
    }
}

/// A pause in force.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Pause {
    cause: Cause,
    since: Seconds,
    resuming: bool,
}

/// The mode machine.
#[derive(Debug, Clone)]
pub struct Modes {
    params: ModeParams,
    set_mode: Mode,
    /// The mode that was asked for, in this run or before; `start_mode` may be stricter.
    asked: Option<StartMode>,
    initialised: bool,
    latch: Option<Latch>,
    /// A former run left a latch.
    restored: bool,
    pause: Option<Pause>,
    /// The job waits for a resume after an acknowledge.
    hold: Option<Pause>,
    degraded: Option<(Cause, Seconds)>,
    raised: Raised,
    seen: Mode,
    since: Seconds,
}

impl Modes {
    /// Starts in `Init`, or latched.
    #[must_use]
    pub fn new(params: ModeParams, set_mode: Mode, restored: Option<Latch>) -> Self {
        Self {
            params,
            set_mode,
            asked: None,
            initialised: false,
            latch: restored,
            restored: restored.is_some(),
            pause: None,
            hold: None,
            degraded: None,
            raised: [None; Cause::COUNT],
            seen: restored.map_or(Mode::Init, Latch::mode),
            since: Seconds(0.0),
        }
    }

    /// Mode in force.
    #[must_use]
    pub fn mode(&self) -> Mode {
        match (self.latch, self.pause, self.degraded) {
            (Some(latch), ..) => latch.mode(),
            (None, Some(_), _) => Mode::Paused,
            (None, None, Some(_)) => Mode::Degraded,
            (None, None, None) if self.initialised => self.set_mode,
            (None, None, None) => Mode::Init,
        }
    }

    /// Demand on the printer.
    #[must_use]
    pub fn request(&self, now: Seconds) -> Request {
        match (self.latch, self.pause.or(self.hold)) {
            (Some(Latch { estop: true, .. }), _) => Request::EmergencyStop,
            (Some(_), _) => Request::HeatersOff,
            (None, Some(pause)) if pause.resuming => Request::Pause,
            (None, Some(pause)) if now.0 - pause.since.0 >= self.params.standby_after_s => Request::Standby,
            (None, Some(_)) => Request::Pause,
            (None, None) => Request::Run,
        }
    }

    /// Why the job waits for a resume; `None` where it does not.
    #[must_use]
    pub fn paused_for(&self) -> Option<Cause> {
        self.pause.or(self.hold).map(|pause| pause.cause)
    }

    /// The clock was set back to `now` by `gap`, below zero: what began before that keeps its age.
    pub fn set_back(&mut self, now: Seconds, gap: Seconds) {
        let moved = |since: Seconds| if since > now { since + gap } else { since };
        for pause in [&mut self.pause, &mut self.hold].into_iter().flatten() {
            pause.since = moved(pause.since);
        }
        self.degraded = self.degraded.map(|(cause, last)| (cause, moved(last)));
        self.since = moved(self.since);
    }

    /// Why the mode is not the one that was set.
    #[must_use]
    pub fn cause(&self) -> Option<Cause> {
        self.latch
            .map(|latch| latch.cause)
            .or(self.pause.map(|pause| pause.cause))
            .or(self.degraded.map(|(cause, _)| cause))
            .or(self.hold.map(|pause| pause.cause))
    }

    /// Mode as set by a person.
    #[must_use]
    pub fn set_mode(&self) -> Mode {
        self.set_mode
    }

    /// Since when the mode is in force.
    #[must_use]
    pub fn since(&self) -> Seconds {
        self.since
    }

    /// The latch, to be kept by the shell.
    #[must_use]
    pub fn latch(&self) -> Option<Latch> {
        self.latch
    }

    /// Whether the start is over.
    #[must_use]
    pub fn is_initialised(&self) -> bool {
        self.initialised
    }

    /// The start is over.
    pub fn initialise(&mut self) {
        self.initialised = true;
    }

    /// Sets the mode: observe, advise or act, nothing else.
    ///
    /// # Errors
    /// What was wrong with it.
    pub fn set(&mut self, mode: Mode) -> Result<(), Refused> {
        self.asked = Some(StartMode::of(mode).ok_or("only observe, advise and act can be set")?);
        self.set_mode = mode;
        Ok(())
    }

    /// Takes what is raised now; to be called on every tick. Returns whether mode or cause changed.
    pub fn update(&mut self, now: Seconds, raised: &Raised, job_runs: bool) -> bool {
        let before = (self.mode(), self.cause());
        for cause in Cause::ALL {
            self.act(now, *cause, raised[*cause as usize], job_runs);
        }
        self.raised = *raised;
        self.hold_degraded(now);
        if self.pause.or(self.hold).is_some_and(|pause| now.0 - pause.since.0 > self.params.pause_max_s) {
            self.trip(Cause::PauseTooLong, false);
        }
        self.note_mode(now);
        before != (self.mode(), self.cause())
    }

    /// Takes a person's demand at once, without waiting for the next tick.
    pub fn demand(&mut self, now: Seconds, cause: Cause, reaction: Reaction) {
        self.act(now, cause, Some(reaction), true);
        self.note_mode(now);
    }

    fn act(&mut self, now: Seconds, cause: Cause, reaction: Option<Reaction>, job_runs: bool) {
        match reaction {
            Some(Reaction::Pause) => {
                if let Some(pause) = self.pause.as_mut().or(self.hold.as_mut()) {
                    // Whoever has asked for the resume did not know of this.
                    pause.resuming = false;
                } else if job_runs {
                    self.pause = Some(Pause { cause, since: now, resuming: false });
                }
            }
            Some(Reaction::SafeOff) => self.trip(cause, false),
            Some(Reaction::Estop) => self.trip(cause, true),
            Some(Reaction::Degrade) | None => {}
        }
    }

    fn trip(&mut self, cause: Cause, estop: bool) {
        if self.latch.is_none_or(|latch| estop && !latch.estop) {
            self.latch = Some(Latch { estop, cause });
        }
    }

    fn hold_degraded(&mut self, now: Seconds) {
        if let Some((_, cause)) = self.worst() {
            self.degraded = Some((cause, now));
        } else if self.degraded.is_some_and(|(_, last)| now.0 - last.0 >= self.params.hold_s) {
            self.degraded = None;
        }
    }

    fn note_mode(&mut self, now: Seconds) {
        if self.mode() != self.seen {
            self.seen = self.mode();
            self.since = now;
        }
    }
}

#[cfg(test)]
mod tests;
