//! Unscented Kalman filter with additive noise, apart from any model.
//!
//! Scaled unscented transform (Wan and van der Merwe 2000). Sigma points are redrawn from the prior of every
//! update, so that several channels may be applied one after another. All matrices are of fixed size: nothing is
//! allocated. A covariance that loses positive definiteness is an outcome, not an error: the filter then keeps
//! what it had and the caller decides.

use nalgebra::{Cholesky, SMatrix, SVector};

/// Spread of the sigma points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Distance of the points from the mean `[-]`, in (0, 1].
    pub alpha: f64,
    /// Prior knowledge of the distribution `[-]`; 2 is best for a Gaussian.
    pub beta: f64,
    /// Secondary scaling `[-]`.
    pub kappa: f64,
}

/// Mean and covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian<const N: usize> {
    /// Mean.
    pub mean: SVector<f64, N>,
    /// Covariance, symmetric and positive definite.
    pub covariance: SMatrix<f64, N, N>,
}

/// What became of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Health {
    /// Done.
    Sound,
    /// The covariance is not positive definite, or a value is not finite; the filter is unchanged.
    Diverged,
}

/// A measurement: value, noise, and the largest normalised innovation that is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement<const M: usize> {
    /// Measured value.
    pub value: SVector<f64, M>,
    /// Noise covariance.
    pub noise: SMatrix<f64, M, M>,
    /// Chi-square bound above which the measurement is rejected.
    pub gate: f64,
}

/// What became of a measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Update<const M: usize> {
    /// Taken in.
    Applied(Innovation<M>),
    /// Beyond the gate; the filter is unchanged.
    Rejected(Innovation<M>),
    /// Numerically impossible; the filter is unchanged.
    Diverged,
}

/// Difference of measured and predicted value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Innovation<const M: usize> {
    /// Measured minus predicted.
    pub residual: SVector<f64, M>,
    /// Its predicted covariance.
    pub covariance: SMatrix<f64, M, M>,
    /// Normalised innovation squared `[-]`.
    pub nis: f64,
}

/// Normalised innovation squared `rᵀ S⁻¹ r`; `None` where `S` is not positive definite.
#[must_use]
pub fn nis<const M: usize>(residual: &SVector<f64, M>, covariance: &SMatrix<f64, M, M>) -> Option<f64> {
    let factor = Cholesky::new(*covariance)?;
    let nis = residual.dot(&factor.solve(residual));
    nis.is_finite().then_some(nis)
}

/// Normalised estimation error squared `(x − x̂)ᵀ P⁻¹ (x − x̂)`; `None` where `P` is not positive definite.
///
/// Known only where the truth is known: in simulation.
#[must_use]
pub fn nees<const N: usize>(truth: &SVector<f64, N>, estimate: &Gaussian<N>) -> Option<f64> {
    nis(&(truth - estimate.mean), &estimate.covariance)
}

/// The filter: a Gaussian and the weights of its sigma points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ukf<const N: usize> {
    belief: Gaussian<N>,
    weights: Weights,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Weights {
    pub(crate) scale: f64,
    pub(crate) covariance_centre: f64,
    side: f64,
}

impl Weights {
    /// Weights for `N` states.
    pub(crate) fn of<const N: usize>(spread: Spread) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "dimension of a state vector")]
        let dimension = N as f64;
        let total = spread.alpha * spread.alpha * (dimension + spread.kappa);
        let mean_centre = (total - dimension) / total;
        Self {
            scale: total.sqrt(),
            covariance_centre: mean_centre + 1.0 - spread.alpha * spread.alpha + spread.beta,
            side: 0.5 / total,
        }
    }
}

/// Sigma points as deviations of a function's values from its value at the mean.
///
/// The weight of the centre is large and negative for a small alpha; sums over deviations avoid the cancellation.
pub(crate) struct Transformed<const N: usize, const M: usize> {
    centre: SVector<f64, M>,
    plus: [SVector<f64, M>; N],
    minus: [SVector<f64, M>; N],
}

impl<const N: usize, const M: usize> Transformed<N, M> {
    pub(crate) fn new(
        belief: &Gaussian<N>,
        offsets: &SMatrix<f64, N, N>,
        mut function: impl FnMut(&SVector<f64, N>) -> SVector<f64, M>,
    ) -> Self {
        let centre = function(&belief.mean);
        let mut plus = [SVector::zeros(); N];
        let mut minus = [SVector::zeros(); N];
        for (index, (up, down)) in plus.iter_mut().zip(minus.iter_mut()).enumerate() {
            let offset = offsets.column(index);
            *up = function(&(belief.mean + offset)) - centre;
            *down = function(&(belief.mean - offset)) - centre;
        }
        Self { centre, plus, minus }
    }

    /// The function's value at the mean.
    pub(crate) fn centre(&self) -> SVector<f64, M> {
        self.centre
    }

