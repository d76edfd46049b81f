//! Splines made up to train with: chains of cubic curves, chopped at even steps as firmware and hosts chop a `G5`.

use super::curves::lay;
use super::path::Piece;
use crate::network::chance::Stream;
use std::f64::consts::TAU;

/// Curves of a chain.
const CURVES: (usize, usize) = (2, 4);
/// Share of the joints without a corner.
const SMOOTH: f64 = 0.5;

/// Chains of curves: every one has other ends, bends, tolerance, resolution and speed.
pub(super) fn generate(count: u32, chance: &mut Stream) -> Vec<Piece> {
    let mut pieces = vec![];
    for _ in 0..count {
        let speed_m_s = chance.between((0.02, 0.1));
        let tolerance_m = chance.between((2e-6, 2e-5));
        // Files of slicers have a resolution, a firmware's own chords none.
        let grid_m = if chance.uniform() < 0.5 { 1e-6 } else { 0.0 };
        let points = chain(tolerance_m, chance);
        let placed: Vec<[f64; 2]> =
            points.iter().map(|point| point.map(|part_m| on_grid(part_m, grid_m))).collect();
        lay(&placed, speed_m_s, &mut pieces);
    }
    pieces
}

fn on_grid(part_m: f64, grid_m: f64) -> f64 {
    if grid_m > 0.0 { (part_m / grid_m).round() * grid_m } else { part_m }
}

fn chain(tolerance_m: f64, chance: &mut Stream) -> Vec<[f64; 2]> {
    let mut from = [chance.between((0.02, 0.2)), chance.between((0.02, 0.2))];
    let mut points = vec![from];
    let mut handle = away(chance, (5e-4, 6e-3));
    for _ in 0..CURVES.0 + chance.place(CURVES.1) {
        let way = away(chance, (2e-3, 2e-2));
        let to = sum(from, way);
        let back = away(chance, (5e-4, 6e-3));
        points.extend(chopped([from, sum(from, handle), sum(to, back), to], tolerance_m));
        handle = if chance.uniform() < SMOOTH { back.map(|part| -part) } else { away(chance, (5e-4, 6e-3)) };
        from = to;
    }
    points
}

/// A way in any direction.
fn away(chance: &mut Stream, reach_m: (f64, f64)) -> [f64; 2] {
    let (way_m, angle_rad) = (chance.between(reach_m), chance.between((0.0, TAU)));
    [way_m * angle_rad.cos(), way_m * angle_rad.sin()]
}

fn sum(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// Points of a curve behind its begin at even steps of its parameter, as many as keep the chords within the tolerance, of
/// the same unit.
pub(super) fn chopped(points: [[f64; 2]; 4], tolerance: f64) -> Vec<[f64; 2]> {
    let bend = |place: usize| {
        let [a, b, c] = [points[place], points[place + 1], points[place + 2]];
        (a[0] - 2.0 * b[0] + c[0]).hypot(a[1] - 2.0 * b[1] + c[1])
    };
    let count = (0.75 * bend(0).max(bend(1)) / tolerance).sqrt().ceil().max(1.0);
    let at = |share: f64| {
        let rest = 1.0 - share;
        let weights = [rest.powi(3), 3.0 * rest * rest * share, 3.0 * rest * share * share, share.powi(3)];
        [0, 1].map(|axis| weights.iter().zip(&points).map(|(weight, point)| weight * point[axis]).sum())
    };
    (1_u32..).map(f64::from).take_while(|step| *step <= count).map(|step| at(step / count)).collect()
}
