//! Unscented Kalman filter with additive noise, apart from any model.
//!
//! Scaled unscented transform (Wan and van der Merwe 2000). Sigma points are redrawn from the prior of every
//! update, so that several channels may be applied one after another. All matrices are of fixed size: nothing is
//! allocated. A covariance that loses positive definiteness is an outcome, not an error: the filter then keeps
//! what it had and the caller decides.

use crate::small::{add_square, cholesky, over_transposed, product, under};
use nalgebra::{SMatrix, SVector};

/// Spread of the sigma points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Distance of the points from the mean `[-]`, in (0, 1].
    pub alpha: f64,
    /// Prior knowledge of the distribution `[-]`, 1 or more; 2 is best for a Gaussian.
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
    let nis = under(&cholesky(covariance)?, *residual).norm_squared();
    nis.is_finite().then_some(nis)
}

/// Normalised estimation error squared `(x − x̂)ᵀ P⁻¹ (x − x̂)`; `None` where `P` is not positive definite.
///
/// Known only where the truth is known: in simulation.
#[must_use]
pub fn nees<const N: usize>(truth: &SVector<f64, N>, estimate: &Gaussian<N>) -> Option<f64> {
    nis(&(truth - estimate.mean), &estimate.covariance)
}

/// The filter: a Gaussian, the root of its covariance, and the weights of its sigma points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ukf<const N: usize> {
    belief: Gaussian<N>,
    /// `None` where the covariance is not positive definite.
    root: Option<SMatrix<f64, N, N>>,
    weights: Weights,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Weights {
    /// Distance of the outer points from the mean, over the root of the covariance.
    scale: f64,
    /// Root of an outer point's weight.
    side: f64,
    /// Weight of the mean's own deviation from the centre.
    pub(crate) shift: f64,
}

impl Weights {
    /// Weights for `N` states.
    pub(crate) fn of<const N: usize>(spread: Spread) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "dimension of a state vector")]
        let dimension = N as f64;
        let square = spread.alpha * spread.alpha;
        let total = square * (dimension + spread.kappa);
        Self { scale: total.sqrt(), side: (0.5 / total).sqrt(), shift: spread.beta - square }
    }
}

/// Values of a function at the sigma points, as weighted deviations `d` from its value at the centre.
///
/// With the deviations from the centre instead of the mean, the centre's weight, large and negative for a small alpha,
/// goes out of the covariance: `Σ d dᵀ + (β - α²) s sᵀ` with `s` from the centre to the mean. Nothing is subtracted, and
/// nothing cancels.
pub(crate) struct Transformed<const N: usize, const M: usize> {
    pub(crate) mean: SVector<f64, M>,
    /// The mean less the value at the centre.
    pub(crate) shift: SVector<f64, M>,
    plus: SMatrix<f64, M, N>,
    minus: SMatrix<f64, M, N>,
    weights: Weights,
}

impl<const N: usize, const M: usize> Transformed<N, M> {
    pub(crate) fn new(
        mean: &SVector<f64, N>,
        root: &SMatrix<f64, N, N>,
        weights: Weights,
        mut function: impl FnMut(&SVector<f64, N>) -> SVector<f64, M>,
    ) -> Self {
        let centre = function(mean);
        let (mut plus, mut minus) = (SMatrix::<f64, M, N>::zeros(), SMatrix::<f64, M, N>::zeros());
        let mut sum = SVector::<f64, M>::zeros();
        for index in 0..N {
            let offset = root.column(index) * weights.scale;
            let up = (function(&(mean + offset)) - centre) * weights.side;
            let down = (function(&(mean - offset)) - centre) * weights.side;
            sum += up + down;
            plus.set_column(index, &up);
            minus.set_column(index, &down);
        }
        let shift = sum * weights.side;
        Self { mean: centre + shift, shift, plus, minus, weights }
    }

    /// Weighted deviations of the outer points.
    pub(crate) fn deviations(&mut self) -> [&mut SMatrix<f64, M, N>; 2] {
        [&mut self.plus, &mut self.minus]
    }

    /// Covariance, and `noise` on top.
    pub(crate) fn covariance(&self, noise: &SMatrix<f64, M, M>) -> SMatrix<f64, M, M> {
        let mut covariance = *noise;
        add_square(&mut covariance, &self.shift, self.weights.shift);
        add_square(&mut covariance, &self.plus, 1.0);
        add_square(&mut covariance, &self.minus, 1.0);
        covariance
    }

