//! Power over spatial frequency: rings, how much one direction stands out, and the peak of evenly laid roads.

use super::picture::{Picture, Plane};
use opencv::core::{self, Mat, MatTraitConstManual};

pub(super) const NAMES: [&str; 13] = [
    "ring_0",
    "ring_1",
    "ring_2",
    "ring_3",
    "ring_4",
    "ring_5",
    "ring_6",
    "ring_7",
    "sector_max",
    "sector_entropy",
    "pitch_peak",
    "pitch_freq",
    "pitch_second",
];
const RINGS: usize = 8;
const SECTORS: usize = 12;
/// Outer edges of the rings `[cycles/px]`, an octave's half apart.
const RING_EDGES: [f64; RINGS] = [0.022, 0.031, 0.044, 0.0625, 0.088, 0.125, 0.177, 0.25];
/// Band in which roads repeat `[cycles/px]`.
const PITCH_BAND: (f64, f64) = (0.06, 0.24);

/// Sums over the half plane of frequencies.
struct Sums {
    rings: [f64; RINGS],
    sectors: [f64; SECTORS],
    band: f64,
    band_count: f64,
    peak: (f64, usize, usize),
}

pub(super) fn of(picture: &Picture) -> opencv::Result<[f64; 13]> {
    let plane = &picture.smooth;
    let power = power(plane)?;
    let sums = summed(plane, &power);
    let total: f64 = sums.rings.iter().sum::<f64>().max(1e-12);
    let turned: f64 = sums.sectors.iter().sum::<f64>().max(1e-12);
    let mut values = [0.0; 13];
    for (value, ring) in values.iter_mut().zip(&sums.rings) {
        *value = (ring / total).max(1e-6).ln();
    }
    values[8] = sums.sectors.iter().copied().fold(0.0, f64::max) / turned;
    values[9] = -sums.sectors.iter().map(|power| power / turned * (power / turned + 1e-9).ln()).sum::<f64>();
    let (peak, column, row) = sums.peak;
    let mean = (sums.band / sums.band_count.max(1.0)).max(1e-12);
    let (across, down) = frequency(plane, column, row);
    values[10] = (peak / mean).max(1.0).ln();
    values[11] = across.hypot(down);
    values[12] = (second(plane, &power, (column, row)) / peak.max(1e-12)).clamp(1e-5, 1e2).ln();
    Ok(values)
}

/// Squared magnitudes, row by row, of the plane less its mean under a Hann window.
fn power(plane: &Plane) -> opencv::Result<Vec<f32>> {
    let level = plane.mean();
    let window = |length: usize| -> Vec<f64> {
        #[expect(clippy::cast_precision_loss, reason = "pixels of a small picture")]
        let share = |place: usize| (place as f64 + 0.5) / length as f64;
        (0..length).map(|place| (std::f64::consts::PI * share(place)).sin().powi(2)).collect()
    };
    let (across, down) = (window(plane.width), window(plane.height));
    let mut windowed = Vec::with_capacity(plane.values.len());
    for (row, levels) in plane.values.chunks_exact(plane.width).enumerate() {
        for (value, weight) in levels.iter().zip(&across) {
            #[expect(clippy::cast_possible_truncation, reason = "single precision is meant")]
            windowed.push(((f64::from(*value) - level) * weight * down[row]) as f32);
        }
    }
    let rows = i32::try_from(plane.height).unwrap_or(i32::MAX);
    let flat = Mat::from_slice(&windowed)?;
    let source = opencv::core::MatTraitConst::reshape(&flat, 1, rows)?;
    let mut spectrum = Mat::default();
    core::dft(&source, &mut spectrum, core::DFT_COMPLEX_OUTPUT, 0)?;
    let pairs = spectrum.data_typed::<core::Vec2f>()?;
    Ok(pairs.iter().map(|pair| pair[0] * pair[0] + pair[1] * pair[1]).collect())
}

/// Frequency of a place of the spectrum `[cycles/px]`, across and down.
fn frequency(plane: &Plane, column: usize, row: usize) -> (f64, f64) {
    #[expect(clippy::cast_precision_loss, reason = "pixels of a small picture")]
    let share = |place: usize, length: usize| {
        let share = place as f64 / length as f64;
        if share > 0.5 { share - 1.0 } else { share }
    };
    (share(column, plane.width), share(row, plane.height))
}

fn summed(plane: &Plane, power: &[f32]) -> Sums {
    let mut sums =
        Sums { rings: [0.0; RINGS], sectors: [0.0; SECTORS], band: 0.0, band_count: 0.0, peak: (0.0, 0, 0) };
    for row in 0..plane.height {
        for column in 0..=plane.width / 2 {
            let (across, down) = frequency(plane, column, row);
            let radius = (across * across + down * down).sqrt();
            let Some(ring) = RING_EDGES.iter().position(|edge| radius < *edge) else { continue };
            let value = f64::from(power[row * plane.width + column]);
            sums.rings[ring] += value;
            if radius < PITCH_BAND.0 || radius > PITCH_BAND.1 {
                continue;
            }
            sums.sectors[sector(across, down)] += value;
            sums.band += value;
            sums.band_count += 1.0;
            if value > sums.peak.0 {
                sums.peak = (value, column, row);
            }
        }
    }
    sums
}

fn sector(across: f64, down: f64) -> usize {
    #[expect(clippy::cast_precision_loss, reason = "a small constant")]
    let turns = (down.atan2(across) / std::f64::consts::PI + 0.5) * SECTORS as f64;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "in [0, SECTORS] by construction"
    )]
    let sector = turns as usize;
    sector.min(SECTORS - 1)
}

/// Largest power around twice the frequency of a place: gaps between roads make the roads' profile less of a sine.
fn second(plane: &Plane, power: &[f32], (column, row): (usize, usize)) -> f64 {
    let mut largest = 0.0_f64;
    for (off_column, off_row) in (0..5).flat_map(|x| (0..5).map(move |y| (x, y))) {
        let (column, row) = (2 * column + off_column, 2 * row + off_row + 2 * plane.height);
        let (column, row) = (column.saturating_sub(2), (row - 2) % plane.height);
        if column <= plane.width / 2 {
            largest = largest.max(f64::from(power[row * plane.width + column]));
        }
    }
    largest
}
