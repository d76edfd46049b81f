//! Directions: how the gradient's orientations are spread over the picture, and how well each cell agrees in itself.
//!
//! Orientation and coherence of a cell come from its structure tensor: `tan 2a = 2 Jxy / (Jxx - Jyy)`,
//! coherence `sqrt((Jxx - Jyy)^2 + 4 Jxy^2) / (Jxx + Jyy)` (Bigun and Granlund 1987).

use super::picture::{CELLS, Picture, Plane, deviation, mean, quantile};

pub(super) const NAMES: [&str; 19] = [
    "grad_0",
    "grad_1",
    "grad_2",
    "grad_3",
    "grad_4",
    "grad_5",
    "grad_6",
    "grad_7",
    "grad_entropy",
    "grad_energy",
    "coh_mean",
    "coh_std",
    "coh_p10",
    "coh_weighted",
    "concord_2",
    "concord_4",
    "cell_energy_std",
    "cell_energy_max",
    "cell_quiet",
];
const BINS: usize = 8;
/// A cell with less than this share of the mean energy is quiet.
const QUIET: f64 = 0.2;

/// Structure tensor of a cell.
#[derive(Clone, Copy, Default)]
struct Tensor {
    xx: f64,
    yy: f64,
    xy: f64,
    count: f64,
}

impl Tensor {
    fn energy(&self) -> f64 {
        (self.xx + self.yy) / self.count.max(1.0)
    }

    /// Vector of the doubled orientation; its length is the coherence.
    fn doubled(&self) -> [f64; 2] {
        let sum = (self.xx + self.yy).max(1e-12);
        [(self.xx - self.yy) / sum, 2.0 * self.xy / sum]
    }

    fn coherence(&self) -> f64 {
        let [along, across] = self.doubled();
        along.hypot(across)
    }
}

pub(super) fn of(picture: &Picture) -> [f64; 19] {
    let (cells, bins) = tensors(&picture.smooth);
    let histogram = turned(&bins);
    let entropy = -histogram.iter().map(|share| share * (share + 1e-9).ln()).sum::<f64>();
    let energies: Vec<f64> = cells.iter().map(Tensor::energy).collect();
    let energy = mean(energies.iter().copied()).max(1e-12);
    let mut coherences: Vec<f64> = cells.iter().map(Tensor::coherence).collect();
    let coherence = mean(coherences.iter().copied());
    let coherence_std = deviation(&coherences, coherence);
    let weighted = cells.iter().map(|cell| cell.energy() * cell.coherence()).sum::<f64>();
    let [concord_2, concord_4] = [1.0, 2.0].map(|times| concord(&cells, times));
    let mut values = [0.0; 19];
    values[..BINS].copy_from_slice(&histogram);
    values[BINS..].copy_from_slice(&[
        entropy,
        (energy / picture.variance).ln(),
        coherence,
        coherence_std,
        quantile(&mut coherences, 0.1),
        weighted / energies.iter().sum::<f64>().max(1e-12),
        concord_2,
        concord_4,
        deviation(&energies, energy) / energy,
        energies.iter().copied().fold(0.0, f64::max) / energy,
        mean(energies.iter().map(|cell| f64::from(u8::from(*cell < QUIET * energy)))),
    ]);
    values
}

/// Tensors of the cells, and the histogram of orientations weighted by the gradient's magnitude.
fn tensors(plane: &Plane) -> (Vec<Tensor>, [f64; BINS]) {
    let mut cells = vec![Tensor::default(); CELLS.0 * CELLS.1];
    let mut bins = [0.0; BINS];
    for y in 1..plane.height - 1 {
        for x in 1..plane.width - 1 {
            let across = f64::from(plane.at(x + 1, y) - plane.at(x - 1, y));
            let down = f64::from(plane.at(x, y + 1) - plane.at(x, y - 1));
            let cell = &mut cells[plane.cell(x, y)];
            cell.xx += across * across;
            cell.yy += down * down;
            cell.xy += across * down;
            cell.count += 1.0;
            bins[bin(across, down)] += (across * across + down * down).sqrt();
        }
    }
    (cells, bins)
}

/// Bin of an orientation in the half turn, by its octants' slopes: cheaper than an angle.
fn bin(across: f64, down: f64) -> usize {
    /// tan(pi/8).
    const STEEP: f64 = std::f64::consts::SQRT_2 - 1.0;
    let (across, down) =
        if down < 0.0 || (down == 0.0 && across < 0.0) { (-across, -down) } else { (across, down) };
    // Angle in [0, pi): first quadrant, else turned back by a quarter.
    let (quarter, run, rise) = if across > 0.0 { (0, across, down) } else { (4, down, -across) };
    let octant = if rise < STEEP * run {
        0
    } else if rise < run {
        1
    } else if rise * STEEP < run {
        2
    } else {
        3
    };
    quarter + octant
}

/// The histogram as shares, turned so that the largest bin comes first.
fn turned(bins: &[f64; BINS]) -> [f64; BINS] {
    let sum = bins.iter().sum::<f64>().max(1e-9);
    let first = (0..BINS).fold(0, |best, place| if bins[place] > bins[best] { place } else { best });
    std::array::from_fn(|place| bins[(first + place) % BINS] / sum)
}

/// Length of the mean of the cells' orientations times two (`times` 1) or four (`times` 2), weighted by energy and
/// coherence: 1 where all cells point one way, for `times` 2 also where they stand square to each other.
fn concord(cells: &[Tensor], times: f64) -> f64 {
    let (mut sum, mut total) = ([0.0, 0.0], 0.0);
    for cell in cells {
        let [along, across] = cell.doubled();
        let weight = cell.coherence() * cell.energy();
        let angle_rad = times * across.atan2(along);
        sum[0] += weight * angle_rad.cos();
        sum[1] += weight * angle_rad.sin();
        total += weight;
    }
    sum[0].hypot(sum[1]) / total.max(1e-12)
}
