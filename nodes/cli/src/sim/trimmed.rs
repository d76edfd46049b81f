//! How much of a print is corrected by more than a little.

use models::command::Trims;

/// A trim of flow or speed beyond this is more than a little `[-]`.
const SMALL: f64 = 0.01;

/// Statuses of deposits, and those with a trim.
#[derive(Debug, Clone, Copy, Default)]
pub struct Trimmed {
    all: f64,
    trimmed: f64,
}

impl Trimmed {
    /// A status while a road is laid.
    pub fn add(&mut self, trims: &Trims) {
        let beyond = (trims.flow - 1.0).abs() > SMALL || (trims.speed - 1.0).abs() > SMALL;
        self.all += 1.0;
        self.trimmed += f64::from(u8::from(beyond));
    }

    /// Share of the time `[-]`; `None` where nothing was laid.
    #[must_use]
    pub fn share(&self) -> Option<f64> {
        (self.all > 0.0).then(|| self.trimmed / self.all)
    }
}
