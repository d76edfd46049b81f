//! Surfaces of beds: tiles of 256 x 256 cells that repeat without a seam.

use super::cast::{count, single};
use super::params::TextureKind;
use rand::{Rng, SeedableRng, rngs::StdRng};
use rand_distr::{Distribution, StandardNormal};

/// Cells to a side.
pub(super) const SIDE: usize = 256;

/// Values of about unit spread around zero.
pub(super) fn tile(kind: TextureKind, seed: u64) -> Vec<f32> {
    let rng = &mut StdRng::seed_from_u64(seed ^ 0x7e47);
    let mut tile = match kind {
        TextureKind::Grain => mixed(&[(noise(rng, 2, 2), 0.8), (noise(rng, 6, 6), 0.6)]),
        TextureKind::Brushed => mixed(&[(noise(rng, 40, 1), 0.9), (noise(rng, 3, 3), 0.3)]),
        TextureKind::Smears => mixed(&[(noise(rng, 60, 30), 0.9), (noise(rng, 4, 4), 0.2)]),
        TextureKind::Weave => mixed(&[(weave(), 0.9), (noise(rng, 2, 2), 0.3)]),
        TextureKind::Dots => mixed(&[(dots(rng), 1.0), (noise(rng, 2, 2), 0.25)]),
    };
    let mean = tile.iter().sum::<f32>() / count(tile.len());
    tile.iter_mut().for_each(|value| *value = (*value - mean).clamp(-2.5, 2.5));
    tile
}

/// White noise as a stream, for the sensor.
pub(super) fn white(seed: u64, length: usize) -> Vec<f32> {
    let rng = &mut StdRng::seed_from_u64(seed ^ 0x3015e);
    (0..length).map(|_| StandardNormal.sample(rng)).collect()
}

fn mixed(parts: &[(Vec<f32>, f32)]) -> Vec<f32> {
    let mut sum = vec![0.0; SIDE * SIDE];
    for (part, share) in parts {
        let spread = (part.iter().map(|value| value * value).sum::<f32>() / count(part.len())).sqrt();
        sum.iter_mut().zip(part).for_each(|(sum, value)| *sum += share * value / spread.max(1e-6));
    }
    sum
}

/// White noise, averaged over `(along_x, along_y)` cells.
fn noise(rng: &mut StdRng, along_x: usize, along_y: usize) -> Vec<f32> {
    let raw: Vec<f32> = (0..SIDE * SIDE).map(|_| StandardNormal.sample(rng)).collect();
    let at = |values: &[f32], x: usize, y: usize| values[(y % SIDE) * SIDE + x % SIDE];
    let each = |read: &dyn Fn(usize, usize) -> f32| -> Vec<f32> {
        (0..SIDE * SIDE).map(|cell| read(cell % SIDE, cell / SIDE)).collect()
    };
    let smooth = each(&|x, y| (0..along_x).map(|step| at(&raw, x + step, y)).sum());
    each(&|x, y| (0..along_y).map(|step| at(&smooth, x, y + step)).sum())
}

fn weave() -> Vec<f32> {
    let wave = |step: usize| single((std::f64::consts::TAU * f64::from(count(step)) / 32.0).sin());
    (0..SIDE * SIDE)
        .map(|cell| {
            let (x, y) = (cell % SIDE, cell / SIDE);
            if (x / 32 + y / 32) % 2 == 0 { wave(x).abs() } else { wave(y).abs() }
        })
        .collect()
}

fn dots(rng: &mut StdRng) -> Vec<f32> {
    let mut tile = vec![0.0; SIDE * SIDE];
    for _ in 0..90 {
        let (x, y, r) = (rng.random_range(0..SIDE), rng.random_range(0..SIDE), rng.random_range(2..6_usize));
        for dy in 0..=2 * r {
            for dx in 0..=2 * r {
                if dx.abs_diff(r).pow(2) + dy.abs_diff(r).pow(2) <= r * r {
                    tile[((y + dy) % SIDE) * SIDE + (x + dx) % SIDE] = 1.0;
                }
            }
        }
    }
    tile
}
