//! Trims that were attached to coming moves, where a permit lets corrections act and the host can execute them.

use super::Simulator;
use crate::drive::Goal;
use crate::executor::Ahead;
use models::command::{Mode, MotionTrim, Refusal, Scheduled, Trims};
use models::status::HostProfile;
use models::units::Seconds;

/// Why a scheduled trim is not attached to its move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unscheduled {
    /// It does not count: not physical, of another supervisor than the permit's, out of order.
    Refused(Refusal),
    /// The move has begun, or this host attaches nothing to moves.
    Late,
}

impl Simulator {
    /// Whether this host attaches trims to moves: it streams the file itself, or plans it.
    #[must_use]
    pub fn schedules(&self) -> bool {
        matches!(self.params.simulator.executor.host, HostProfile::Native | HostProfile::Serial)
    }

    /// Takes a scheduled trim as the supervisor sends it, or refuses and counts it.
    ///
    /// # Errors
    /// The reason, see [`Unscheduled`].
    pub fn on_scheduled(&mut self, scheduled: &Scheduled) -> Result<(), Unscheduled> {
        let bound = self.dead_man.session(self.now);
        self.schedule_gate.offer(bound, scheduled).map_err(Unscheduled::Refused)?;
        let taken = self.on_schedule(scheduled.trim, self.now + scheduled.validity);
        if taken { Ok(()) } else { Err(Unscheduled::Late) }
    }

    /// Attaches a trim to a coming move, void at `lapse` unless the move has begun; false where it is refused: not
    /// physical, too late, or sent to a host that cannot execute it.
    pub fn on_schedule(&mut self, trim: MotionTrim, lapse: Seconds) -> bool {
        self.schedules() && trim.is_valid() && self.executor.schedule(trim, lapse)
    }

    /// What the drive's advance follows: the schedule while a permit to act is in force, else `K_A` of now.
    pub(super) fn advance_goal(&mut self, trims: &Trims) -> Goal {
        let acts = self.in_force.mode == Mode::Act && !self.in_force.lapsed;
        self.executor.lapse(self.now);
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
