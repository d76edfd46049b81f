//! A tick that comes late, and a clock that was set back.

use models::command::Trims;
use models::units::Seconds;

use super::Supervisor;
use crate::event::{Decision, What};

impl Supervisor {
    /// The tick came late: what was silent in the meantime was not heard, which says nothing of it.
    pub(super) fn on_stall(&mut self, now: Seconds, gap: Seconds) {
        // Once in a while: whoever always comes late hears nothing in time, and has to say so.
        let often = self.last_stall.is_some_and(|last| (now - last).0 < self.params.modes.stall_forgiven_s);
        self.last_stall = Some(now);
        // A clock that was set back is not late: the ages go back with it.
        if !often || gap < Seconds(0.0) {
            for age in self.ages.all_mut() {
                age.forgive(now, gap);
            }
            self.checks.forgive(now, gap);
            self.started = self.started.map(|_| now);
        }
        if gap < Seconds(0.0) {
            // Of what lies ahead of the clock now, nothing would be seen until it is there again.
            self.modes.set_back(now, gap);
            self.checks.set_back();
            self.envelope.set_back();
            self.paused_alone_since = None;
        }
        self.allowed = Trims::NEUTRAL;
        self.step = None;
        self.ramp = None;
        self.returning_since = None;
        self.approved = None;
        let mode = self.modes.mode();
        self.decisions.push(Decision {
            what: What::StoodStill,
            why: if gap < Seconds(0.0) { "the clock was set back" } else { "the tick came late" },
            cause: None,
            before: mode,
            after: mode,
        });
    }
}
