//! The extended filter: the same model, linearised at the mean by central differences.

use crate::ukf::{Gaussian, Health, Innovation, Measurement, Update, nis, symmetric};
use nalgebra::{Cholesky, SMatrix, SVector};

/// Step of the differences over the state's own deviation `[-]`: the error is its square, rounding its inverse.
const STEP: f64 = 1e-3;

/// The filter: a Gaussian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ekf<const N: usize> {
    belief: Gaussian<N>,
}

impl<const N: usize> Ekf<N> {
    /// Starts from a prior.
    #[must_use]
    pub fn new(prior: Gaussian<N>) -> Self {
        Self { belief: prior }
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
        self.belief.covariance = covariance;
    }

    fn jacobian<const M: usize>(
        &self,
        function: &mut impl FnMut(&SVector<f64, N>) -> SVector<f64, M>,
    ) -> SMatrix<f64, M, N> {
        let mut jacobian = SMatrix::<f64, M, N>::zeros();
        for index in 0..N {
            let step = STEP * self.belief.covariance[(index, index)].sqrt();
            let mut offset = SVector::<f64, N>::zeros();
            offset[index] = step;
            let (up, down) = (function(&(self.belief.mean + offset)), function(&(self.belief.mean - offset)));
            let slope: SVector<f64, M> = (up - down) / (2.0 * step);
            jacobian.set_column(index, &slope);
        }
        jacobian
    }

    /// Carries the belief through `process` and adds `noise`.
    pub fn predict(
        &mut self,
        noise: &SMatrix<f64, N, N>,
        mut process: impl FnMut(&SVector<f64, N>) -> SVector<f64, N>,
    ) -> Health {
        let jacobian = self.jacobian(&mut process);
        let covariance = symmetric(jacobian * self.belief.covariance * jacobian.transpose() + noise);
        self.accept(Gaussian { mean: process(&self.belief.mean), covariance })
    }

    /// Takes a measurement in, unless its normalised innovation exceeds the gate; Joseph's form keeps the sign.
    pub fn update<const M: usize>(
        &mut self,
        measurement: &Measurement<M>,
        mut observe: impl FnMut(&SVector<f64, N>) -> SVector<f64, M>,
    ) -> Update<M> {
        let jacobian = self.jacobian(&mut observe);
        let before = self.belief.covariance;
        let covariance = symmetric(jacobian * before * jacobian.transpose() + measurement.noise);
        let residual = measurement.value - observe(&self.belief.mean);
        let Some(factor) = Cholesky::new(covariance) else { return Update::Diverged };
        let Some(nis) = nis(&residual, &covariance) else { return Update::Diverged };
        let innovation = Innovation { residual, covariance, nis };
        if nis > measurement.gate {
            return Update::Rejected(innovation);
        }
        let gain = factor.solve(&(jacobian * before)).transpose();
        let kept = SMatrix::<f64, N, N>::identity() - gain * jacobian;
        let posterior = Gaussian {
            mean: self.belief.mean + gain * residual,
            covariance: symmetric(
                kept * before * kept.transpose() + gain * measurement.noise * gain.transpose(),
            ),
        };
        match self.accept(posterior) {
            Health::Sound => Update::Applied(innovation),
            Health::Diverged => Update::Diverged,
        }
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