    /// Deviations of the outer points from the mean, weighted: the sum of their squares is the covariance but for the
    /// centre's share.
    pub(crate) fn deviations(
        &self,
        weights: Weights,
        shift: &SVector<f64, M>,
    ) -> impl Iterator<Item = SVector<f64, M>> {
        let (root, shift) = (weights.side.sqrt(), *shift);
        self.plus.iter().chain(&self.minus).map(move |point| (point - shift) * root)
    }

    /// Mean relative to the centre.
    pub(crate) fn mean_shift(&self, weights: Weights) -> SVector<f64, M> {
        self.plus.iter().chain(&self.minus).fold(SVector::zeros(), |sum, point| sum + point) * weights.side
    }

    pub(crate) fn covariance(&self, weights: Weights, shift: &SVector<f64, M>) -> SMatrix<f64, M, M> {
        let mut covariance = shift * shift.transpose() * weights.covariance_centre;
        for point in self.plus.iter().chain(&self.minus) {
            let deviation = point - shift;
            covariance += deviation * deviation.transpose() * weights.side;
        }
        covariance
    }

    /// Covariance of the filter's state with the function's value; the centre point has no state deviation.
    pub(crate) fn cross(&self, weights: Weights, offsets: &SMatrix<f64, N, N>) -> SMatrix<f64, N, M> {
        let mut cross = SMatrix::zeros();
        for (index, (up, down)) in self.plus.iter().zip(&self.minus).enumerate() {
            cross += offsets.column(index) * (up - down).transpose() * weights.side;
        }
        cross
    }
}

impl<const N: usize> Ukf<N> {
    /// Starts from a prior.
    #[must_use]
    pub fn new(prior: Gaussian<N>, spread: Spread) -> Self {
        Self { belief: prior, weights: Weights::of::<N>(spread) }
    }

    /// What is believed now.
    #[must_use]
    pub fn belief(&self) -> &Gaussian<N> {
        &self.belief
    }

    /// Replaces the covariance.
    pub fn set_covariance(&mut self, covariance: SMatrix<f64, N, N>) {
        self.belief.covariance = covariance;
    }

    /// Carries the belief through `process` and adds `noise`.
    pub fn predict(
        &mut self,
        noise: &SMatrix<f64, N, N>,
        process: impl FnMut(&SVector<f64, N>) -> SVector<f64, N>,
    ) -> Health {
        let Some(offsets) = self.offsets() else { return Health::Diverged };
        let points = Transformed::new(&self.belief, &offsets, process);
        let shift = points.mean_shift(self.weights);
        let covariance = symmetric(points.covariance(self.weights, &shift) + noise);
        self.accept(Gaussian { mean: points.centre + shift, covariance })
    }

    /// Takes a measurement in, unless its normalised innovation exceeds the gate.
    pub fn update<const M: usize>(
        &mut self,
        measurement: &Measurement<M>,
        observe: impl FnMut(&SVector<f64, N>) -> SVector<f64, M>,
    ) -> Update<M> {
        let Some(offsets) = self.offsets() else { return Update::Diverged };
        let points = Transformed::new(&self.belief, &offsets, observe);
        let shift = points.mean_shift(self.weights);
        let covariance = symmetric(points.covariance(self.weights, &shift) + measurement.noise);
        let residual = measurement.value - points.centre - shift;
        let Some(factor) = Cholesky::new(covariance) else { return Update::Diverged };
        let Some(nis) = nis(&residual, &covariance) else { return Update::Diverged };
        let innovation = Innovation { residual, covariance, nis };
        if nis > measurement.gate {
            return Update::Rejected(innovation);
        }
        let cross = points.cross(self.weights, &offsets);
        // K = C S⁻¹ by solving S Kᵀ = Cᵀ
        let gain = factor.solve(&cross.transpose()).transpose();
        let posterior = Gaussian {
            mean: self.belief.mean + gain * residual,
            covariance: symmetric(self.belief.covariance - gain * covariance * gain.transpose()),
        };
        match self.accept(posterior) {
            Health::Sound => Update::Applied(innovation),
            Health::Diverged => Update::Diverged,
        }
    }

    fn offsets(&self) -> Option<SMatrix<f64, N, N>> {
        Some(Cholesky::new(self.belief.covariance)?.unpack() * self.weights.scale)
    }

    fn accept(&mut self, belief: Gaussian<N>) -> Health {
        let finite = belief.mean.iter().chain(belief.covariance.iter()).all(|value| value.is_finite());
        if finite && Cholesky::new(belief.covariance).is_some() {
            self.belief = belief;
            Health::Sound
        } else {
            Health::Diverged
        }
    }
}

pub(crate) fn symmetric<const N: usize>(matrix: SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    (matrix + matrix.transpose()) * 0.5
}

#[cfg(test)]
mod tests;
