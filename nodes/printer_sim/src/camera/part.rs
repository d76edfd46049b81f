//! Random small parts as roads: perimeters and infill, layer by layer. For training frames only.

use rand::{Rng, rngs::StdRng};
use std::f64::consts::{FRAC_PI_4, TAU};

/// A straight road of a layer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub(super) from_m: [f64; 2],
    pub(super) to_m: [f64; 2],
}

/// Outline with its inset in closed form.
#[derive(Debug, Clone, Copy)]
enum Shape {
    Box { half_m: [f64; 2] },
    Polygon { corners: u32, apothem_m: f64 },
}

/// Pattern of the infill.
#[derive(Debug, Clone, Copy)]
enum Infill {
    /// Straight lines, across those of the layer below.
    Lines,
    /// Lines of both directions in one layer.
    Grid,
    /// Waves of this length and swing over their pitch, as a gyroid's cuts `[m]`, `[-]`.
    Waves(f64, f64),
}

/// A part around its own origin.
#[derive(Debug, Clone)]
pub(super) struct Part {
    shape: Shape,
    hole_m: Option<f64>,
    turn_rad: f64,
    loops: u32,
    infill: Infill,
    infill_share: f64,
    brim: u32,
    infill_rad: f64,
    /// Width that the slicer asked for `[m]`.
    pub(super) width_m: f64,
    /// Layer height `[m]`.
    pub(super) height_m: f64,
}

impl Part {
    pub(super) fn draw(rng: &mut StdRng) -> Self {
        let shape = if rng.random_bool(0.5) {
            Shape::Box { half_m: [rng.random_range(2e-3..12e-3), rng.random_range(2e-3..10e-3)] }
        } else {
            let corners = [3, 5, 6, 8, 40][rng.random_range(0..5)];
            Shape::Polygon { corners, apothem_m: rng.random_range(3e-3..9e-3) }
        };
        let infill_share = if rng.random_bool(0.6) { 1.0 } else { rng.random_range(0.12..0.4) };
        let infill = match rng.random_range(0..4) {
            0 if infill_share < 0.3 => Infill::Grid,
            1 | 2 if infill_share < 1.0 => {
                Infill::Waves(rng.random_range(4e-3..9e-3), rng.random_range(0.2..0.45))
            }
            _ => Infill::Lines,
        };
        let hole_m = rng.random_bool(0.3).then(|| rng.random_range(1.0e-3..2.0e-3));
        Self {
            shape,
            hole_m,
            turn_rad: if rng.random_bool(0.6) { 0.0 } else { rng.random_range(0.0..TAU) },
            loops: rng.random_range(1..4),
            infill,
            infill_share,
            brim: if rng.random_bool(0.6) { 0 } else { rng.random_range(1..8) },
            infill_rad: if rng.random_bool(0.7) { FRAC_PI_4 } else { rng.random_range(0.0..TAU) },
            width_m: rng.random_range(0.38e-3..0.55e-3),
            height_m: rng.random_range(0.12e-3..0.28e-3),
        }
    }

    /// Distance between roads `[m]`: the slicer's, where the round sides fill each other.
    pub(super) fn pitch_m(&self) -> f64 {
        self.width_m - self.height_m * (1.0 - FRAC_PI_4)
    }

    /// Corners of the outline `inset_m` inside of it; empty where nothing is left.
    fn outline(&self, inset_m: f64) -> Vec<[f64; 2]> {
        let local: Vec<[f64; 2]> = match self.shape {
            Shape::Box { half_m } => {
                let [x, y] = half_m.map(|half| half - inset_m);
                if x <= 0.0 || y <= 0.0 { Vec::new() } else { vec![[x, y], [-x, y], [-x, -y], [x, -y]] }
            }
            Shape::Polygon { corners, apothem_m } if apothem_m > inset_m => {
                let step = TAU / f64::from(corners);
                let radius_m = (apothem_m - inset_m) / (step / 2.0).cos();
                (0..corners).map(|corner| polar(radius_m, f64::from(corner) * step)).collect()
            }
            Shape::Polygon { .. } => Vec::new(),
        };
        local.into_iter().map(|point| turned(point, self.turn_rad)).collect()
    }

    fn hole(&self, inset_m: f64) -> Vec<[f64; 2]> {
        let circle =
            |radius_m: f64| (0..32).map(|step| polar(radius_m, f64::from(step) * TAU / 32.0)).collect();
        self.hole_m.map_or_else(Vec::new, |radius_m| circle(radius_m + inset_m))
    }

