//! Labelled frames of random small parts: what a classifier is trained with, and judged on in the other style.

use super::deposit::{Bead, Deposit};
use super::image::Frame;
use super::look::Look;
use super::params::{CameraParams, Style};
use super::part::{Line, Part};
use super::render::{Renderer, View};
use super::strands::{Tangle, blob, string};
use rand::{Rng, SeedableRng, rngs::StdRng};
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

/// Half sides of what a camera of the usual scale sees `[m]`, its rim left out.
const SEEN_M: [f64; 2] = [9.0e-3, 6.5e-3];
/// What the head hides around the tool `[m]`.
const HEAD_M: f64 = 2.0e-3;

/// What a frame shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// Roads as wide as they should be, within 4 %.
    Ok,
    /// Roads at most 88 % as wide: gaps.
    Under,
    /// Roads at least 113 % as wide: ridges.
    Over,
    /// A tangle of loose filament.
    Spaghetti,
    /// Thin strings between parts.
    Stringing,
    /// Lumps on the roads.
    Blobs,
    /// The newest layers lie beside those below.
    Shift,
}

impl Class {
    /// All of them, in the order of a label's number.
    pub const ALL: [Self; 7] =
        [Self::Ok, Self::Under, Self::Over, Self::Spaghetti, Self::Stringing, Self::Blobs, Self::Shift];
}

/// A labelled frame.
#[derive(Debug, Clone)]
pub struct Example {
    /// The picture before compression.
    pub frame: Frame,
    /// Quality that the camera's JPEG has `[1, 100]`.
    pub jpeg_quality: u8,
    /// What it shows.
    pub class: Class,
    /// Mean width of the newest roads `[m]`.
    pub width_m: f64,
    /// Width that the slicer asked for `[m]`.
    pub target_width_m: f64,
    /// Layer height `[m]`.
    pub layer_height_m: f64,
    /// Distance between neighbouring solid roads `[m]`.
    pub pitch_m: f64,
    /// Offset of the newest layers against those below `[m]`.
    pub shift_m: [f64; 2],
    /// Tool and its velocity at exposure, as a bridge would state them.
    pub view: View,
}

/// Width error along the way: an AR(1) process over the lines, as diameter and slip give.
struct Scatter {
    factor: f64,
    offset: f64,
    sigma: f64,
}

/// A scene under construction.
struct Scene {
    deposit: Deposit,
    rng: StdRng,
    part: Part,
    at_m: [f64; 2],
    width: Scatter,
    shift_m: Option<[f64; 2]>,
}

/// A frame of `class` in this style; the same arguments give the same frame.
#[must_use]
pub fn synthesize(params: &CameraParams, style: Style, class: Class, seed: u64) -> Example {
    let mut scene = Scene::new(params, class, seed);
    let layers = scene.rng.random_range(1..4);
    scene.lay_brim();
    let first_m = scene.pedestal();
    let shifted_from = if class == Class::Shift { layers } else { u32::MAX };
    let layers = if class == Class::Shift { layers + scene.rng.random_range(1..3) } else { layers };
    for layer in 0..layers - 1 {
        scene.moved(layer >= shifted_from);
        scene.lay_layer(layer, first_m, 1.0);
    }
    scene.moved(layers > shifted_from);
    let done = if scene.rng.random_bool(0.25) { 1.0 } else { scene.rng.random_range(0.3..1.0) };
    let view = scene.lay_layer(layers - 1, first_m, done);
    let top_m = first_m + f64::from(layers) * scene.part.height_m;
    scene.spoil(class, view, top_m, params.field.strand_m);
    scene.shoot(params, (style, class, seed), view)
}

