//! The head in the picture: nozzle with its tip, and the soft shadow around it. It does not move in the image.

use super::cast::{floor, index, number, signed, single};
use super::geometry::Geometry;
use super::look::Look;

/// Pixels of the head: `value` in grey shares and how much of what lies below shines through.
pub(super) struct Head {
    left: usize,
    top: usize,
    width: usize,
    value: Vec<f32>,
    through: Vec<f32>,
}

/// Shadow's reach beyond the disc, in radii.
const SHADOW_REACH: f32 = 0.5;
/// Light that the head takes away at its rim.
const SHADOW: f32 = 0.45;
/// Softness of the rim `[px]`.
const RIM_PX: f32 = 1.5;

impl Head {
    pub(super) fn new(geometry: &Geometry, look: &Look) -> Self {
        let radius = single(look.nozzle_radius_m / geometry.scale_m());
        let reach = index(floor(f64::from(radius * (1.0 + SHADOW_REACH)))) + 2;
        let [cx, cy] = geometry.principal_px();
        let span = |centre: f64, limit: usize| {
            let first = index(floor(centre) - signed(reach)).min(limit);
            (first, (index(floor(centre)) + reach + 1).min(limit))
        };
        let (left, right) = span(cx, geometry.width_px());
        let (top, bottom) = span(cy, geometry.height_px());
        let (mut value, mut through) = (Vec::new(), Vec::new());
        for v in top..bottom {
            for u in left..right {
                let x = (number(signed(u)) - single(cx)) / radius;
                let y = -(number(signed(v)) - single(cy)) / radius;
                let opaque = ((1.0 - x.hypot(y)) * radius / RIM_PX + 0.5).clamp(0.0, 1.0);
                value.push(opaque * look.nozzle_grey * shade(x, y, look));
                // The shadow falls away from the light.
                let (sx, sy) = (x + 0.25 * look.light[0], y + 0.25 * look.light[1]);
                let near = ((1.0 + SHADOW_REACH - sx.hypot(sy)) / SHADOW_REACH).clamp(0.0, 1.0);
                through.push((1.0 - opaque) * (1.0 - SHADOW * near * near * (3.0 - 2.0 * near)));
            }
        }
        Self { left, top, width: right - left, value, through }
    }

    /// Draws the head over row `v` of the image.
    pub(super) fn draw(&self, v: usize, row: &mut [f32]) {
        if v < self.top || (v - self.top + 1) * self.width > self.value.len() {
            return;
        }
        let from = (v - self.top) * self.width;
        let target = &mut row[self.left..self.left + self.width];
        let head = self.value[from..from + self.width].iter().zip(&self.through[from..from + self.width]);
        for (pixel, (value, through)) in target.iter_mut().zip(head) {
            *pixel = *pixel * through + value;
        }
    }
}

/// A turned cone around a flat tip with its bore, in radii of the disc.
fn shade(x: f32, y: f32, look: &Look) -> f32 {
    let radius = x.hypot(y);
    if radius < 0.13 {
        return 0.12;
    }
    if radius < 0.36 {
        return 0.9 + 0.05 * (radius * 90.0).sin();
    }
    // The cone's flank falls at 60 degrees; grooves of the tool that turned it.
    let (nx, ny, nz) = (0.87 * x / radius, 0.87 * y / radius, 0.5);
    let lit = (nx * look.light[0] + ny * look.light[1] + nz * look.light[2]).max(0.0);
    let groove = 0.04 * (radius * 60.0).sin();
    let edge = if radius > 0.93 { 0.7 } else { 1.0 };
    (0.3 + 0.75 * lit + 0.9 * lit.powi(6) + groove) * edge
}
