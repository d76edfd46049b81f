//! Looking ahead: what moves are coming, and the filament that their roads will hold compressed.

use super::{Active, Coming, Executor, Queued, Surroundings, Wait};
use models::command::{MotionTrim, Trims};
use models::motion::{MoveKind, Segment, Step};
use models::units::Seconds;

/// Trims of coming moves that are kept: a second of the shortest ones.
const SCHEDULED: usize = 1024;

/// What the schedule says of a moment ahead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ahead {
    /// Filament that is to be held compressed then `[m]`, and the trim that says so.
    Advance(f64, MotionTrim),
    /// No road is laid then, whatever is scheduled.
    NoRoad,
    /// A road without a trim of its own.
    Unscheduled,
}

impl Executor {
    /// Keeps the host's buffer filled: one move for a native host, a stretch of time for a serial one.
    pub(super) fn refill(&mut self, around: &Surroundings) {
        let (moves, span_s) = if self.is_serial() {
            (self.settings.serial_buffer_moves, self.settings.serial_buffer_s)
        } else {
            (self.settings.plan_moves, self.settings.plan_s)
        };
        // nothing is planned across a halt: what comes after it is not known before; nor while a temperature is waited for,
        // whose wait has left the queue, nor longer before the end of a dwell than ahead of any move: its trim would lapse
        if match self.wait {
            Wait::None => false,
            Wait::Until { left_s } => left_s > span_s,
            Wait::Hotend | Wait::Bed => true,
        } {
            return;
        }
        let halts = |queued: &Queued| matches!(queued, Queued::Act(action, _) if action.stops());
        while !self.exhausted
            && (self.queue.is_empty() || (self.queue.len() < moves && self.queued_s < span_s))
            && !self.queue.back().is_some_and(halts)
        {
            match self.steps.next() {
                None => self.exhausted = true,
                Some(Step::Action(action, line)) => {
                    self.queue.push_back(Queued::Act(action, line));
                }
                Some(Step::Move(segment)) => {
                    let start_s = self.known_until_s();
                    self.queued_s += segment.profile.duration().0;
                    let coming = Coming { sequence: self.entered, start_s, segment: Box::new(segment) };
                    self.entered += 1;
                    self.coming.push(coming.clone());
                    self.queue.push_back(Queued::Move(coming));
                }
            }
        }
        if self.is_serial() {
            let plan_s = (self.path_time_s, self.known_until_s());
            self.carried.send(plan_s, (span_s, self.settings.serial_piece_s), &around.trims);
        }
    }

    /// End of the last move that is known, on the slicer's plan `[s]`.
    fn known_until_s(&self) -> f64 {
        let left = |active: &Active| active.segment.profile.duration().0 - active.elapsed_s;
        self.path_time_s + self.active.as_ref().map_or(0.0, left) + self.queued_s
    }

    /// Moves that have become known since the last call.
    pub fn take_coming(&mut self) -> Vec<Coming> {
        std::mem::take(&mut self.coming)
    }

    /// Attaches a trim to a move that has not begun; one that has, or is out of order, is not taken. A native host takes another for
    /// the one that a move has. At `lapse` it is void, unless its move has begun.
    pub fn schedule(&mut self, trim: MotionTrim, lapse: Seconds) -> bool {
        let late = self.active.as_ref().is_some_and(|active| trim.sequence <= active.sequence);
        let attached = self.schedule.iter_mut().find(|(kept, _)| kept.sequence == trim.sequence);
        if let Some(attached) = attached.filter(|_| !late && self.settings.host.takes_trims_anew()) {
            *attached = (trim, lapse);
            return true;
        }
        let order = self.schedule.back().is_none_or(|(last, _)| last.sequence < trim.sequence);
        if late || !order || self.schedule.len() >= SCHEDULED {
            return false;
        }
        self.schedule.push_back((trim, lapse));
        true
    }

    /// Trims that are kept.
    #[must_use]
    pub fn scheduled(&self) -> usize {
        self.schedule.len()
    }

    /// Drops what has lapsed at `now`. What has begun is carried through: half a move without its advance would be a fault
    /// of its own.
    pub fn lapse(&mut self, now: Seconds) {
        let begun = self.active.as_ref().map(|active| active.sequence);
        self.schedule.retain(|(trim, lapse)| now <= *lapse || Some(trim.sequence) == begun);
    }

    /// Speed that the move under way is planned at, relative to the file's `[-]`.
    #[must_use]
    pub fn planned_pace(&self) -> f64 {
        self.active.as_ref().map_or(1.0, |active| self.own_pace(active.sequence))
    }

    /// Speed that a move's own trim plans it at, about which the trims in force count; never above the file's `[-]`.
    fn own_pace(&self, sequence: u64) -> f64 {
        let Some(slowest) = self.slowest_attached else { return 1.0 };
        let own = self.schedule.iter().find(|(trim, _)| trim.sequence == sequence);
        own.map_or(1.0, |(trim, _)| trim.speed.max(slowest).min(1.0))
    }

    /// What the schedule says of `ahead_s` from now, under the trims in force.
    #[must_use]
    pub fn ahead(&self, ahead_s: f64, trims: &Trims) -> Ahead {
        let pace = trims.speed * self.pace * self.sliced.speed_factor;
        let mut left_s = ahead_s * pace;
        let scale = trims.flow * pace * self.sliced.flow_factor;
        if let Some(active) = &self.active {
            let remains_s = active.segment.profile.duration().0 - active.elapsed_s;
            let own = self.own_pace(active.sequence);
            if own * left_s <= remains_s {
                let at_s = active.elapsed_s + own * left_s;
                return self.held(active.sequence, &active.segment, (at_s, own * scale));
            }
            left_s -= remains_s / own;
        }
        for queued in &self.queue {
            match queued {
                Queued::Move(Coming { sequence, segment, .. }) => {
                    let duration_s = segment.profile.duration().0;
                    let own = self.own_pace(*sequence);
                    if own * left_s <= duration_s {
                        return self.held(*sequence, segment, (own * left_s, own * scale));
                    }
                    left_s -= duration_s / own;
                }
                Queued::Act(action, _) if action.stops() => return Ahead::NoRoad,
                Queued::Act(..) => {}
            }
        }
        Ahead::NoRoad
    }

    /// Compressed filament of a move at a time into it.
    fn held(&self, sequence: u64, segment: &Segment, (at_s, scale): (f64, f64)) -> Ahead {
        if segment.kind != MoveKind::Deposit {
            return Ahead::NoRoad;
        }
        let Some((trim, _)) = self.schedule.iter().find(|(trim, _)| trim.sequence == sequence) else {
            return Ahead::Unscheduled;
        };
        let feed_m_s = segment.filament_per_path() * segment.profile.at(Seconds(at_s)).speed_m_s * scale;
        let held_m = trim.advance.held_m(feed_m_s).min(self.settings.schedule_advance_max_s * feed_m_s);
        Ahead::Advance(held_m, *trim)
    }
}
