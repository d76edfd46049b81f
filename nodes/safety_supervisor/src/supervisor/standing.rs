//! What outlives a run: the latch, the mode that was asked for, and a pause.

use models::command::Mode;
use models::status::JobPhase;
use models::units::Seconds;

use super::Supervisor;
use crate::event::{Decision, Evidence, What};
use crate::modes::{Latch, Standing};

/// Of a latch or a pause.
const TAKEN_OVER: &str = "taken over from before the supervisor was started again";
/// Of a mode.
const SET_BEFORE: &str = "set before the supervisor was started again; `fdm mode` sets another";

impl Supervisor {
    /// Goes on where a former run ended: never in a laxer mode than that, and paused if it was.
    #[must_use]
    pub fn after(mut self, left: Standing) -> Self {
        self.modes.restore(left);
        self.left = left;
        self
    }

    /// What the cause of what was taken over rested on, where the record tells; to be called behind [`Self::after`].
    #[must_use]
    pub fn resting_on(mut self, evidence: Evidence) -> Self {
        self.found = self.modes.cause().map(|cause| (cause, Some(evidence)));
        self
    }

    /// The latched mode, to be kept across restarts.
    #[must_use]
    pub fn latch(&self) -> Option<Latch> {
        self.modes.latch()
    }

    /// The mode that was asked for and the pause in force, to be kept across restarts; `None` where there is neither.
    #[must_use]
    pub fn standing(&self) -> Option<Standing> {
        self.modes.standing(self.last_tick)
    }

    /// On the first tick there is a time.
    pub(super) fn begin(&mut self, now: Seconds) {
        if self.started.is_none() {
            self.started = Some(now);
            self.modes.begin(now);
        }
    }

    /// Ends the start once every stream that is required was heard, or has been waited for.
    pub(super) fn initialise(&mut self, now: Seconds) {
        if self.modes.is_initialised() {
            return;
        }
        let waited_s = self.started.map_or(0.0, |started| now.0 - started.0);
        let complete = self.params.required.iter().all(|stream| self.is_seen(stream));
        if complete || waited_s > self.params.modes.startup_s {
            self.ages.expect(self.params.required, now);
            let before = self.modes.mode();
            self.modes.initialise();
            let after = self.modes.mode();
            if before != after {
                let what = What::ModeChanged;
                self.decisions.push(Decision { what, why: "the start is over", cause: None, before, after });
            }
            self.tell_left();
        }
    }

    /// The start is over: says what of the former run makes a difference, the strictest of it.
    fn tell_left(&mut self) {
        let (before, set) = (Mode::from(self.params.start_mode), self.modes.set_mode());
        let latch = self.modes.latch().filter(|_| self.modes.was_latched());
        let waits = self.left.paused.and(self.modes.paused_for());
        if latch.is_none() && self.left.paused.is_none() && set >= before {
            return;
        }
        let cause = latch.map(|latch| latch.cause).or(waits);
        let (after, why) = match (latch, waits) {
            (Some(latch), _) => (latch.mode(), TAKEN_OVER),
            (None, Some(_)) => (Mode::Paused, TAKEN_OVER),
            (None, None) => (set, SET_BEFORE),
        };
        let cause = cause.map(|cause| (cause, self.evidence_of(cause)));
        self.decisions.push(Decision { what: What::Remembered, why, cause, before, after });
    }

    /// The printer's first word: a pause of the former run ends where no job waits for its end.
    pub(super) fn on_first_job(&mut self, now: Seconds, phase: JobPhase) {
        let job = matches!(phase, JobPhase::Preparing | JobPhase::Printing | JobPhase::Paused);
        if self.printer.is_none() && self.left.paused.is_some() && !job {
            self.modes.drop_pause(now);
        }
    }
}
