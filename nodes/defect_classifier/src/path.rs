//! Which road was laid where and when, as commanded: this layer and the ones below, in bounded memory.

mod clock;
#[cfg(test)]
pub(crate) mod tests;

use clock::PlanClock;
use models::motion::{MoveKind, Role, Segment, Trapezoid};
use models::params::{ParamError, in_range};
use models::units::Seconds;
use serde::Deserialize;
use std::collections::VecDeque;

/// How much of the path is kept. Built only from a valid [`RawHistory`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawHistory")]
pub struct HistoryParams(RawHistory);

/// The `history` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawHistory {
    /// Roads kept at most, the oldest go first.
    pub roads_max: u32,
    /// Roads whose top lies farther from the newest one's are forgotten `[m]`.
    pub depth_m: f64,
    /// Moves of any kind kept to place the tool.
    pub moves_max: u32,
    /// Statuses kept to tell the plan's time.
    pub statuses_max: u32,
    /// How long the plan's pace is carried on beyond the newest status `[s]`.
    pub ahead_max_s: f64,
    /// How far status and moves may disagree on the tool's place `[m]`.
    pub disagreement_max_m: f64,
}

impl TryFrom<RawHistory> for HistoryParams {
    type Error = ParamError;

    fn try_from(raw: RawHistory) -> Result<Self, ParamError> {
        in_range("history.roads_max", f64::from(raw.roads_max), "roads", (16.0, 1e6))?;
        in_range("history.depth_m", raw.depth_m, "m", (1e-4, 1e-2))?;
        in_range("history.moves_max", f64::from(raw.moves_max), "moves", (2.0, 1e5))?;
        in_range("history.statuses_max", f64::from(raw.statuses_max), "statuses", (8.0, 1e5))?;
        in_range("history.ahead_max_s", raw.ahead_max_s, "s", (0.0, 2.0))?;
        in_range("history.disagreement_max_m", raw.disagreement_max_m, "m", (1e-5, 0.1))?;
        Ok(Self(raw))
    }
}

/// A straight piece of road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Road {
    /// Its start on the bed `[m]`.
    pub from_m: [f64; 2],
    /// Its end on the bed `[m]`.
    pub to_m: [f64; 2],
    /// Length `[m]`, above 0.
    pub length_m: f64,
    /// Layer from 0.
    pub layer: u32,
    /// Width that the slicer asked for `[m]`.
    pub width_m: f64,
    /// Its height `[m]`.
    pub height_m: f64,
    /// Height of its top over the bed `[m]`.
    pub top_m: f64,
    /// What it is for.
    pub role: Role,
    /// Number of the unbroken run of roads that it belongs to.
    pub run: u64,
    /// When its move began.
    pub start: Seconds,
    /// The move's speed over its length.
    pub profile: Trapezoid,
    /// Time along the plan at its start, once a status told `[s]`.
    plan_start_s: Option<f64>,
}

impl Road {
    /// Unit vector along it.
    #[must_use]
    pub fn along(&self) -> [f64; 2] {
        [(self.to_m[0] - self.from_m[0]) / self.length_m, (self.to_m[1] - self.from_m[1]) / self.length_m]
    }

    /// Point of its centre line `way_m` from its start.
    #[must_use]
    pub fn point_m(&self, way_m: f64) -> [f64; 2] {
        let along = self.along();
        [self.from_m[0] + along[0] * way_m, self.from_m[1] + along[1] * way_m]
    }
}

/// A move of any kind with its time.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Timed {
    start_s: f64,
    segment: Segment,
    plan_start_s: Option<f64>,
}

/// What was commanded so far.
#[derive(Debug, Clone)]
pub struct PathHistory {
    params: HistoryParams,
    clock: PlanClock,
    moves: VecDeque<Timed>,
    roads: VecDeque<Road>,
    run: u64,
    /// Newest status and moves agree on the tool's place.
    agreed: bool,
    refused: u64,
}

