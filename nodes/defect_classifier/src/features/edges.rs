//! Edges: how many, how evenly spread, how they bend, and how sharp the picture is at three sizes.

use super::picture::{CELLS, Picture, Plane, deviation, mean};
use opencv::core::Mat;
use opencv::imgproc;

pub(super) const NAMES: [&str; 10] = [
    "edge_weak",
    "edge_strong",
    "edge_ratio",
    "edge_cell_std",
    "edge_cell_max",
    "edge_turn",
    "lap_1",
    "lap_2",
    "lap_4",
    "lap_tails",
];
/// Thresholds of the two edge maps in standard deviations of the picture, as the 3 x 3 Sobel operator scales them.
const WEAK: f64 = 0.8;
const STRONG: f64 = 2.0;
/// Hysteresis: the lower threshold as a share of the upper.
const LOWER: f64 = 0.5;
/// Steps along the picture's axes over which the turn of an edge is taken `[px]`.
const TURN_PX: usize = 3;

pub(super) fn of(picture: &Picture) -> opencv::Result<[f64; 10]> {
    let spread = 255.0 * picture.variance.sqrt();
    let weak = canny(&picture.fine, WEAK * spread)?;
    let strong = canny(&picture.fine, STRONG * spread)?;
    let (weak_share, strong_share) = (weak.mean(), strong.mean());
    let mut cells = vec![0.0; CELLS.0 * CELLS.1];
    for y in 0..weak.height {
        for x in 0..weak.width {
            cells[weak.cell(x, y)] += f64::from(weak.at(x, y));
        }
    }
    let per_cell = mean(cells.iter().copied()).max(1.0);
    let most = cells.iter().copied().fold(0.0, f64::max);
    let (lap_1, tails) = laplacian(&picture.smooth, 1);
    let laps = [lap_1, laplacian(&picture.smooth, 2).0, laplacian(&picture.smooth, 4).0]
        .map(|energy| (energy / picture.variance).max(1e-9).ln());
    Ok([
        weak_share,
        strong_share,
        strong_share / weak_share.max(1e-4),
        deviation(&cells, per_cell) / per_cell,
        most / per_cell,
        turn(&weak, &picture.smooth),
        laps[0],
        laps[1],
        laps[2],
        tails,
    ])
}

/// Edge map, 1 on an edge.
fn canny(grey: &Mat, upper: f64) -> opencv::Result<Plane> {
    let mut edges = Mat::default();
    imgproc::canny(grey, &mut edges, LOWER * upper, upper, 3, false)?;
    Plane::of(&edges)
}

/// Mean square of the Laplacian with arms of `arm` pixels, and the logarithm of its kurtosis.
fn laplacian(plane: &Plane, arm: usize) -> (f64, f64) {
    let (mut square, mut fourth, mut count) = (0.0, 0.0, 0.0_f64);
    for y in arm..plane.height - arm {
        for x in arm..plane.width - arm {
            let around =
                plane.at(x - arm, y) + plane.at(x + arm, y) + plane.at(x, y - arm) + plane.at(x, y + arm);
            let value = f64::from(around - 4.0 * plane.at(x, y)).powi(2);
            square += value;
            fourth += value * value;
            count += 1.0;
        }
    }
    let energy = square / count.max(1.0);
    let kurtosis = fourth / count.max(1.0) / (energy * energy).max(1e-18);
    (energy, kurtosis.max(1.0).ln().min(10.0))
}

/// Mean of `1 - cos 2(a - b)` over pairs of edge pixels [`TURN_PX`] apart, a and b the orientations of their
/// gradients: 0 for straight edges, 1 for edges that lie anyhow.
fn turn(edges: &Plane, smooth: &Plane) -> f64 {
    let doubled = |x: usize, y: usize| {
        let across = smooth.at(x + 1, y) - smooth.at(x - 1, y);
        let down = smooth.at(x, y + 1) - smooth.at(x, y - 1);
        let sum = (across * across + down * down).max(1e-9);
        [(across * across - down * down) / sum, 2.0 * across * down / sum]
    };
    let (mut sum, mut pairs) = (0.0, 0.0_f64);
    for y in 1..edges.height - 1 - TURN_PX {
        for x in 1..edges.width - 1 - TURN_PX {
            if edges.at(x, y) < 0.5 {
                continue;
            }
            for (to_x, to_y) in [(x + TURN_PX, y), (x, y + TURN_PX), (x + TURN_PX, y + TURN_PX)] {
                if edges.at(to_x, to_y) > 0.5 {
                    let (here, there) = (doubled(x, y), doubled(to_x, to_y));
                    sum += 1.0 - f64::from(here[0] * there[0] + here[1] * there[1]);
                    pairs += 1.0;
                }
            }
        }
    }
    sum / pairs.max(1.0)
}
