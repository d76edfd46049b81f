//! Trims that were attached to coming moves, where a permit lets corrections act and the host can execute them.

use super::Simulator;
use crate::drive::Goal;
use crate::executor::Ahead;
use models::command::{AdvanceOf, Mode, Refusal, Request, Scheduled, Trims};
use models::units::Seconds;

/// Why a scheduled trim is not attached to its move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unscheduled {
    /// It does not count: not physical, of another supervisor than the permit's, out of order.
    Refused(Refusal),
    /// The move has begun, or this host attaches nothing to moves.
    Late,
}

/// How long none has been laid, and for how long one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Roads {
    /// Since no road is laid `[s]`.
    rest_s: f64,
    /// Road since the last rest `[s]`.
    road_s: f64,
}

impl Roads {
    /// Before the first one.
    pub(super) const NONE: Self = Self { rest_s: f64::INFINITY, road_s: 0.0 };

    /// Another `dt` with or without a road; after as long as `rest` without one the count begins anew.
    fn note(&mut self, laid: bool, dt: Seconds, rest: Seconds) {
        if !laid {
            self.rest_s += dt.0;
            return;
        }
        self.road_s = if self.rest_s >= rest.0 { 0.0 } else { self.road_s + dt.0 };
        self.rest_s = 0.0;
    }
}

impl Simulator {
    /// Whether this host attaches trims to moves: it streams the file itself, or plans it.
    #[must_use]
    pub fn schedules(&self) -> bool {
        self.params.simulator.executor.host.executes_schedules()
    }

    /// Attaches a scheduled trim, as the supervisor sends it, to its coming move, or refuses and counts it. It is void once
    /// its validity has passed unless the move has begun.
    ///
    /// # Errors
    /// The reason, see [`Unscheduled`].
    pub fn on_scheduled(&mut self, scheduled: &Scheduled) -> Result<(), Unscheduled> {
        let bound = self.dead_man.session(self.now);
        self.schedule_gate.offer(bound, scheduled).map_err(Unscheduled::Refused)?;
        let taken = self.schedules() && self.executor.schedule(scheduled.trim, self.now + scheduled.validity);
        if taken { Ok(()) } else { Err(Unscheduled::Late) }
    }

    /// What is attached to moves acts while a permit to act is in force.
    pub(super) fn attached_act(&self) -> bool {
        self.in_force.mode == Mode::Act && !self.in_force.lapsed
    }

    /// Lowest speed that a move's own trim plans it at while what is attached acts `[-]`: with the speed trim in force it comes
    /// to what the printer allows of that trim, however little somebody attaches.
    pub(super) fn slowest_attached(&self) -> Option<f64> {
        self.attached_act().then(|| self.params.limits.speed_min() / self.in_force.trims.speed)
    }

    /// Speed that the move under way is planned at, relative to the file's `[-]`: below one where its own trim slows it.
    #[must_use]
    pub fn planned_pace(&self) -> f64 {
        self.executor.planned_pace()
    }

    /// Trims that are attached to the move under way and to coming ones, and have not lapsed.
    #[must_use]
    pub fn attached(&self) -> usize {
        self.executor.scheduled()
    }

    /// What the drive's advance follows: the schedule while a permit to act is in force, else `K_A` of now. Between file,
    /// permit and schedule it is handed over without a jump.
    pub(super) fn advance_goal(&mut self, trims: &Trims, dt: Seconds) -> Goal {
        let acts = self.attached_act();
        self.executor.lapse(self.now);
        let ahead = self.executor.ahead(self.params.simulator.drive.advance_smooth_s, trims);
        self.scheduled = match ahead {
            Ahead::Advance(..) => acts,
            Ahead::NoRoad => acts && self.scheduled,
            Ahead::Unscheduled => false,
        };
        if let (Ahead::Advance(_, trim), true) = (ahead, self.scheduled) {
            self.carried_m = trim.carried_m;
        }
        let of = match (ahead, trims.advance_s) {
            (Ahead::Advance(_, trim), _) if self.scheduled => AdvanceOf::Schedule(Some(trim.advance)),
            _ if self.scheduled => AdvanceOf::Schedule(None),
            (_, Some(advance_s)) => AdvanceOf::Permit(advance_s),
            (_, None) => AdvanceOf::File,
        };
        let feed_m_s = self.motion.feed.deposited_m_s * trims.flow;
        let sliced_s = self.executor.sliced().advance_s;
        self.roads.note(feed_m_s > 0.0, dt, Seconds(self.params.simulator.firmware.advance_return_s));
        // What a pause interrupts goes on after it as it was.
        if self.in_force.lapsed || self.in_force.request < Request::Pause {
            self.handover.step(of, sliced_s, self.handover_time(), dt);
        }
        let handed_s = self.handover.advance_s(feed_m_s);
        self.advance_s = match trims.advance_s {
            permitted_s if self.scheduled && self.handover.is_settled() => permitted_s.unwrap_or(sliced_s),
            _ => handed_s,
        };
        let carried_m = self.handover.scheduled() * self.carried_m;
        match ahead {
            Ahead::Advance(held_m, _) if self.scheduled && self.handover.is_settled() => {
                Goal::Ahead(held_m - carried_m)
            }
            Ahead::NoRoad if self.scheduled && self.handover.is_settled() => Goal::Ahead(-carried_m),
            _ => Goal::Now(handed_s, carried_m),
        }
    }

    /// How long the advance takes from hand to hand: as long as disturbs little where a road is laid and all is well, else
    /// within the time in which corrections have to be back; no time after a rest of as long, when nothing is held any more,
    /// and on as much road after it, in which a prediction of that road comes.
    fn handover_time(&self) -> Seconds {
        let firmware = &self.params.simulator.firmware;
        let well = self.in_force.mode <= Mode::Act && !self.in_force.lapsed;
        Seconds(match self.roads.rest_s {
            rest_s if rest_s >= firmware.advance_return_s => 0.0,
            _ if self.roads.road_s <= firmware.advance_return_s => 0.0,
            rest_s if rest_s <= 0.0 && well => firmware.advance_handover_s,
            _ => firmware.advance_return_s,
        })
    }
}
