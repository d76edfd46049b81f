//! Arcs and splines as chords.

use std::f64::consts::TAU;

/// Points of an arc after its start, with the share of the way at each.
///
/// `n = ceil(sweep / (2 acos(1 - tolerance/r)))` chords stay within the tolerance of the circle.
pub(super) fn chords(
    start: [f64; 2],
    end: [f64; 2],
    centre: [f64; 2],
    clockwise: bool,
    tolerance: f64,
) -> impl Iterator<Item = (f64, [f64; 2])> {
    let polar = |point: [f64; 2]| {
        let (x, y) = (point[0] - centre[0], point[1] - centre[1]);
        (x.hypot(y), y.atan2(x))
    };
    let ((start_r, start_rad), (end_r, end_rad)) = (polar(start), polar(end));
    let same = (start[0] - end[0]).abs() <= 0.0 && (start[1] - end[1]).abs() <= 0.0;
    let turn = if clockwise { start_rad - end_rad } else { end_rad - start_rad };
    let sweep_rad = if same { TAU } else { turn.rem_euclid(TAU) };
    let chord_rad = 2.0 * (1.0 - tolerance / start_r.max(end_r).max(tolerance)).acos();
    let count = (sweep_rad / chord_rad).ceil().max(1.0);
    let sign = if clockwise { -1.0 } else { 1.0 };
    (1_u32..).map(f64::from).take_while(move |index| *index <= count).map(move |index| {
        let share = index / count;
        if index >= count {
            return (1.0, end);
        }
        let angle_rad = start_rad + sign * sweep_rad * share;
        let radius = start_r + (end_r - start_r) * share; // a spiral where the two radii differ
        (share, [centre[0] + radius * angle_rad.cos(), centre[1] + radius * angle_rad.sin()])
    })
}

/// Centre of an arc given by its radius: the short way for a positive one, the long way for a negative one.
pub(super) fn centre_of_radius(
    start: [f64; 2],
    end: [f64; 2],
    radius: f64,
    clockwise: bool,
) -> Option<[f64; 2]> {
    let (dx, dy) = (end[0] - start[0], end[1] - start[1]);
    let chord = dx.hypot(dy);
    if chord <= 0.0 {
        return None;
    }
    let height_sq = radius * radius - 0.25 * chord * chord;
    // slicers round: a chord longer than the diameter by less than its last digit is a half circle
    if height_sq < -1e-2 * radius * radius {
        return None;
    }
    let height = height_sq.max(0.0).sqrt();
    let side = if clockwise == (radius > 0.0) { -1.0 } else { 1.0 };
    let (nx, ny) = (-dy / chord, dx / chord);
    Some([0.5 * (start[0] + end[0]) + side * height * nx, 0.5 * (start[1] + end[1]) + side * height * ny])
}

/// Points of a cubic Bezier curve after its start; chords stay within the tolerance:
/// error `<= h^2/8 max|B''|`, `max|B''| <= 6 max|second difference|`.
pub(super) fn bezier(points: [[f64; 2]; 4], tolerance: f64) -> impl Iterator<Item = [f64; 2]> {
    let bend =
        |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (a[0] - 2.0 * b[0] + c[0]).hypot(a[1] - 2.0 * b[1] + c[1]);
    let bend_max = bend(points[0], points[1], points[2]).max(bend(points[1], points[2], points[3]));
    let count = (6.0 * bend_max / (8.0 * tolerance)).sqrt().ceil().max(1.0);
    (1_u32..).map(f64::from).take_while(move |index| *index <= count).map(move |index| {
        let t = index / count;
        let u = 1.0 - t;
        let weight = [u * u * u, 3.0 * u * u * t, 3.0 * u * t * t, t * t * t];
        std::array::from_fn(|axis| (0..4).map(|i| weight[i] * points[i][axis]).sum())
    })
}
