//! Levels: how bright, how far apart, how evenly spread.

use super::picture::{CELLS, Picture, deviation, mean, quantile};

pub(super) const NAMES: [&str; 10] = [
    "level_mean",
    "level_std",
    "level_p05",
    "level_p50",
    "level_p95",
    "level_skew",
    "level_white",
    "level_black",
    "level_cell_std",
    "level_cell_span",
];
/// Levels above are white, below one less it black.
const WHITE: f64 = 0.97;

pub(super) fn of(picture: &Picture) -> [f64; 10] {
    let plane = &picture.coarse;
    let mut levels: Vec<f64> = plane.values.iter().map(|value| f64::from(*value)).collect();
    let level = mean(levels.iter().copied());
    let spread = deviation(&levels, level).max(1e-3);
    let skew = mean(levels.iter().map(|value| ((value - level) / spread).powi(3)));
    let share = |is: &dyn Fn(f64) -> bool| mean(levels.iter().map(|value| f64::from(u8::from(is(*value)))));
    let (white, black) = (share(&|value| value > WHITE), share(&|value| value < 1.0 - WHITE));
    let mut cells = vec![(0.0, 0.0); CELLS.0 * CELLS.1];
    for y in 0..plane.height {
        for x in 0..plane.width {
            let (sum, count) = &mut cells[plane.cell(x, y)];
            *sum += f64::from(plane.at(x, y));
            *count += 1.0;
        }
    }
    let mut cells: Vec<f64> = cells.iter().map(|(sum, count)| sum / count).collect();
    let cell_std = deviation(&cells, level) / spread;
    let cell_span = (quantile(&mut cells, 0.95) - quantile(&mut cells, 0.05)) / spread;
    let [p05, p50, p95] = [0.05, 0.5, 0.95].map(|share| quantile(&mut levels, share));
    [level, spread, p05, p50, p95, skew.clamp(-10.0, 10.0), white, black, cell_std, cell_span]
}
