//! Executes a planned job: moves at the pace of the trims, waits for temperatures, pauses.
//!
//! A `native` host applies trims at once. A `serial` host has already sent some moves when a trim arrives: every piece of one
//! carries the trims that were in force when it was sent (`carried`).

use models::command::{MotionTrim, Trims};
use models::motion::{Action, MoveKind, Segment, Step};
use models::status::HostProfile;
use models::units::Seconds;
use std::collections::VecDeque;

mod ahead;
mod carried;
mod state;
mod types;

use carried::Carried;

pub use ahead::Ahead;
pub use types::{Motion, Settings, Sliced, Surroundings};

#[derive(Debug, Clone)]
enum Queued {
    Move(Coming),
    /// With its line of the file.
    Act(Action, u64),
}

/// A move with its number, counted from the start of the print.
#[derive(Debug, Clone, PartialEq)]
pub struct Coming {
    /// The number.
    pub sequence: u64,
    /// Its start on the slicer's plan `[s]`.
    pub start_s: f64,
    /// The move.
    pub segment: Box<Segment>,
}

#[derive(Debug, Clone)]
struct Active {
    sequence: u64,
    segment: Box<Segment>,
    trims: Trims,
    elapsed_s: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Wait {
    None,
    Until { left_s: f64 },
    Hotend,
    Bed,
}

/// A job under way.
pub struct Executor {
    settings: Settings,
    steps: Box<dyn Iterator<Item = Step> + Send>,
    queue: VecDeque<Queued>,
    queued_s: f64,
    carried: Carried,
    exhausted: bool,
    active: Option<Active>,
    wait: Wait,
    pace: f64,
    started: bool,
    /// Line that asked for a pause which is not over.
    file_pause: Option<u64>,
    stopped: bool,
    sliced: Sliced,
    homed: bool,
    layer: Option<u32>,
    line: u64,
    position_m: [f64; 3],
    path_time_s: f64,
    fed_m: f64,
    homing: [bool; 3],
    entered: u64,
    coming: Vec<Coming>,
    /// Trims of coming moves, each with the time at which it lapses unless its move has begun.
    schedule: VecDeque<(MotionTrim, Seconds)>,
    /// As of the [`Surroundings`].
    slowest_attached: Option<f64>,
}

impl Executor {
    /// A job that has not begun.
    #[must_use]
    pub fn new(settings: Settings, steps: Box<dyn Iterator<Item = Step> + Send>, off: Sliced) -> Self {
        Self {
            settings,
            steps,
            queue: VecDeque::new(),
            queued_s: 0.0,
            carried: Carried::default(),
            exhausted: false,
            active: None,
            wait: Wait::None,
            pace: 1.0,
            started: false,
            file_pause: None,
            stopped: false,
            sliced: off,
            homed: false,
            layer: None,
            line: 0,
            position_m: [0.0; 3],
            path_time_s: 0.0,
            fed_m: 0.0,
            homing: [false; 3],
            entered: 0,
            coming: Vec::new(),
            schedule: VecDeque::new(),
            slowest_attached: None,
        }
    }

    /// Advances by `dt`; `begun` takes every move that starts, with the time into the step at which it does.
    pub fn step(
        &mut self,
        dt: Seconds,
        around: &Surroundings,
        mut begun: impl FnMut(&Segment, Seconds),
    ) -> Motion {
        self.set_pace(dt, around);
        self.slowest_attached = around.slowest_attached;
        let mut motion = Motion::default();
        let mut spent_s = 0.0;
        while spent_s < dt.0 && self.pace > 0.0 {
            self.refill(around);
            if !self.ready(dt.0 - spent_s, &mut spent_s, around) {
                break;
            }
            if self.active.is_none() && !self.next_move(around, |segment| begun(segment, Seconds(spent_s))) {
                if self.exhausted && self.queue.is_empty() {
                    break;
                }
                continue;
            }
            spent_s += self.advance(dt.0 - spent_s, around, &mut motion);
        }
        motion.feed.deposited_m_s /= dt.0;
        motion.feed.other_m_s /= dt.0;
        motion.path_speed_m_s /= dt.0;
        motion.velocity_m_s = motion.velocity_m_s.map(|way_m| way_m / dt.0);
        motion.homing = std::mem::take(&mut self.homing);
        // A native host carries nothing with a move: in a pause too it follows what is in force.
        motion.trims = self.active.as_ref().map(|active| active.trims).filter(|_| self.is_serial());
        motion
    }

    fn is_serial(&self) -> bool {
        self.settings.host == HostProfile::Serial
    }

    fn set_pace(&mut self, dt: Seconds, around: &Surroundings) {
        let change = dt.0 / self.settings.pause_ramp_s;
        let goal = if around.hold || self.file_pause.is_some() { 0.0 } else { 1.0 };
        self.pace =
            if goal > self.pace { (self.pace + change).min(goal) } else { (self.pace - change).max(goal) };
    }

