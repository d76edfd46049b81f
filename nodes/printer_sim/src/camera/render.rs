//! From the height field to a grey picture.

use super::cast::{count, floor, index, signed, single};
use super::deposit::Deposit;
use super::geometry::Geometry;
use super::head::Head;
use super::image::Frame;
use super::lens::{self, REACH, Sensor};
use super::look::Look;
use super::shade::{Rows, Shader};
use super::texture::{self, SIDE};
use rand::{Rng, SeedableRng, rngs::StdRng};

/// How far the surroundings reach that darken a cell `[m]`: about a road's width.
const SURROUNDINGS_M: f64 = 3.0e-4;
/// How far towards the light a cell looks for what stands in its way `[m]`.
const SHADOW_M: f64 = 1.2e-4;
/// Height that counts as one in occlusion `[m]`: a usual layer.
const LAYER_M: f64 = 2.0e-4;
/// Length of the sensor's noise before it repeats; every row begins elsewhere in it.
const NOISE_LENGTH: usize = 1 << 16;

/// Where the tool is while the shutter is open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Nozzle tip at the middle of the exposure, true bed frame `[m]`.
    pub tool_m: [f64; 3],
    /// Its velocity over the bed `[m/s]`.
    pub velocity_m_s: [f64; 2],
}

/// Draws frames of one camera. Keeps its buffers, so that a frame allocates only its own pixels.
pub struct Renderer {
    geometry: Geometry,
    look: Look,
    head: Head,
    shader: Shader,
    sensor: Sensor,
    bed: Vec<f32>,
    noise: Vec<f32>,
    rng: StdRng,
    heights: Vec<f32>,
    sums: Vec<f32>,
    means: Vec<f32>,
    shaded: Vec<f32>,
    smeared: Vec<f32>,
}

impl Renderer {
    /// A camera with this look.
    #[must_use]
    pub fn new(geometry: Geometry, look: Look) -> Self {
        let cell_m = geometry.scale_m();
        let rise = single(SHADOW_M / cell_m) * look.light[2] / look.light[0].hypot(look.light[1]).max(0.05);
        let occlusion = look.occlusion * single(cell_m / LAYER_M);
        let distance = single(cell_m / geometry.working_distance_m());
        Self {
            head: Head::new(&geometry, &look),
            shader: Shader::new(&look, occlusion, distance, rise),
            sensor: Sensor {
                gain: look.gain,
                vignette: look.vignette,
                noise_grey: look.noise_grey,
                noise_share: look.noise_share,
                across2: Sensor::columns(geometry.width_px(), geometry.height_px()),
            },
            bed: texture::tile(look.bed_kind, look.seed),
            noise: texture::white(look.seed, NOISE_LENGTH),
            rng: StdRng::seed_from_u64(look.seed ^ 0x5eed),
            heights: Vec::new(),
            sums: Vec::new(),
            means: Vec::new(),
            shaded: Vec::new(),
            smeared: Vec::new(),
            geometry,
            look,
        }
    }

    /// Image size and scale.
    #[must_use]
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// The camera's draw.
    #[must_use]
    pub fn look(&self) -> &Look {
        &self.look
    }

    /// What the camera sees of `deposit`, whose cells must be as wide as a pixel.
    pub fn render(&mut self, deposit: &Deposit, view: &View) -> Frame {
        let cell_m = self.geometry.scale_m();
        let [cx, cy] = self.geometry.principal_px();
        // Where pixel (0, 0) lies, in cells to the right and downwards from the origin; cell centres are at halves.
        let left = view.tool_m[0] / cell_m - cx - 0.5;
        let down = -view.tool_m[1] / cell_m - cy + 0.5;
        let whole = [left, down].map(floor);
        let share = [single(left - f64::from(whole[0])), single(down - f64::from(whole[1]))];

        let moved = [0, 1].map(|axis| {
            let sign = if axis == 0 { -1.0 } else { 1.0 };
            single(sign * view.velocity_m_s[axis] * self.look.exposure_s / cell_m)
        });
        let (trail, trail_reach) = lens::trail(moved);
        let surroundings = index(floor(SURROUNDINGS_M / cell_m)).max(1);
        let margin = REACH + trail_reach;
        let (width, height) = (self.geometry.width_px(), self.geometry.height_px());
        let shaded = (width + 2 * margin, height + 2 * margin);
        let pad = surroundings + 1;
        let field = (shaded.0 + 2 * pad, shaded.1 + 2 * pad);

        self.heights.resize(field.0 * field.1, 0.0);
        let corner = [0, 1].map(|axis| whole[axis] - signed(margin + pad));
        deposit.window((corner[0], -corner[1]), field.0, &mut self.heights);
        self.average(field, surroundings);
        self.shader.tip = single(view.tool_m[2] / cell_m);
        self.shade(field, shaded, (corner, pad));
        self.smeared.resize((width + 2 * REACH) * (height + 2 * REACH), 0.0);
        lens::smear(&self.shaded, shaded.0, (&trail, trail_reach), &mut self.smeared);
        self.expose(share)
    }

