//! Light on a height field, row by row in loops that the compiler turns into vector code.

use super::look::Look;
use super::texture::SIDE;

/// Steepest slope that is told apart; a wall is as dark as this.
const SLOPE_MAX: f32 = 4.0;
/// Darkest that an enclosed spot becomes.
const OCCLUDED: f32 = 0.25;
/// Light of the main lamp that a cast shadow takes.
const SHADOW: f32 = 0.55;
/// Heights are in cells; what is lower than this is bed.
const BED: f32 = 0.2;

/// The three rows of heights around a row, its mean surroundings, and what it casts a shadow on.
pub(super) struct Rows<'a> {
    pub(super) above: &'a [f32],
    pub(super) row: &'a [f32],
    pub(super) below: &'a [f32],
    /// Mean height around each cell.
    pub(super) mean: &'a [f32],
    /// The row towards the light, shifted so that the same index is `reach` cells nearer to it.
    pub(super) lightward: &'a [f32],
    /// Row of the bed's texture, and the cell in it that the row begins with.
    pub(super) texture: (&'a [f32], usize),
}

/// What does not change over a frame.
pub(super) struct Shader {
    look: Look,
    half: [[f32; 3]; 2],
    soft: f32,
    /// Height of the tool's tip in cells.
    pub(super) tip: f32,
    /// Working distance in cells, inverse.
    pub(super) inverse_distance: f32,
    /// Height that a shadow's ray gains on its way of `reach` cells.
    pub(super) rise: f32,
    /// Occlusion per cell of height below the surroundings.
    pub(super) occlusion: f32,
}

impl Shader {
    pub(super) fn new(look: &Look, occlusion: f32, inverse_distance: f32, rise: f32) -> Self {
        let half = [look.light, look.fill].map(|light| {
            // Blinn: between light and eye, the eye being straight above.
            let sum = [light[0], light[1], light[2] + 1.0];
            let norm = (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt();
            sum.map(|part| part / norm)
        });
        let soft = look.gloss_log2 - look.gloss_log2.floor();
        Self { look: look.clone(), half, soft, tip: 0.0, inverse_distance, rise, occlusion }
    }

    /// Grey shares of a row; the rows of heights begin one cell before it and end one after.
    pub(super) fn shade(&self, rows: &Rows<'_>, out: &mut [f32]) {
        match self.look.gloss_log2.floor() {
            power if power < 3.0 => self.with_power::<2>(rows, out),
            power if power < 4.0 => self.with_power::<3>(rows, out),
            power if power < 5.0 => self.with_power::<4>(rows, out),
            _ => self.with_power::<5>(rows, out),
        }
    }

    fn with_power<const POWER: u32>(&self, rows: &Rows<'_>, out: &mut [f32]) {
        let wide = out.len() + 2;
        let (above, row, below) = (&rows.above[..wide], &rows.row[..wide], &rows.below[..wide]);
        let (mean, lightward) = (&rows.mean[..wide], &rows.lightward[..wide]);
        let (texture, phase) = rows.texture;
        let mut from = 1;
        // The texture repeats: runs up to its end keep the inner loop free of a remainder.
        while from + 1 < wide {
            let run = (wide - 1 - from).min(SIDE - (phase + from) % SIDE);
            let grain = &texture[(phase + from) % SIDE..][..run];
            let (north, south) = (&above[from - 1..][..run + 2], &below[from - 1..][..run + 2]);
            let here = &row[from - 1..][..run + 2];
            let (mean, lightward) = (&mean[from..][..run], &lightward[from..][..run]);
            for (x, out) in out[from - 1..][..run].iter_mut().enumerate() {
                let z = here[x + 1];
                // Sobel, in cells per cell.
                let gx = (north[x + 2] - north[x] + south[x + 2] - south[x] + 2.0 * (here[x + 2] - here[x]))
                    * 0.125;
                let gy = (north[x] + north[x + 2] - south[x] - south[x + 2]
                    + 2.0 * (north[x + 1] - south[x + 1]))
                    * 0.125;
                let occluded = ((z - mean[x]) * self.occlusion + 1.0).clamp(OCCLUDED, 1.0);
                let shadow = 1.0 - SHADOW * (lightward[x] - z - self.rise).clamp(0.0, 1.0);
                *out = self.cell::<POWER>((gx, gy), z, grain[x], (occluded, shadow));
            }
            from += run;
        }
    }

    #[inline(always)]
    fn cell<const POWER: u32>(&self, (gx, gy): (f32, f32), z: f32, grain: f32, dim: (f32, f32)) -> f32 {
        let look = &self.look;
        let (nx, ny) = (-gx.clamp(-SLOPE_MAX, SLOPE_MAX), -gy.clamp(-SLOPE_MAX, SLOPE_MAX));
        let inverse = 1.0 / (1.0 + nx * nx + ny * ny).sqrt();
        let towards = |to: &[f32; 3]| (nx * to[0] + ny * to[1] + to[2]) * inverse;
        let lit = |to: &[f32; 3]| (towards(to) * (1.0 - look.wrap) + look.wrap).max(0.0);
        let shine = |to: &[f32; 3]| {
            let mut power = towards(to).max(0.0);
            for _ in 0..POWER {
                power *= power;
            }
            // Between two powers of two: a straight line.
            power + self.soft * (power * power - power)
        };
        let main = look.light_share * lit(&look.light) * dim.1;
        let diffuse = main + look.fill_share * lit(&look.fill) + look.ambient_share;
        let gloss = look.gloss * (shine(&self.half[0]) * dim.1 + 0.3 * shine(&self.half[1]));
        let plastic = look.filament_grey * (1.0 + look.filament_grain * grain) * diffuse + gloss;
        let bed = look.bed_grey * (1.0 + look.bed_texture * grain) * diffuse;
        let depth = (1.0 - 2.0 * (self.tip - z) * self.inverse_distance).clamp(0.3, 1.0);
        let own = if z > BED { plastic } else { bed };
        own * dim.0 * depth
    }
}
