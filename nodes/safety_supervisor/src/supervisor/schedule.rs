//! What passes of the trims that a controller attaches to coming moves.

use models::command::{Mode, Refusal, Scheduled};
use models::units::Seconds;

use super::Supervisor;

impl Supervisor {
    /// Takes a trim of a coming move received at `now`; yields what is to be sent on at once. In any mode but act
    /// nothing is: the slicer's values hold, and in advise nobody approves a move at a time.
    ///
    /// What lies outside of the limits counts as a command that does (K6).
    pub fn on_scheduled(&mut self, now: Seconds, scheduled: Scheduled) -> Option<Scheduled> {
        let bound = self.envelope.session(now);
        match self.schedule.on_scheduled(bound, scheduled) {
            Ok((allowed, moved)) => {
                if moved {
                    self.envelope.note_outside(now);
                }
                self.pass(allowed)
            }
            Err(Refusal::NotFinite) => {
                self.checks.bad_values.note(now);
                None
            }
            Err(_) => None,
        }
    }

    /// As of this supervisor: the printer takes it beside its permits only.
    fn pass(&mut self, allowed: Scheduled) -> Option<Scheduled> {
        if self.modes.mode() != Mode::Act {
            return None;
        }
        self.scheduled += 1;
        Some(Scheduled { session: self.session, sequence: self.scheduled, ..allowed })
    }
}
