//! The top of the wall.

/// Height over the length of a wall, cell by cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    cell_m: f64,
    heights_m: Vec<f64>,
}

/// Beyond so many standard deviations a bell is nothing (3e-7 of its area lie outside).
const BELL_REACH: f64 = 5.0;

impl Surface {
    /// A flat wall; lengths above 0 `[m]`.
    #[must_use]
    pub fn flat(length_m: f64, cell_m: f64) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "lengths are checked")]
        let cells = (length_m / cell_m).round().max(1.0) as usize;
        Self { cell_m, heights_m: vec![0.0; cells] }
    }

    /// Heights of the cells `[m]`.
    #[must_use]
    pub fn heights_m(&self) -> &[f64] {
        &self.heights_m
    }

    /// Length of the wall `[m]`.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        #[allow(clippy::cast_precision_loss, reason = "far below 2^52 cells")]
        let cells = self.heights_m.len() as f64;
        cells * self.cell_m
    }

    /// Cell of a place; places beyond an end are reflected at it.
    #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss)]
    #[allow(clippy::cast_precision_loss, reason = "indices are far below 2^31")]
    fn reflected(&self, index: i64) -> usize {
        let last = self.heights_m.len() as i64 - 1;
        let folded = if index < 0 { -1 - index } else { index };
        let folded = if folded > last { 2 * last + 1 - folded } else { folded };
        folded.clamp(0, last) as usize
    }

    /// Height at a place `[m]`; the next cell's.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, reason = "a place on the wall")]
    pub fn height_m(&self, place_m: f64) -> f64 {
        self.heights_m[self.reflected((place_m / self.cell_m).floor() as i64)]
    }

    /// Adds an area `[m2]` as a bell around a place; nothing is lost at the ends.
    pub fn add_area(&mut self, place_m: f64, sigma_m: f64, area_m2: f64) {
        self.add_bell(place_m, sigma_m, |weight, sum, cell_m| weight / sum * area_m2 / cell_m);
    }

    /// Adds a bell of a height `[m]` around a place.
    pub fn add_height(&mut self, place_m: f64, sigma_m: f64, height_m: f64) {
        self.add_bell(place_m, sigma_m, |weight, _, _| weight * height_m);
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss, reason = "a place on the wall")]
    fn add_bell(&mut self, place_m: f64, sigma_m: f64, height: impl Fn(f64, f64, f64) -> f64) {
        let first = ((place_m - BELL_REACH * sigma_m) / self.cell_m).floor() as i64;
        let last = ((place_m + BELL_REACH * sigma_m) / self.cell_m).ceil() as i64;
        let weight = |index: i64| {
            let away = ((index as f64 + 0.5) * self.cell_m - place_m) / sigma_m;
            (-0.5 * away * away).exp()
        };
        let weights: Vec<(i64, f64)> = (first..=last).map(|index| (index, weight(index))).collect();
        let sum: f64 = weights.iter().map(|(_, weight)| weight).sum();
        for (index, weight) in weights {
            let cell = self.reflected(index);
            self.heights_m[cell] += height(weight, sum, self.cell_m);
        }
    }
}