impl PathHistory {
    /// An empty history.
    #[must_use]
    pub fn new(params: HistoryParams) -> Self {
        Self {
            params,
            clock: PlanClock::new(params.0.statuses_max as usize, params.0.ahead_max_s),
            moves: VecDeque::new(),
            roads: VecDeque::new(),
            run: 0,
            agreed: false,
            refused: 0,
        }
    }

    /// Takes a move that begins at `start`. One that does not follow the last in time is refused and counted.
    pub fn on_move(&mut self, start: Seconds, segment: &Segment) {
        let last = self.moves.back().copied();
        let disordered = last.is_some_and(|last| start.0 < last.start_s);
        if disordered || !start.0.is_finite() {
            self.refused += 1;
            return;
        }
        if self.moves.len() == self.params.0.moves_max as usize {
            self.moves.pop_front();
        }
        let plan_start_s = self.clock.path_s(start.0);
        self.moves.push_back(Timed { start_s: start.0, segment: *segment, plan_start_s });
        if segment.kind != MoveKind::Deposit {
            return;
        }
        if last
            .is_none_or(|last| last.segment.kind != MoveKind::Deposit || last.segment.layer != segment.layer)
        {
            self.run += 1;
        }
        self.lay(start, segment, plan_start_s);
    }

    fn lay(&mut self, start: Seconds, segment: &Segment, plan_start_s: Option<f64>) {
        let (Some(width_m), Some(height_m)) = (segment.target_width_m, segment.layer_height_m) else {
            return;
        };
        let (from, to) = (segment.start_m, segment.end_m);
        let length_m = (to[0] - from[0]).hypot(to[1] - from[1]);
        if length_m <= 0.0 || width_m <= 0.0 {
            return;
        }
        let layer = segment.layer.unwrap_or(0);
        if self.roads.len() == self.params.0.roads_max as usize {
            self.roads.pop_front();
        }
        // By height, not by number: support has layers of its own between those of the part.
        let far = |road: &Road| (road.top_m - to[2]).abs() > self.params.0.depth_m;
        while self.roads.front().is_some_and(far) {
            self.roads.pop_front();
        }
        self.roads.push_back(Road {
            from_m: [from[0], from[1]],
            to_m: [to[0], to[1]],
            length_m,
            layer,
            width_m,
            height_m,
            top_m: to[2],
            role: segment.role,
            run: self.run,
            start,
            profile: segment.profile,
            plan_start_s,
        });
    }

    /// Takes the printer's own word on time and place. One out of order is refused and counted.
    pub fn on_status(&mut self, stamp: Seconds, path_time_s: f64, position_m: [f64; 3]) {
        if !self.clock.push(stamp.0, path_time_s) {
            self.refused += 1;
            return;
        }
        let clock = &self.clock;
        for timed in self.moves.iter_mut().rev().take_while(|timed| timed.plan_start_s.is_none()) {
            timed.plan_start_s = clock.path_s(timed.start_s);
        }
        for road in self.roads.iter_mut().rev().take_while(|road| road.plan_start_s.is_none()) {
            road.plan_start_s = clock.path_s(road.start.0);
        }
        self.agreed = self.place(stamp.0).is_none_or(|(place_m, _)| {
            (place_m[0] - position_m[0]).hypot(place_m[1] - position_m[1]) <= self.params.0.disagreement_max_m
        });
    }

    /// Tool on the bed and its velocity at `at` `[m]`, `[m/s]`; `None` where moves and statuses do not tell, or
    /// disagree.
    #[must_use]
    pub fn tool(&self, at: Seconds) -> Option<([f64; 2], [f64; 2])> {
        self.agreed.then(|| self.place(at.0)).flatten()
    }

