//! Trims that were attached to coming moves, where a permit lets corrections act and the host can execute them.

use super::Simulator;
use crate::drive::Goal;
use crate::executor::Ahead;
use models::command::{Mode, MotionTrim, Trims};
use models::status::HostProfile;

impl Simulator {
    /// Attaches a trim to a coming move; false where it is refused: not physical, too late, or sent to a host that cannot
    /// execute it.
    pub fn on_schedule(&mut self, trim: MotionTrim) -> bool {
        let able = matches!(self.params.simulator.executor.host, HostProfile::Native | HostProfile::Serial);
        able && trim.is_valid() && self.executor.schedule(trim)
    }

    /// What the drive's advance follows: the schedule while a permit to act is in force, else `K_A` of now.
    pub(super) fn advance_goal(&mut self, trims: &Trims) -> Goal {
        let acts = self.in_force.mode == Mode::Act && !self.in_force.lapsed;
        let ahead = self.executor.ahead(self.params.simulator.drive.advance_smooth_s, trims);
        self.scheduled = match ahead {
            Ahead::Advance(_) => acts,
            Ahead::NoRoad => acts && self.scheduled,
            Ahead::Unscheduled => false,
        };
        match ahead {
            Ahead::Advance(held_m) if self.scheduled => Goal::Ahead(held_m),
            Ahead::NoRoad if self.scheduled => Goal::Ahead(0.0),
            _ => Goal::Now(self.advance_s),
        }
    }
}
