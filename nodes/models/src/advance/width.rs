//! Errors of the width over a way: `e = y/v - 1`, each weighted by the way it was laid over (model book 2.2).

/// Sums over a way, one piece after the other.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Tally {
    way_m: f64,
    squares_m: f64,
    magnitudes_m: f64,
    least: f64,
    most: f64,
}

/// Width errors of a whole way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WidthErrors {
    /// Root of the mean square `[-]`.
    pub rms: f64,
    /// Largest lack `[-]`, above 0 where there is one.
    pub under_max: f64,
    /// Largest surplus `[-]`.
    pub over_max: f64,
    /// Mean magnitude `[-]`.
    pub mean_abs: f64,
}

impl Tally {
    /// Adds a piece of way `[m]` laid with a relative error `[-]`.
    pub fn add(&mut self, error: f64, way_m: f64) {
        let (least, most) = if self.way_m > 0.0 { (self.least, self.most) } else { (error, error) };
        (self.least, self.most) = (least.min(error), most.max(error));
        self.way_m += way_m;
        self.squares_m += error * error * way_m;
        self.magnitudes_m += error.abs() * way_m;
    }

    /// Errors of the way so far; `None` before any.
    #[must_use]
    pub fn errors(&self) -> Option<WidthErrors> {
        (self.way_m > 0.0).then(|| WidthErrors {
            rms: (self.squares_m / self.way_m).sqrt(),
            under_max: -self.least,
            over_max: self.most,
            mean_abs: self.magnitudes_m / self.way_m,
        })
    }
}
