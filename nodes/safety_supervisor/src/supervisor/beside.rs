//! Causes that are found while another one has taken the corrections back: each is told once until that is over.

use models::command::Mode;
use models::units::Seconds;

use super::Supervisor;
use crate::cause::Cause;
use crate::event::{Decision, What};
use crate::modes::Raised;

/// Which causes have been told since corrections were taken back or the job was paused.
pub(super) type Told = [bool; Cause::COUNT];

impl Supervisor {
    /// Tells what is raised beside the cause in force. The latched modes end by a person, who is told then what stands.
    pub(super) fn tell_beside(&mut self, now: Seconds, raised: &Raised) {
        let mode = self.modes.mode();
        if !matches!(mode, Mode::Degraded | Mode::Paused) {
            self.told = [false; Cause::COUNT];
            return;
        }
        for cause in Cause::ALL.iter().copied().filter(|cause| raised[*cause as usize].is_some()) {
            if std::mem::replace(&mut self.told[cause as usize], true) || self.modes.cause() == Some(cause) {
                continue;
            }
            let found = Some((cause, self.evidence(now, cause)));
            let what = What::AlsoRaised;
            self.decisions.push(Decision {
                what,
                why: cause.text(),
                cause: found,
                before: mode,
                after: mode,
            });
        }
    }
}
