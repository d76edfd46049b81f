//! A move of the look-ahead queue, whose speeds at its ends are still open.

use super::junction::Direction;
use super::planner::Waypoint;
use super::segment::Segment;
use super::trapezoid::Trapezoid;

/// A move and its limits; the planner's passes set the speeds at its ends.
pub(super) struct Block {
    pub(super) waypoint: Waypoint,
    pub(super) length_m: f64,
    pub(super) path_m: f64,
    pub(super) direction: Direction,
    pub(super) cruise_m_s: f64,
    pub(super) acceleration_m_s2: f64,
    pub(super) standstill_m_s: f64,
    /// Limit of the entry speed from corner and neighbours.
    pub(super) entry_max_m_s: f64,
    pub(super) entry_m_s: f64,
    pub(super) exit_m_s: f64,
    /// The machine rests after this move.
    pub(super) then_rest: bool,
}

impl Block {
    /// Speed at one end that a given speed at the other end allows: `v^2 = u^2 + 2 a s`.
    pub(super) fn reachable_m_s(&self, other_m_s: f64) -> f64 {
        (other_m_s * other_m_s + 2.0 * self.acceleration_m_s2 * self.path_m).sqrt()
    }

    /// The move with the speeds that it has now.
    pub(super) fn segment(&self) -> Segment {
        let waypoint = &self.waypoint;
        Segment {
            line: waypoint.line,
            layer: waypoint.layer,
            start_m: waypoint.start_m,
            end_m: waypoint.end_m,
            length_m: self.length_m,
            filament_m: waypoint.filament_m,
            kind: waypoint.kind,
            role: waypoint.role,
            arc: waypoint.arc,
            target_width_m: waypoint.target_width_m,
            stated_width_m: waypoint.stated_width_m,
            layer_height_m: waypoint.layer_height_m,
            profile: Trapezoid::new(
                self.path_m,
                (self.entry_m_s, self.exit_m_s),
                self.cruise_m_s,
                self.acceleration_m_s2,
            ),
        }
    }
}