    /// Roads of a layer, in the order in which they are laid.
    pub(super) fn layer(&self, number: u32, solid: bool) -> Vec<Line> {
        let mut lines = Vec::new();
        for ring in (0..self.loops).rev() {
            let inset_m = self.width_m / 2.0 + f64::from(ring) * self.pitch_m();
            for points in [self.outline(inset_m), self.hole(inset_m)] {
                close(&points, &mut lines);
            }
        }
        let turn = self.infill_rad + if number.is_multiple_of(2) { 0.0 } else { TAU / 4.0 };
        let inset_m = self.width_m / 2.0 + (f64::from(self.loops) - 0.6) * self.pitch_m();
        let infill = if solid { Infill::Lines } else { self.infill };
        let pitch_m = self.pitch_m() / if solid { 1.0 } else { self.infill_share };
        let angles = if matches!(infill, Infill::Grid) { vec![turn, turn + TAU / 4.0] } else { vec![turn] };
        for angle in angles {
            let edges = [self.outline(inset_m), self.hole(inset_m)];
            raster(edges, (angle, pitch_m, infill), &mut lines);
        }
        lines
    }

    /// Roads around the part that hold it to the bed, from the outermost; none on most parts.
    pub(super) fn brim(&self) -> Vec<Line> {
        let mut lines = Vec::new();
        for ring in (1..=self.brim).rev() {
            close(&self.outline(self.width_m / 2.0 - f64::from(ring) * self.pitch_m()), &mut lines);
        }
        lines
    }
}

/// Parallel lines inside the outline and outside the hole (even-odd rule), there and back again.
fn raster(edges: [Vec<[f64; 2]>; 2], (angle, pitch_m, infill): (f64, f64, Infill), lines: &mut Vec<Line>) {
    let edges = edges
        .map(|points| -> Vec<[f64; 2]> { points.into_iter().map(|point| turned(point, -angle)).collect() });
    let low = edges[0].iter().map(|point| point[1]).fold(f64::INFINITY, f64::min);
    let high = edges[0].iter().map(|point| point[1]).fold(f64::NEG_INFINITY, f64::max);
    let (mut y, mut back) = (low + pitch_m / 2.0, false);
    while y < high {
        let mut cuts: Vec<f64> = edges.iter().flat_map(|points| crossings(points, y)).collect();
        cuts.sort_by(f64::total_cmp);
        if back {
            cuts.reverse();
        }
        for pair in cuts.chunks_exact(2) {
            run([pair[0], pair[1]], (y, pitch_m, infill), angle, lines);
        }
        back = !back;
        y += pitch_m;
    }
}

/// One line of the infill from cut to cut, straight or in waves.
fn run([from, to]: [f64; 2], (y, pitch_m, infill): (f64, f64, Infill), angle: f64, lines: &mut Vec<Line>) {
    let (steps, length_m, swing_m) = match infill {
        Infill::Waves(length_m, swing) => {
            (crate::camera::cast::floor((to - from).abs() / 4e-4).max(1), length_m, swing * pitch_m)
        }
        Infill::Lines | Infill::Grid => (1, 1.0, 0.0),
    };
    let at = |step: i32| {
        let x = from + (to - from) * f64::from(step) / f64::from(steps);
        turned([x, y + swing_m * (TAU * x / length_m).sin()], angle)
    };
    lines.extend((0..steps).map(|step| Line { from_m: at(step), to_m: at(step + 1) }));
}

fn polar(radius_m: f64, angle: f64) -> [f64; 2] {
    [radius_m * angle.cos(), radius_m * angle.sin()]
}

fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    [x * angle.cos() - y * angle.sin(), x * angle.sin() + y * angle.cos()]
}

fn close(points: &[[f64; 2]], lines: &mut Vec<Line>) {
    for (step, from_m) in points.iter().enumerate() {
        let to_m = points[(step + 1) % points.len()];
        lines.push(Line { from_m: *from_m, to_m });
    }
}

fn crossings(points: &[[f64; 2]], y: f64) -> Vec<f64> {
    (0..points.len())
        .filter_map(|step| {
            let (a, b) = (points[step], points[(step + 1) % points.len()]);
            let between = (a[1] > y) != (b[1] > y);
            between.then(|| a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
        })
        .collect()
}
