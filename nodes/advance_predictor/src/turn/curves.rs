//! Paths made up to train with: closed curves in short pieces with corners, repeated layer by layer, and free ones.

use super::path::Piece;
use crate::network::chance::Stream;
use std::f64::consts::{PI, TAU};

/// Layers of a closed curve.
const LAYERS: u32 = 4;

/// A family of made-up paths: every one has another shape, speed and length of its pieces.
#[must_use]
pub fn generate(count: u32, chance: &mut Stream) -> Vec<Piece> {
    let mut pieces = vec![];
    for _ in 0..count {
        let outline = match chance.place(5) {
            0 => star(chance),
            1 => rounded(chance),
            2 => wave(chance),
            3 => slots(chance),
            _ => blob(chance),
        };
        let speed_m_s = chance.between((0.02, 0.1));
        let chord_m = chance.between((1e-4, 1e-3));
        let points = chords(&outline, chord_m, chance);
        let centre = [chance.between((0.02, 0.2)), chance.between((0.02, 0.2))];
        let layers = if chance.uniform() < 0.5 { LAYERS } else { 1 };
        let drift = chance.between((0.0, 2e-5));
        for layer in 0..layers {
            let shift = f64::from(layer) * drift;
            let placed: Vec<[f64; 2]> =
                points.iter().map(|p| [p[0] + centre[0] + shift, p[1] + centre[1]]).collect();
            lay(&placed, speed_m_s, &mut pieces);
        }
    }
    pieces
}

/// A star: corners that turn out and in.
fn star(chance: &mut Stream) -> Vec<[f64; 2]> {
    let corners = 3 + chance.place(6);
    let (outer_m, inner_share) = (chance.between((0.004, 0.02)), chance.between((0.5, 1.0)));
    closed(2 * corners, |place, angle_rad| {
        let radius_m = if place % 2 == 0 { outer_m } else { outer_m * inner_share };
        [radius_m * angle_rad.cos(), radius_m * angle_rad.sin()]
    })
}

/// A polygon with rounded corners: no turn at all where the chords are short.
fn rounded(chance: &mut Stream) -> Vec<[f64; 2]> {
    let power = chance.between((2.0, 8.0));
    let radius_m = chance.between((0.003, 0.02));
    closed(400, |_, angle_rad| {
        let (sin, cos) = angle_rad.sin_cos();
        let scale = (sin.abs().powf(power) + cos.abs().powf(power)).powf(-1.0 / power);
        [radius_m * scale * cos, radius_m * scale * sin]
    })
}

/// An open wave, as of a gyroid, with a return.
fn wave(chance: &mut Stream) -> Vec<[f64; 2]> {
    let (length_m, height_m) = (chance.between((0.002, 0.01)), chance.between((2e-4, 3e-3)));
    let there: Vec<[f64; 2]> = (0..200)
        .map(|place| {
            let x_m = f64::from(place) * 1e-4;
            [x_m, height_m * (TAU * x_m / length_m).sin()]
        })
        .collect();
    let back = there.iter().rev().map(|point| [point[0], point[1] + 2.0 * height_m + 4e-4]);
    there.iter().copied().chain(back).collect()
}

/// A long hole: two straight ways, two half circles, and a notch in one of the ways.
fn slots(chance: &mut Stream) -> Vec<[f64; 2]> {
    let (radius_m, way_m) = (chance.between((1e-3, 6e-3)), chance.between((1e-3, 0.02)));
    let notch_m = chance.between((2e-4, 2e-3));
    let arc = |centre_m: f64, from_rad: f64| {
        (0..=40).map(move |place| {
            let angle_rad = from_rad + PI * f64::from(place) / 40.0;
            [centre_m + radius_m * angle_rad.cos(), radius_m * angle_rad.sin()]
        })
    };
    let middle_m = 0.5 * way_m;
    let notch =
        [[middle_m + notch_m, radius_m], [middle_m, radius_m + notch_m], [middle_m - notch_m, radius_m]];
    arc(way_m, -0.5 * PI).chain(notch).chain(arc(0.0, 0.5 * PI)).chain([[way_m, -radius_m]]).collect()
}

/// A smooth blob with one corner, as at a seam.
fn blob(chance: &mut Stream) -> Vec<[f64; 2]> {
    let radius_m = chance.between((0.003, 0.015));
    let (two, three) = (chance.between((0.0, 0.3)), chance.between((0.0, 0.15)));
    let phase = chance.between((0.0, TAU));
    closed(300, |_, angle_rad| {
        let bumps = two * (2.0 * angle_rad).cos() + three * (3.0 * angle_rad + phase).cos();
        let radius_m = radius_m * (1.0 + bumps);
        [radius_m * angle_rad.cos(), radius_m * angle_rad.sin()]
    })
}

#[expect(clippy::cast_precision_loss, reason = "a count of corners")]
fn closed(corners: usize, mut point: impl FnMut(usize, f64) -> [f64; 2]) -> Vec<[f64; 2]> {
    (0..=corners).map(|place| point(place % corners, TAU * place as f64 / corners as f64)).collect()
}

/// The same outline in chords of about one length; its corners stay.
fn chords(outline: &[[f64; 2]], chord_m: f64, chance: &mut Stream) -> Vec<[f64; 2]> {
    let uneven = chance.between((0.0, 0.5));
    let mut points: Vec<[f64; 2]> = outline.first().copied().into_iter().collect();
    for pair in outline.windows(2) {
        let way = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
        let length_m = way[0].hypot(way[1]);
        let mut gone_m = chord_m * (1.0 + uneven * (2.0 * chance.uniform() - 1.0));
        while gone_m < length_m - 0.3 * chord_m {
            let share = gone_m / length_m;
            points.push([pair[0][0] + share * way[0], pair[0][1] + share * way[1]]);
            gone_m += chord_m * (1.0 + uneven * (2.0 * chance.uniform() - 1.0));
        }
        points.push(pair[1]);
    }
    points
}

/// The points as roads at one speed.
pub(super) fn lay(points: &[[f64; 2]], speed_m_s: f64, pieces: &mut Vec<Piece>) {
    let mut at = pieces.last().map(|piece: &Piece| piece.end_m);
    for (place, point) in points.iter().enumerate() {
        let Some(from) = at.replace(*point) else { continue };
        let way = [point[0] - from[0], point[1] - from[1]];
        let length_m = way[0].hypot(way[1]);
        if length_m > 1e-6 {
            pieces.push(Piece {
                end_m: *point,
                direction: way.map(|part| part / length_m),
                length_m,
                speed_m_s,
                duration_s: length_m / speed_m_s,
                along_m_s2: 0.0,
                deposit: place > 0,
                layer: None,
                fill: false,
            });
        }
    }
}
