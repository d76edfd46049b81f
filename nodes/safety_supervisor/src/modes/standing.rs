//! What stands beside a latch when a run ends, and still stands in the next one.

use models::command::Request;
use models::units::Seconds;

use super::{Modes, Pause};
use crate::cause::Cause;
use crate::params::StartMode;

/// A mode that was asked for and a pause in force; the shell keeps both in a file, so that a restart is no order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Standing {
    /// The mode that a person has set, or observe, where the set mode fell to it; `None`: nobody has set any.
    pub mode: Option<StartMode>,
    /// Why the job waits for a resume; `None` where it does not.
    pub paused: Option<Cause>,
    /// It waits with a hot end that was let cool down: a restart does not heat it.
    pub standby: bool,
}

impl Standing {
    /// What is taken for left behind where it cannot be read: the strictest that can.
    pub const UNREADABLE: Self =
        Self { mode: Some(StartMode::Observe), paused: Some(Cause::StandingUnreadable), standby: true };
}

/// Of a pause that was taken over, until the first tick tells the time: it is not old.
const NOT_BEGUN: Seconds = Seconds(f64::INFINITY);
/// Of one that was in standby: it is.
const IN_STANDBY: Seconds = Seconds(f64::NEG_INFINITY);

impl Modes {
    /// What is to be kept at `now`; `None` where nothing was asked for.
    #[must_use]
    pub fn standing(&self, now: Option<Seconds>) -> Option<Standing> {
        let standby = now.is_some_and(|now| self.request(now) == Request::Standby)
            || self.pause.is_some_and(|pause| pause.since == IN_STANDBY);
        let standing = Standing { mode: self.asked, paused: self.paused_for(), standby };
        (standing != Standing::default()).then_some(standing)
    }

    /// Goes on where a former run ended, in the stricter of its mode and the one of the start. Its pause begins anew, or with
    /// its standby: a hot end that has cooled down is not heated by a restart.
    pub fn restore(&mut self, left: Standing) {
        self.asked = left.mode;
        self.set_mode = left.mode.map_or(self.set_mode, |mode| self.set_mode.min(mode.into()));
        let since = if left.standby { IN_STANDBY } else { NOT_BEGUN };
        self.pause = left.paused.map(|cause| Pause { cause, since, resuming: false });
    }

    /// Whether the latch in force, or one before it, was taken over from a former run.
    #[must_use]
    pub fn was_latched(&self) -> bool {
        self.restored
    }

    /// The first tick: a pause that was taken over begins here, or has lasted until its standby.
    pub fn begin(&mut self, now: Seconds) {
        let standby = now - Seconds(self.params.standby_after_s);
        if let Some(pause) = &mut self.pause {
            if pause.since == NOT_BEGUN {
                pause.since = now;
            } else if pause.since == IN_STANDBY {
                pause.since = standby;
            }
        }
        self.note_mode(now);
    }

    /// A pause that was taken over has no job that could wait.
    pub fn drop_pause(&mut self, now: Seconds) {
        self.pause = None;
        self.note_mode(now);
    }
}
