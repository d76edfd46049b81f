//! Turns of a path by hindsight (model book 2.5).

/// Turn at each inner point of a path `[rad]`, `[0, pi]`: 0 is straight on, pi is back.
///
/// Where two points coincide the direction before them holds.
#[must_use]
pub fn turn_angles_rad(points_m: &[[f64; 2]]) -> Vec<f64> {
    let mut before: Option<[f64; 2]> = None;
    let mut angles = Vec::with_capacity(points_m.len().saturating_sub(2));
    for (index, pair) in points_m.windows(2).enumerate() {
        let way = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
        let after = if way == [0.0, 0.0] { before } else { Some(way) };
        if index > 0 {
            angles.push(before.zip(after).map_or(0.0, |(before, after)| turn_rad(before, after).abs()));
        }
        before = after;
    }
    angles
}

/// Signed turn from one direction to the next `[rad]`, `(-pi, pi]`, left positive; any lengths above 0.
#[must_use]
pub fn turn_rad(before: [f64; 2], after: [f64; 2]) -> f64 {
    let cross = before[0] * after[1] - before[1] * after[0];
    let dot = before[0] * after[0] + before[1] * after[1];
    cross.atan2(dot)
}

/// Way from each point but the last to the next turn above the threshold after it `[m]`; `None` where none follows.
#[must_use]
pub fn ways_to_turn_m(points_m: &[[f64; 2]], threshold_rad: f64) -> Vec<Option<f64>> {
    let angles_rad = turn_angles_rad(points_m);
    let mut way_m: Option<f64> = None;
    let mut ways: Vec<_> = (0..points_m.len().saturating_sub(1))
        .rev()
        .map(|start| {
            let [from, to] = [points_m[start], points_m[start + 1]];
            let length_m = (to[0] - from[0]).hypot(to[1] - from[1]);
            // The angle list begins at point 1.
            let turns = angles_rad.get(start).is_some_and(|angle_rad| *angle_rad > threshold_rad);
            way_m = if turns { Some(length_m) } else { way_m.map(|way_m| way_m + length_m) };
            way_m
        })
        .collect();
    ways.reverse();
    ways
}
