//! How much of a print is corrected by more than a little: in all, and by feedback about the spool's calibration.

use models::command::Trims;

/// A trim of flow or speed beyond this is more than a little `[-]`.
const SMALL: f64 = 0.01;

/// Statuses of deposits, and those with a trim.
#[derive(Debug, Clone, Copy, Default)]
pub struct Trimmed {
    all: f64,
    trimmed: f64,
    fed_back: f64,
}

impl Trimmed {
    /// A status while a road is laid; the spool's section is `1 + base` of the nominal one, as far as it is calibrated.
    pub fn add(&mut self, trims: &Trims, base: f64) {
        let beyond = |flow: f64| (flow - 1.0).abs() > SMALL || (trims.speed - 1.0).abs() > SMALL;
        self.all += 1.0;
        self.trimmed += f64::from(u8::from(beyond(trims.flow)));
        self.fed_back += f64::from(u8::from(beyond(trims.flow * (1.0 + base))));
    }

    /// Share of the time with any trim, and with one of feedback `[-]`; `None` where nothing was laid.
    #[must_use]
    pub fn shares(&self) -> Option<(f64, f64)> {
        (self.all > 0.0).then(|| (self.trimmed / self.all, self.fed_back / self.all))
    }
}