impl Scene {
    fn new(params: &CameraParams, class: Class, seed: u64) -> Self {
        let mut rng = StdRng::seed_from_u64(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xfa27);
        let part = Part::draw(&mut rng);
        let factor = match class {
            Class::Under => rng.random_range(0.6..0.88),
            Class::Over => rng.random_range(1.13..1.45),
            _ => rng.random_range(0.97..1.03),
        };
        Self {
            deposit: Deposit::new(params.field, params.geometry.scale_m()),
            part,
            at_m: [rng.random_range(0.02..0.2), rng.random_range(0.02..0.2)],
            width: Scatter { factor, offset: 0.0, sigma: rng.random_range(0.003..0.012) },
            shift_m: None,
            rng,
        }
    }

    fn lay_brim(&mut self) {
        let height_m = self.part.height_m;
        for line in self.part.brim() {
            let width_m = self.part.width_m * self.width.next(&mut self.rng);
            let bead = Bead { top_m: height_m, width_m, height_m };
            self.deposit.lay(self.placed(line.from_m), self.placed(line.to_m), bead);
        }
    }

    /// Solid ground under the part, as if many layers had been printed; returns its height `[m]`.
    fn pedestal(&mut self) -> f64 {
        if self.rng.random_bool(0.35) {
            return 0.0;
        }
        let height_m = self.rng.random_range(0.2e-3..8e-3);
        for line in self.part.layer(1, true) {
            let bead = Bead { top_m: height_m, width_m: self.part.width_m, height_m: self.part.height_m };
            self.deposit.lay(self.placed(line.from_m), self.placed(line.to_m), bead);
        }
        height_m
    }

    fn moved(&mut self, shifted: bool) {
        if shifted && self.shift_m.is_none() {
            let way_m =
                self.rng.random_range(0.4e-3..2.0e-3) * if self.rng.random_bool(0.5) { 1.0 } else { -1.0 };
            let choice = self.rng.random_range(0..3);
            self.shift_m = Some(match choice {
                0 => [way_m, 0.0],
                1 => [0.0, way_m],
                _ => [0.7 * way_m, 0.7 * way_m],
            });
        }
    }

    fn placed(&self, point_m: [f64; 2]) -> [f64; 2] {
        let shift_m = self.shift_m.unwrap_or_default();
        [0, 1].map(|axis| point_m[axis] + self.at_m[axis] + shift_m[axis])
    }

    /// Lays a share of a layer; returns the view at its end.
    fn lay_layer(&mut self, layer: u32, first_m: f64, share: f64) -> View {
        let solid = layer == 0 && first_m == 0.0;
        let lines = self.part.layer(layer, solid);
        let top_m = first_m + f64::from(layer + 1) * self.part.height_m;
        let total_m: f64 = lines.iter().map(Line::length_m).sum();
        let (mut left_m, speed_m_s) = (share * total_m, self.rng.random_range(0.015..0.09));
        let mut view = View { tool_m: [self.at_m[0], self.at_m[1], top_m], velocity_m_s: [0.0; 2] };
        for line in lines {
            let length_m = line.length_m();
            if left_m <= 0.0 || length_m <= 0.0 {
                break;
            }
            let part = (left_m / length_m).min(1.0);
            left_m -= length_m;
            let (from_m, full_m) = (self.placed(line.from_m), self.placed(line.to_m));
            let along = [0, 1].map(|axis| (full_m[axis] - from_m[axis]) / length_m);
            let to_m = [0, 1].map(|axis| from_m[axis] + part * length_m * along[axis]);
            let width_m = self.part.width_m * self.width.next(&mut self.rng);
            self.deposit.lay(from_m, to_m, Bead { top_m, width_m, height_m: self.part.height_m });
            view =
                View { tool_m: [to_m[0], to_m[1], top_m], velocity_m_s: along.map(|part| part * speed_m_s) };
        }
        view
    }

