//! Blur of motion and focus, shift to the pixel grid, vignetting, noise.

use super::cast::{count, floor, grey, index, number, signed, single};

/// Taps of the focus kernel: from two cells before to three after.
pub(super) const TAPS: usize = 6;
/// Cells that the kernel reaches beyond the image.
pub(super) const REACH: usize = 3;
/// Most positions that a moving exposure is summed over.
const MOTION_TAPS: f32 = 12.0;

/// A Gaussian of `sigma` cells around `share` of a cell after the third tap.
pub(super) fn kernel(sigma: f32, share: f32) -> [f32; TAPS] {
    let mut taps = [0.0; TAPS];
    for (step, tap) in taps.iter_mut().enumerate() {
        let away = number(signed(step)) - 2.0 - share;
        *tap = (-away * away / (2.0 * sigma * sigma)).exp();
    }
    let sum: f32 = taps.iter().sum();
    taps.map(|tap| tap / sum)
}

/// Whole-cell offsets that an exposure moves over, centred, and their largest reach.
pub(super) fn trail(moved_px: [f32; 2]) -> (Vec<[i32; 2]>, usize) {
    let length = moved_px[0].hypot(moved_px[1]);
    let taps = (length.ceil() + 1.0).min(MOTION_TAPS);
    let steps = index(floor(f64::from(taps))).max(1);
    let mut offsets: Vec<[i32; 2]> = (0..steps)
        .map(|step| {
            let share = if steps > 1 { count(step) / (count(steps) - 1.0) - 0.5 } else { 0.0 };
            moved_px.map(|moved| floor(f64::from(moved * share) + 0.5))
        })
        .collect();
    offsets.dedup();
    let reach = offsets.iter().flatten().map(|offset| offset.unsigned_abs()).max().unwrap_or(0);
    (offsets, usize::try_from(reach).unwrap_or(0))
}

/// Mean over the offsets: `out` is smaller than `source` by `reach` on every side.
pub(super) fn smear(source: &[f32], width: usize, (offsets, reach): (&[[i32; 2]], usize), out: &mut [f32]) {
    let inner = width - 2 * reach;
    let share = 1.0 / count(offsets.len());
    for (y, row) in out.chunks_exact_mut(inner).enumerate() {
        row.fill(0.0);
        for offset in offsets {
            let from = index(signed(y + reach) + offset[1]) * width + index(signed(reach) + offset[0]);
            for (sum, value) in row.iter_mut().zip(&source[from..from + inner]) {
                *sum += value * share;
            }
        }
    }
}

/// One row through the kernel: `out` has [`TAPS`] - 1 cells less than `source`.
pub(super) fn across(source: &[f32], kernel: &[f32; TAPS], out: &mut [f32]) {
    let width = out.len();
    let taps: [&[f32]; TAPS] = std::array::from_fn(|tap| &source[tap..tap + width]);
    for x in 0..width {
        let mut sum = 0.0;
        for tap in 0..TAPS {
            sum += kernel[tap] * taps[tap][x];
        }
        out[x] = sum;
    }
}

/// Rows one below the other through the kernel.
pub(super) fn down(rows: &[f32], stride: usize, kernel: &[f32; TAPS], out: &mut [f32]) {
    let width = out.len();
    let taps: [&[f32]; TAPS] = std::array::from_fn(|tap| &rows[tap * stride..tap * stride + width]);
    for x in 0..width {
        let mut sum = 0.0;
        for tap in 0..TAPS {
            sum += kernel[tap] * taps[tap][x];
        }
        out[x] = sum;
    }
}

/// What sensor and lens do to a row.
pub(super) struct Sensor {
    pub(super) gain: f32,
    pub(super) vignette: f32,
    pub(super) noise_grey: f32,
    pub(super) noise_share: f32,
    /// Squared distance from the image's middle by column, relative to the half diagonal.
    pub(super) across2: Vec<f32>,
}

impl Sensor {
    pub(super) fn columns(width: usize, height: usize) -> Vec<f32> {
        let half = single(f64::from(count(width)).hypot(f64::from(count(height))) / 2.0);
        (0..width).map(|u| ((count(u) - (count(width) - 1.0) / 2.0) / half).powi(2)).collect()
    }

    /// Grey levels of a row; `down2` is the row's squared distance from the middle.
    pub(super) fn expose(&self, row: &[f32], down2: f32, noise: &[f32], out: &mut [u8]) {
        let columns = self.across2.iter().zip(noise);
        for ((level, (across2, noise)), out) in row.iter().zip(columns).zip(out) {
            let lit = level * self.gain * (1.0 - self.vignette * (across2 + down2));
            // Bright pixels saturate softly, as a sensor's curve does.
            let lit = if lit > 0.8 { 0.8 + (lit - 0.8) * 0.5 } else { lit };
            *out = grey(255.0 * (lit + noise * (self.noise_grey + self.noise_share * lit)));
        }
    }
}
