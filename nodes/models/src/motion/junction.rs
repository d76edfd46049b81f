//! Speed limits that follow from a move's direction and from the corner between two moves.

use super::params::{Cornering, Limits, axis};

/// Change of each axis per path variable of one move; X, Y, Z, E.
pub(super) type Direction = [f64; 4];

/// Highest value of the path variable's rate such that no axis exceeds its own limit.
pub(super) fn along(direction: &Direction, axis_limit: &[f64; 4]) -> f64 {
    let mut limit = f64::INFINITY;
    for (share, axis_limit) in direction.iter().zip(axis_limit) {
        if *share != 0.0 {
            limit = limit.min(axis_limit / share.abs());
        }
    }
    limit
}

/// Speed at which a move may start from rest or end in rest `[m/s]`: each axis may jump by its jerk.
pub(super) fn standstill_m_s(direction: &Direction, limits: &Limits) -> f64 {
    match limits.cornering {
        Cornering::ClassicJerk => along(direction, &limits.jerk_m_s),
        Cornering::JunctionDeviation => 0.0,
    }
}

/// The corner between two moves.
pub(super) struct Corner {
    /// Direction of the move that ends here.
    pub(super) before: Direction,
    /// Direction of the move that begins here.
    pub(super) after: Direction,
    /// Smaller acceleration of the two `[m/s2]`.
    pub(super) acceleration_m_s2: f64,
    /// Shorter path of the two `[m]`.
    pub(super) path_m: f64,
}

/// Highest path speed through a corner, before the moves' own speed limits `[m/s]`.
pub(super) fn corner_m_s(corner: &Corner, limits: &Limits) -> f64 {
    let Corner { before, after, .. } = corner;
    match limits.cornering {
        Cornering::ClassicJerk => {
            let steps: Direction = std::array::from_fn(|axis| axis_step(before[axis], after[axis]));
            along(&steps, &limits.jerk_m_s)
        }
        Cornering::JunctionDeviation => {
            let extruder = axis_step(before[axis::E], after[axis::E]);
            let by_extruder =
                if extruder > 0.0 { limits.jerk_m_s[axis::E] / extruder } else { f64::INFINITY };
            deviation_m_s(corner, limits.junction_deviation_m).min(by_extruder)
        }
    }
}

/// Jump of one axis at unit path speed as Marlin counts it: the difference while the axis keeps its direction; where
/// it turns round it stops first, so each side counts alone.
fn axis_step(before: f64, after: f64) -> f64 {
    if before * after > 0.0 { (before - after).abs() } else { before.abs().max(after.abs()) }
}

/// Junction speed, and for chords of a circle no more than its centripetal acceleration allows:
/// `v^2 = a s tan(t/2)/2`, the circle through both moves' middles (Klipper, toolhead `calc_junction`).
fn deviation_m_s(corner: &Corner, deviation_m: f64) -> f64 {
    let tool_moves = |direction: &Direction| direction[..axis::E].iter().any(|share| *share != 0.0);
    if !tool_moves(&corner.before) || !tool_moves(&corner.after) {
        return 0.0; // no circle joins a way of the tool and a way of filament alone: full stop, as in Klipper
    }
    let straight: f64 = (0..axis::E).map(|axis| corner.before[axis] * corner.after[axis]).sum();
    let interior_rad = (-straight.clamp(-1.0, 1.0)).acos();
    let tangent = (0.5 * interior_rad).tan();
    let centripetal_sq = 0.5 * corner.acceleration_m_s2 * corner.path_m * tangent;
    junction_speed_m_s(interior_rad, corner.acceleration_m_s2, deviation_m).min(centripetal_sq.abs().sqrt())
}

/// Junction speed `v^2 = a d sin(t/2)/(1 - sin(t/2))`, `t` the interior angle (pi: straight on) `[m/s]`.
///
/// Model book 2.5; infinite on a straight line.
#[must_use]
pub fn junction_speed_m_s(interior_angle_rad: f64, acceleration_m_s2: f64, deviation_m: f64) -> f64 {
    let half_sin = (0.5 * interior_angle_rad).sin();
    if half_sin >= 1.0 {
        return f64::INFINITY;
    }
    (acceleration_m_s2 * deviation_m * half_sin / (1.0 - half_sin)).sqrt()
}
