//! What widths teach of a law: a factor, the melt's index, and how much more force a nozzle needs that has narrowed.
//!
//! The printer needs `c_0 L(u) + c_1 M(u) ln(u/u_0) + c_2 M(u)`, `L` the foretold law, `M` its melt's part. Frames are lines in the
//! three (see `learning`), whose slopes are taken about the means: a constant error of the width (diameter, slip) is no law's.
//! The prior is `(1, 0, 0)`.

use models::command::AdvanceLaw;
use nalgebra::{Matrix3, Vector3};

/// Feed at which another index of the melt's part changes nothing `[m/s]`: between a slow road's and an infill's.
const INDEX_AT_M_S: f64 = 1.2e-3;
/// A smaller reach is none: a prior has to be finite `[-]`.
const REACH_MIN: f64 = 1e-6;
/// Rounds in which the factor that weighs the errors becomes the one that they tell: each leaves a third at most.
const ROUNDS: u32 = 6;

/// One of each: of the whole law, of the melt's index, of the melt's part.
pub(super) type Triple = Vector3<f64>;

/// `L`, `M ln(u/u_0)` and `M` at a feed, at least `slow_m_s` in the logarithm `[m]`.
pub(super) fn parts_m(law: &AdvanceLaw, feed_m_s: f64, slow_m_s: f64) -> Triple {
    let held_m = law.held_m(feed_m_s);
    let melt_m = held_m - law.linear_s * feed_m_s;
    Triple::new(held_m, melt_m * (feed_m_s.max(slow_m_s) / INDEX_AT_M_S).ln(), melt_m)
}

/// What was learnt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Learnt {
    /// Factor on all of a law `[-]`.
    pub(crate) factor: f64,
    /// Offset of its melt's index `[-]`.
    pub(crate) index: f64,
    /// What its melt's part has more beside the factor, in a nozzle that has narrowed `[-]`.
    pub(crate) narrowed: f64,
}

impl Learnt {
    /// The foretold law as it is.
    pub(super) const NOTHING: Self = Self { factor: 1.0, index: 0.0, narrowed: 0.0 };

    /// Force of the melt over the foretold one `[-]`.
    pub(crate) fn force(&self) -> f64 {
        self.factor + self.narrowed
    }

    /// A foretold law with what was learnt.
    pub(crate) fn of(&self, law: AdvanceLaw) -> AdvanceLaw {
        let (linear_s, shear) = (law.linear_s * self.factor, law.shear * self.force());
        AdvanceLaw { linear_s, shear, ..law }.bent(self.index, INDEX_AT_M_S)
    }
}

/// Weighted sums over frames.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Fit {
    weight: f64,
    levers: Triple,
    levers_sq: Matrix3<f64>,
    driven: Sums,
    errors: Sums,
}

/// Sums of one number per frame, alone and times the levers.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    plain: f64,
    products: Triple,
}

impl Sums {
    fn take(&mut self, value: f64, levers: Triple, kept: f64) {
        self.plain = kept * self.plain + value;
        self.products = kept * self.products + levers * value;
    }

    fn about_mean(&self, levers: Triple, weight: f64) -> Triple {
        self.products - levers * self.plain / weight
    }
}

impl Fit {
    /// Takes a frame in: what each coefficient does to its width, what the drive does to it, and its error. Older ones count for
    /// `kept`.
    pub(super) fn take(&mut self, levers: Triple, (driven, error): (f64, f64), kept: f64) {
        self.weight = kept * self.weight + 1.0;
        self.levers = kept * self.levers + levers;
        self.levers_sq = kept * self.levers_sq + levers * levers.transpose();
        self.driven.take(driven, levers, kept);
        self.errors.take(error, levers, kept);
    }

    /// The nozzle is sound: what frames told of a narrowed one is past.
    pub(super) fn forget_narrowing(&mut self) {
        (self.levers[2], self.driven.products[2], self.errors.products[2]) = (0.0, 0.0, 0.0);
        self.levers_sq.row_mut(2).fill(0.0);
        self.levers_sq.column_mut(2).fill(0.0);
    }

    /// What frames that scatter by `noise` speak for, within the reach of each.
    pub(super) fn learnt(&self, noise: f64, reach: Triple) -> Learnt {
        if self.weight <= 0.0 || reach[0] <= 0.0 {
            return Learnt::NOTHING;
        }
        let prior = reach.map(|reach| (noise / reach.max(REACH_MIN)).powi(2));
        let spread = self.levers_sq - self.levers * self.levers.transpose() / self.weight;
        let Some(root) = (spread + Matrix3::from_diagonal(&prior)).cholesky() else { return Learnt::NOTHING };
        let driven = self.driven.about_mean(self.levers, self.weight) + Triple::new(prior[0], 0.0, 0.0);
        let errors = self.errors.about_mean(self.levers, self.weight);
        let (mut found, mut factor) = (Triple::zeros(), 1.0);
        for _ in 0..ROUNDS {
            found = root.solve(&(driven - errors * factor));
            factor = found[0].clamp(1.0 - reach[0], 1.0 + reach[0]);
        }
        let narrowed = found[2].clamp(-reach[2], reach[2]);
        let index = (found[1] / (factor + narrowed)).clamp(-reach[1], reach[1]);
        Learnt { factor, index, narrowed }
    }
}

#[cfg(test)]
mod tests;