    fn place(&self, at_s: f64) -> Option<([f64; 2], [f64; 2])> {
        let timed = self.moves.iter().rev().find(|timed| timed.start_s <= at_s)?;
        let elapsed_s = self.elapsed_s(timed.start_s, timed.plan_start_s, at_s)?;
        let (place_m, state) = timed.segment.at(Seconds(elapsed_s));
        let length_m = timed.segment.length_m;
        let resting = length_m <= 0.0 || elapsed_s >= timed.segment.profile.duration().0;
        let speed_m_s = if resting { 0.0 } else { state.speed_m_s };
        let velocity = |axis: usize| {
            let way_m = timed.segment.end_m[axis] - timed.segment.start_m[axis];
            if length_m > 0.0 { way_m / length_m * speed_m_s } else { 0.0 }
        };
        Some(([place_m[0], place_m[1]], [velocity(0), velocity(1)]))
    }

    /// Time on the plan that a move has taken at `at_s` `[s]`.
    fn elapsed_s(&self, start_s: f64, plan_start_s: Option<f64>, at_s: f64) -> Option<f64> {
        let plan_start_s = plan_start_s.or_else(|| self.clock.path_s(start_s))?;
        Some((self.clock.path_s(at_s)? - plan_start_s).max(0.0))
    }

    /// Time along the plan at `at` `[s]`; `None` where the statuses do not reach.
    #[must_use]
    pub fn path_s(&self, at: Seconds) -> Option<f64> {
        self.clock.path_s(at.0)
    }

    /// Roads begun before `at`, oldest first.
    pub fn roads(&self, at: Seconds) -> impl DoubleEndedIterator<Item = &Road> {
        let count = self.roads.partition_point(|road| road.start.0 < at.0);
        self.roads.range(..count)
    }

    /// How far along it a road was laid at `at` `[m]`.
    #[must_use]
    pub fn laid_m(&self, road: &Road, at: Seconds) -> f64 {
        // Without the plan's time the road is old: the clock reaches back for seconds.
        let elapsed_s = self.elapsed_s(road.start.0, road.plan_start_s, at.0);
        elapsed_s.map_or(road.length_m, |elapsed_s| {
            road.profile.at(Seconds(elapsed_s)).distance_m.min(road.length_m)
        })
    }

    /// When the point `way_m` along a road was laid; `None` where it is too long ago to tell.
    #[must_use]
    pub fn laid_at(&self, road: &Road, way_m: f64) -> Option<Seconds> {
        let path_s = road.plan_start_s? + time_at(&road.profile, way_m);
        self.clock.stamp_s(path_s).map(Seconds)
    }

    /// Moves and statuses that were refused.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Roads kept.
    #[must_use]
    pub fn len(&self) -> usize {
        self.roads.len()
    }

    /// No road is kept.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.roads.is_empty()
    }
}

/// Time at which a trapezoid has covered `way_m` `[s]`: the inverse of `Trapezoid::at`.
fn time_at(profile: &Trapezoid, way_m: f64) -> f64 {
    let up_m = 0.5 * (profile.entry_m_s + profile.cruise_m_s) * profile.accel_s;
    let flat_m = profile.cruise_m_s * profile.cruise_s;
    // v^2 = v0^2 + 2 a s, t = 2 s / (v0 + v)
    let ramp = |from_m_s: f64, acceleration_m_s2: f64, way_m: f64| {
        let speed_m_s = (from_m_s * from_m_s + 2.0 * acceleration_m_s2 * way_m).max(0.0).sqrt();
        if from_m_s + speed_m_s > 0.0 { 2.0 * way_m / (from_m_s + speed_m_s) } else { 0.0 }
    };
    if way_m <= up_m && profile.accel_s > 0.0 {
        ramp(profile.entry_m_s, profile.acceleration_m_s2, way_m.max(0.0))
    } else if way_m <= up_m + flat_m && profile.cruise_m_s > 0.0 {
        profile.accel_s + (way_m - up_m) / profile.cruise_m_s
    } else {
        let braked_s = ramp(profile.cruise_m_s, -profile.acceleration_m_s2, way_m - up_m - flat_m);
        (profile.accel_s + profile.cruise_s + braked_s).min(profile.duration().0)
    }
}