    /// Mean height over a square around each cell, by running sums; its outer cells are left as they are.
    fn average(&mut self, (width, height): (usize, usize), reach: usize) {
        let side = 2 * reach + 1;
        self.sums.clear();
        self.sums.resize(width, 0.0);
        self.means.resize(width * height, 0.0);
        let inverse = 1.0 / count(side * side);
        for y in 0..height {
            let (sums, heights) = (&mut self.sums, &self.heights);
            for (sum, value) in sums.iter_mut().zip(&heights[y * width..(y + 1) * width]) {
                *sum += value;
            }
            if y + 1 < side {
                continue;
            }
            let out = &mut self.means[(y - reach) * width..(y - reach + 1) * width];
            let mut run: f32 = sums[..side - 1].iter().sum();
            for x in reach..width - reach {
                run += sums[x + reach];
                out[x] = run * inverse;
                run -= sums[x - reach];
            }
            let last = (y + 1 - side) * width;
            for (sum, value) in sums.iter_mut().zip(&heights[last..last + width]) {
                *sum -= value;
            }
        }
    }

    fn shade(&mut self, field: (usize, usize), shaded: (usize, usize), (corner, pad): ([i32; 2], usize)) {
        let step = single(SHADOW_M / self.geometry.scale_m());
        let flat = self.look.light[0].hypot(self.look.light[1]).max(1e-3);
        let lightward = [self.look.light[0], -self.look.light[1]]
            .map(|part| floor(f64::from(step * part / flat) + 0.5).clamp(1 - signed(pad), signed(pad) - 1));
        self.shaded.resize(shaded.0 * shaded.1, 0.0);
        let row = |y: usize| y * field.0 + pad - 1;
        for (y, out) in self.shaded.chunks_exact_mut(shaded.0).enumerate() {
            let at = row(y + pad);
            let light = index(signed(at) + lightward[0] + lightward[1] * signed(field.0));
            let wide = shaded.0 + 2;
            let texture_row = index((corner[1] + signed(y + pad)).rem_euclid(signed(SIDE)));
            let phase = index((corner[0] + signed(pad) - 1).rem_euclid(signed(SIDE)));
            let rows = Rows {
                above: &self.heights[at - field.0..][..wide],
                row: &self.heights[at..][..wide],
                below: &self.heights[at + field.0..][..wide],
                mean: &self.means[at..][..wide],
                lightward: &self.heights[light..][..wide],
                texture: (&self.bed[texture_row * SIDE..][..SIDE], phase),
            };
            self.shader.shade(&rows, out);
        }
    }

    fn expose(&mut self, share: [f32; 2]) -> Frame {
        let (width, height) = (self.geometry.width_px(), self.geometry.height_px());
        let kernels = share.map(|share| lens::kernel(self.look.blur_px, share));
        let stride = width + 2 * REACH;
        let half = count(width).hypot(count(height)) / 2.0;
        let mut grey = vec![0; width * height];
        let mut tall = vec![0.0; stride];
        let mut row = vec![0.0; width];
        for (v, out) in grey.chunks_exact_mut(width).enumerate() {
            // The first tap is two cells before the pixel, the margin is three.
            let from = (v + REACH - 2) * stride;
            lens::down(&self.smeared[from..], stride, &kernels[1], &mut tall);
            lens::across(&tall[REACH - 2..], &kernels[0], &mut row);
            self.head.draw(v, &mut row);
            let down2 = ((count(v) - (count(height) - 1.0) / 2.0) / half).powi(2);
            let begin = self.rng.random_range(0..NOISE_LENGTH - width);
            self.sensor.expose(&row, down2, &self.noise[begin..begin + width], out);
        }
        Frame { width_px: width, height_px: height, grey }
    }
}