    /// Covariance of the state with the function's value, seen through the state's root: `L⁻¹ C`. The centre has no
    /// deviation of the state.
    pub(crate) fn cross_under_root(&self) -> SMatrix<f64, N, M> {
        let weight = self.weights.scale * self.weights.side;
        (self.plus - self.minus).transpose() * weight
    }
}

/// What a measurement tells, before it is believed.
pub(crate) struct Told<const N: usize, const M: usize> {
    pub(crate) innovation: Innovation<M>,
    /// `W = L⁻¹ C Lₛ⁻ᵀ` of the roots `L` of state and `Lₛ` of innovation: the covariance loses `L W Wᵀ Lᵀ`.
    pub(crate) taken: SMatrix<f64, N, M>,
    /// The mean moves by `L` times this.
    pub(crate) moved: SVector<f64, N>,
}

impl<const N: usize, const M: usize> Told<N, M> {
    /// `None` where the innovation's covariance is not positive definite, or the residual no number.
    pub(crate) fn of(points: &Transformed<N, M>, measurement: &Measurement<M>) -> Option<Self> {
        let covariance = points.covariance(&measurement.noise);
        let residual = measurement.value - points.mean;
        let root = cholesky(&covariance)?;
        let normalised = under(&root, residual);
        let nis = normalised.norm_squared();
        let mut taken = points.cross_under_root();
        over_transposed(&mut taken, &root);
        let moved = product(&taken, &normalised);
        let innovation = Innovation { residual, covariance, nis };
        nis.is_finite().then_some(Self { innovation, taken, moved })
    }
}

impl<const N: usize> Ukf<N> {
    /// Starts from a prior; one that is not positive definite diverges at the first step.
    #[must_use]
    pub fn new(prior: Gaussian<N>, spread: Spread) -> Self {
        Self { belief: prior, root: cholesky(&prior.covariance), weights: Weights::of::<N>(spread) }
    }

    /// What is believed now.
    #[must_use]
    pub fn belief(&self) -> &Gaussian<N> {
        &self.belief
    }

    /// Replaces the mean.
    pub fn set_mean(&mut self, mean: SVector<f64, N>) {
        self.belief.mean = mean;
    }

    /// Replaces the covariance.
    pub fn set_covariance(&mut self, covariance: SMatrix<f64, N, N>) {
        self.belief.covariance = symmetric(covariance);
        self.root = cholesky(&self.belief.covariance);
    }

    /// Carries the belief through `process` and adds `noise`.
    pub fn predict(
        &mut self,
        noise: &SMatrix<f64, N, N>,
        process: impl FnMut(&SVector<f64, N>) -> SVector<f64, N>,
    ) -> Health {
        let Some(root) = self.root else { return Health::Diverged };
        let points = Transformed::new(&self.belief.mean, &root, self.weights, process);
        self.accept(points.mean, &points.covariance(noise))
    }

    /// Takes a measurement in, unless its normalised innovation exceeds the gate.
    pub fn update<const M: usize>(
        &mut self,
        measurement: &Measurement<M>,
        observe: impl FnMut(&SVector<f64, N>) -> SVector<f64, M>,
    ) -> Update<M> {
        let Some(root) = self.root else { return Update::Diverged };
        let points = Transformed::new(&self.belief.mean, &root, self.weights, observe);
        let Some(told) = Told::of(&points, measurement) else { return Update::Diverged };
        if told.innovation.nis > measurement.gate {
            return Update::Rejected(told.innovation);
        }
        let mut covariance = self.belief.covariance;
        add_square(&mut covariance, &product(&root, &told.taken), -1.0);
        match self.accept(self.belief.mean + product(&root, &told.moved), &covariance) {
            Health::Sound => Update::Applied(told.innovation),
            Health::Diverged => Update::Diverged,
        }
    }

    fn accept(&mut self, mean: SVector<f64, N>, covariance: &SMatrix<f64, N, N>) -> Health {
        let Some(root) = cholesky(covariance) else { return Health::Diverged };
        if !is_finite(&mean, &root) {
            return Health::Diverged;
        }
        self.belief.mean = mean;
        self.belief.covariance.copy_from(covariance);
        self.root = Some(root);
        Health::Sound
    }
}

/// Whether a mean and a covariance are numbers. The covariance's root has been found, so that only its diagonal is left
/// to be asked: anything that is no number has become one there, or the root's failure.
pub(crate) fn is_finite<const N: usize>(mean: &SVector<f64, N>, root: &SMatrix<f64, N, N>) -> bool {
    (0..N).all(|index| mean[index].is_finite() && root[(index, index)].is_finite())
}

pub(crate) fn symmetric<const N: usize>(matrix: SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    (matrix + matrix.transpose()) * 0.5
}

#[cfg(test)]
mod tests;
