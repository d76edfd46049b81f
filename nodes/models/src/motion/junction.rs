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

/// Highest path speed through the corner between two moves, before their own speed limits `[m/s]`.
pub(super) fn corner_m_s(
    before: &Direction,
    after: &Direction,
    acceleration_m_s2: f64,
    limits: &Limits,
) -> f64 {
    match limits.cornering {
        Cornering::ClassicJerk => {
            let steps: Direction = std::array::from_fn(|axis| axis_step(before[axis], after[axis]));
            along(&steps, &limits.jerk_m_s)
        }
        Cornering::JunctionDeviation => {
            let extruder = axis_step(before[axis::E], after[axis::E]);
            let by_extruder =
                if extruder > 0.0 { limits.jerk_m_s[axis::E] / extruder } else { f64::INFINITY };
            deviation_m_s(before, after, acceleration_m_s2, limits.junction_deviation_m).min(by_extruder)
        }
    }
}

/// Jump of one axis at unit path speed as Marlin counts it: the difference while the axis keeps its direction; where
/// it turns round it stops first, so each side counts alone.
fn axis_step(before: f64, after: f64) -> f64 {
    if before * after > 0.0 { (before - after).abs() } else { before.abs().max(after.abs()) }
}

fn deviation_m_s(before: &Direction, after: &Direction, acceleration_m_s2: f64, deviation_m: f64) -> f64 {
    let tool_moves = |direction: &Direction| direction[..axis::E].iter().any(|share| *share != 0.0);
    if !tool_moves(before) || !tool_moves(after) {
        return 0.0; // no circle joins a way of the tool and a way of filament alone: full stop, as in Klipper
    }
    let interior_cos: f64 = -(0..axis::E).map(|axis| before[axis] * after[axis]).sum::<f64>();
    junction_speed_m_s(interior_cos.clamp(-1.0, 1.0).acos(), acceleration_m_s2, deviation_m)
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