    /// Whether motion may go on; a dwell uses up time of the step.
    fn ready(&mut self, left_s: f64, spent_s: &mut f64, around: &Surroundings) -> bool {
        let (band_k, lower_k) = (self.settings.reached_band_k, around.trims.setpoint_offset_k.min(0.0));
        let over = match &mut self.wait {
            Wait::None => true,
            Wait::Until { left_s: wait_s } => {
                let used_s = wait_s.min(left_s);
                *wait_s -= used_s;
                *spent_s += used_s;
                *wait_s <= 0.0
            }
            // The target in force: one that a trim holds lower would never be met at the file's own.
            Wait::Hotend => around.hotend.0 >= self.sliced.hotend.0 + lower_k - band_k,
            Wait::Bed => around.bed.0 >= self.sliced.bed.0 - band_k,
        };
        if over {
            self.wait = Wait::None;
        }
        over
    }

    /// Takes the next thing from the queue; true if it is a move.
    fn next_move(&mut self, around: &Surroundings, begun: impl FnOnce(&Segment)) -> bool {
        match self.queue.pop_front() {
            None => false,
            Some(Queued::Act(action, line)) => {
                self.line = line;
                self.act(action, line);
                false
            }
            Some(Queued::Move(Coming { sequence, segment, .. })) => {
                self.queued_s = (self.queued_s - segment.profile.duration().0).max(0.0);
                self.started = true;
                self.line = segment.line;
                self.layer = segment.layer;
                begun(&segment);
                self.active = Some(Active { sequence, segment, trims: around.trims, elapsed_s: 0.0 });
                while self.schedule.front().is_some_and(|(trim, _)| trim.sequence < sequence) {
                    self.schedule.pop_front();
                }
                true
            }
        }
    }

    fn act(&mut self, action: Action, line: u64) {
        match action {
            Action::HotendTarget { target, wait } => {
                self.sliced.hotend = target;
                if wait {
                    self.wait = Wait::Hotend;
                }
            }
            Action::BedTarget { target, wait } => {
                self.sliced.bed = target;
                if wait {
                    self.wait = Wait::Bed;
                }
            }
            Action::Fan(share) => self.sliced.fan = share,
            Action::Home(axes) => {
                self.homed = true;
                self.homing = axes;
                self.wait = Wait::Until { left_s: self.settings.homing_s };
            }
            Action::Dwell(time) => self.wait = Wait::Until { left_s: time.0 },
            Action::Advance(time) => self.sliced.advance_s = time.0,
            Action::SpeedFactor(factor) => self.sliced.speed_factor = factor,
            Action::FlowFactor(factor) => self.sliced.flow_factor = factor,
            Action::Pause => self.file_pause = Some(line),
            Action::Stop => self.stopped = true,
            _ => {}
        }
    }

    /// Moves on for at most `left_s`; returns the time used.
    fn advance(&mut self, left_s: f64, around: &Surroundings, motion: &mut Motion) -> f64 {
        let planned = self.planned_pace();
        let carried = self.carried.at(self.path_time_s).filter(|_| self.is_serial());
        let Some(active) = &mut self.active else { return left_s };
        active.trims = carried.unwrap_or(around.trims);
        let planned = planned * self.sliced.speed_factor;
        let speed = active.trims.speed * self.pace * planned;
        let duration_s = active.segment.profile.duration().0;
        let plan_left_s = duration_s - active.elapsed_s;
        let plan_used_s = (left_s * speed).min(plan_left_s);
        let from_m = active.segment.profile.at(Seconds(active.elapsed_s)).distance_m;
        active.elapsed_s += plan_used_s;
        let done = active.elapsed_s >= duration_s;
        let at = active.segment.profile.at(Seconds(active.elapsed_s));

        let segment = &active.segment;
        let path_m = segment.path_m();
        let covered_m = if done { path_m - from_m } else { at.distance_m - from_m };
        let share = if path_m > 0.0 { covered_m / path_m } else { 1.0 };
        let filament_m = segment.filament_m * share;
        if segment.kind == MoveKind::Deposit {
            motion.feed.deposited_m_s += filament_m * self.sliced.flow_factor;
        } else {
            motion.feed.other_m_s += filament_m;
        }
        if segment.length_m > 0.0 {
            motion.path_speed_m_s += covered_m;
            motion.planned_speed_m_s = at.speed_m_s * planned;
            motion.sliced_speed_m_s = at.speed_m_s * self.sliced.speed_factor;
        }
        self.fed_m += filament_m.max(0.0);
        let along = if path_m > 0.0 { (at.distance_m / path_m).min(1.0) } else { 1.0 };
        for axis in 0..3 {
            let way_m = segment.end_m[axis] - segment.start_m[axis];
            self.position_m[axis] = segment.start_m[axis] + along * way_m;
            if segment.length_m > 0.0 {
                motion.velocity_m_s[axis] += share * way_m;
            }
        }
        self.path_time_s += plan_used_s;
        if done {
            self.active = None;
        }
        if speed > 0.0 { plan_used_s / speed } else { left_s }
    }
}