    /// Draws what the class shows beside the roads.
    fn spoil(&mut self, class: Class, view: View, top_m: f64, strand_m: f64) {
        let near = |rng: &mut StdRng, reach_m: f64| {
            [0, 1].map(|axis| view.tool_m[axis] + rng.random_range(-reach_m..reach_m))
        };
        match class {
            Class::Spaghetti => {
                let mut tangle = Tangle::new(strand_m * self.rng.random_range(0.7..1.1), self.rng.random());
                let length_m = self.rng.random_range(0.06..0.5);
                for _ in 0..40 {
                    let at = near(&mut self.rng, 3e-3);
                    tangle.grow(
                        &mut self.deposit,
                        [at[0], at[1], top_m],
                        length_m / 40.0 * strand_m.powi(2) * 0.6,
                    );
                }
            }
            Class::Stringing => self.strings(view, top_m),
            Class::Blobs => {
                let points = self.seen_points(view);
                for _ in 0..self.rng.random_range(4..14) {
                    let on = points[self.rng.random_range(0..points.len())];
                    let at_m = on.map(|at_m| at_m + self.rng.random_range(-1e-3..1e-3));
                    let size_m = self.rng.random_range(0.5e-3..1.4e-3);
                    let height_m = self.rng.random_range(0.15e-3..0.5e-3);
                    blob(&mut self.deposit, at_m, (size_m, height_m), &mut self.rng);
                }
            }
            Class::Ok | Class::Under | Class::Over | Class::Shift => {}
        }
    }

    /// Ends of the part's roads that the camera sees and the head does not hide; the tool's place if there are none.
    fn seen_points(&self, view: View) -> Vec<[f64; 2]> {
        let away = |at: &[f64; 2]| [0, 1].map(|axis| (at[axis] - view.tool_m[axis]).abs());
        let seen = |at: &[f64; 2]| {
            let [x_m, y_m] = away(at);
            x_m < SEEN_M[0] && y_m < SEEN_M[1] && x_m.hypot(y_m) > HEAD_M
        };
        let ends = self.part.layer(0, false).into_iter().map(|line| self.placed(line.from_m));
        let mut points: Vec<[f64; 2]> = ends.filter(seen).collect();
        if points.is_empty() {
            points.push([view.tool_m[0], view.tool_m[1]]);
        }
        points
    }

    /// Strings of travels between points of the part, or to another part outside of the picture.
    fn strings(&mut self, view: View, top_m: f64) {
        let points = self.seen_points(view);
        let other = self.rng.random_range(0.0..std::f64::consts::TAU);
        for _ in 0..self.rng.random_range(5..18) {
            let [from_m, mut to_m] = [0, 1].map(|_| points[self.rng.random_range(0..points.len())]);
            let apart_m = (to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1]);
            if self.rng.random_bool(0.6) || apart_m < HEAD_M {
                let (angle, way_m) =
                    (other + self.rng.random_range(-0.25..0.25), self.rng.random_range(0.008..0.025));
                to_m = [from_m[0] + way_m * angle.cos(), from_m[1] + way_m * angle.sin()];
            }
            let size_m = self.rng.random_range(0.05e-3..0.16e-3);
            string(&mut self.deposit, (from_m, to_m), (size_m, top_m), &mut self.rng);
        }
    }

    fn shoot(self, params: &CameraParams, (style, class, seed): (Style, Class, u64), view: View) -> Example {
        let mut renderer = Renderer::new(params.geometry, Look::draw(params.ranges(style), seed));
        Example {
            frame: renderer.render(&self.deposit, &view),
            jpeg_quality: renderer.look().jpeg_quality,
            class,
            width_m: self.part.width_m * self.width.factor,
            target_width_m: self.part.width_m,
            layer_height_m: self.part.height_m,
            pitch_m: self.part.pitch_m(),
            shift_m: self.shift_m.unwrap_or_default(),
            view,
        }
    }
}

impl Scatter {
    fn next(&mut self, rng: &mut StdRng) -> f64 {
        let normal: f64 = StandardNormal.sample(rng);
        self.offset = 0.8 * self.offset + 0.6 * self.sigma * normal;
        self.factor + self.offset
    }
}

impl Line {
    fn length_m(&self) -> f64 {
        (self.to_m[0] - self.from_m[0]).hypot(self.to_m[1] - self.from_m[1])
    }
}
