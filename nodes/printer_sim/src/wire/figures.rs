//! Height errors of complete layers.

/// Height errors against the plan, of the layers that are complete.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Figures {
    layers: u32,
    last_sq_m2: f64,
    sum_sq_m2: f64,
}

impl Figures {
    /// Adds a layer by the heights of its cells and the planned height of the wall `[m]`.
    pub(super) fn add(&mut self, heights_m: &[f64], planned_m: f64) {
        #[allow(clippy::cast_precision_loss, reason = "far below 2^52 cells")]
        let cells = heights_m.len().max(1) as f64;
        self.last_sq_m2 =
            heights_m.iter().map(|height_m| (height_m - planned_m).powi(2)).sum::<f64>() / cells;
        self.sum_sq_m2 += self.last_sq_m2;
        self.layers += 1;
    }

    /// Complete layers.
    #[must_use]
    pub fn layers(&self) -> u32 {
        self.layers
    }

    /// Root mean square of the last layer `[m]`; 0 before the first.
    #[must_use]
    pub fn last_rms_m(&self) -> f64 {
        self.last_sq_m2.sqrt()
    }

    /// Root mean square over all layers `[m]`; 0 before the first.
    #[must_use]
    pub fn rms_m(&self) -> f64 {
        (self.sum_sq_m2 / f64::from(self.layers.max(1))).sqrt()
    }
}
