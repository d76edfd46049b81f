//! Local binary patterns, rotation invariant and uniform (Ojala, Pietikainen and Maenpaa 2002), at two sizes.

use super::picture::{Picture, Plane};

pub(super) const NAMES: [&str; 20] = [
    "lbp_fine_0",
    "lbp_fine_1",
    "lbp_fine_2",
    "lbp_fine_3",
    "lbp_fine_4",
    "lbp_fine_5",
    "lbp_fine_6",
    "lbp_fine_7",
    "lbp_fine_8",
    "lbp_fine_mixed",
    "lbp_coarse_0",
    "lbp_coarse_1",
    "lbp_coarse_2",
    "lbp_coarse_3",
    "lbp_coarse_4",
    "lbp_coarse_5",
    "lbp_coarse_6",
    "lbp_coarse_7",
    "lbp_coarse_8",
    "lbp_coarse_mixed",
];
/// Uniform patterns by the number of brighter neighbours, and one bin for all others.
const BINS: usize = 10;
/// A neighbour has to be brighter by this share of full scale: below it is noise.
const NOISE: f32 = 0.012;

pub(super) fn of(picture: &Picture) -> [f64; 20] {
    let mut values = [0.0; 2 * BINS];
    values[..BINS].copy_from_slice(&histogram(&picture.smooth));
    values[BINS..].copy_from_slice(&histogram(&picture.coarse));
    values
}

fn histogram(plane: &Plane) -> [f64; BINS] {
    let bin_of = bins();
    let mut counts = [0_u32; BINS];
    let width = plane.width;
    for y in 1..plane.height - 1 {
        for x in 1..width - 1 {
            let at = y * width + x;
            let bar = plane.values[at] + NOISE;
            let around = [
                at - width - 1,
                at - width,
                at - width + 1,
                at + 1,
                at + width + 1,
                at + width,
                at + width - 1,
                at - 1,
            ];
            let mut pattern = 0_usize;
            for (bit, neighbour) in around.into_iter().enumerate() {
                pattern |= usize::from(plane.values[neighbour] > bar) << bit;
            }
            counts[bin_of[pattern]] += 1;
        }
    }
    let total = f64::from(counts.iter().sum::<u32>().max(1));
    counts.map(|count| f64::from(count) / total)
}

/// Bin of each of the 256 patterns.
fn bins() -> [usize; 256] {
    std::array::from_fn(|pattern| {
        let turned = (pattern >> 1) | ((pattern & 1) << 7);
        let changes = (pattern ^ turned).count_ones();
        let ones = pattern.count_ones() as usize;
        if changes <= 2 { ones } else { BINS - 1 }
    })
}
