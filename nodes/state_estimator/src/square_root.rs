//! The unscented filter in square-root form: it carries the Cholesky factor of the covariance, which therefore cannot
//! lose its symmetry or its sign to rounding (van der Merwe and Wan 2001).
//!
//! The factor of a sum of squares is built by rank-one updates; what is subtracted (the centre's negative weight, the
//! gain of a measurement) is a downdate, and a downdate that fails is a divergence, told as such.

use crate::ukf::{Gaussian, Health, Innovation, Measurement, Spread, Transformed, Update, Weights, nis};
use nalgebra::{Cholesky, SMatrix, SVector};

/// The filter: mean, root of the covariance, and the covariance for who reads it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SquareRootUkf<const N: usize> {
    belief: Gaussian<N>,
    root: SMatrix<f64, N, N>,
    weights: Weights,
}

impl<const N: usize> SquareRootUkf<N> {
    /// Starts from a prior; one that is not positive definite diverges at the first step.
    #[must_use]
    pub fn new(prior: Gaussian<N>, spread: Spread) -> Self {
        let root = Cholesky::new(prior.covariance).map_or(SMatrix::repeat(f64::NAN), Cholesky::unpack);
        Self { belief: prior, root, weights: Weights::of::<N>(spread) }
    }

    /// What is believed now.
    #[must_use]
    pub fn belief(&self) -> &Gaussian<N> {
        &self.belief
    }

    /// Replaces the covariance; nothing changes where it is not positive definite.
    pub fn set_covariance(&mut self, covariance: SMatrix<f64, N, N>) {
        if let Some(factor) = Cholesky::new(covariance) {
            self.root = factor.unpack();
            self.belief.covariance = covariance;
        }
    }

    /// Carries the belief through `process` and adds `noise`.
    pub fn predict(
        &mut self,
        noise: &SMatrix<f64, N, N>,
        process: impl FnMut(&SVector<f64, N>) -> SVector<f64, N>,
    ) -> Health {
        let points = Transformed::new(&self.belief, &(self.root * self.weights.scale), process);
        let shift = points.mean_shift(self.weights);
        let Some(factor) = Cholesky::new(*noise) else { return Health::Diverged };
        let mut root = factor.unpack();
        for deviation in points.deviations(self.weights, &shift) {
            if rank_one(&mut root, deviation, 1.0) == Health::Diverged {
                return Health::Diverged;
            }
        }
        let centre = self.weights.covariance_centre;
        if rank_one(&mut root, shift * centre.abs().sqrt(), centre.signum()) == Health::Diverged {
            return Health::Diverged;
        }
        self.accept(points.centre() + shift, root)
    }

    /// Takes a measurement in, unless its normalised innovation exceeds the gate.
    pub fn update<const M: usize>(
        &mut self,
        measurement: &Measurement<M>,
        observe: impl FnMut(&SVector<f64, N>) -> SVector<f64, M>,
    ) -> Update<M> {
        let offsets = self.root * self.weights.scale;
        let points = Transformed::new(&self.belief, &offsets, observe);
        let shift = points.mean_shift(self.weights);
        let covariance = points.covariance(self.weights, &shift) + measurement.noise;
        let residual = measurement.value - points.centre() - shift;
        let Some(factor) = Cholesky::new(covariance) else { return Update::Diverged };
        let Some(nis) = nis(&residual, &covariance) else { return Update::Diverged };
        let innovation = Innovation { residual, covariance, nis };
        if nis > measurement.gate {
            return Update::Rejected(innovation);
        }
        let cross = points.cross(self.weights, &offsets);
        let gain = factor.solve(&cross.transpose()).transpose();
        // P - K S K' = P - U U' with U = K chol(S)
        let mut root = self.root;
        let taken = gain * factor.l();
        for column in taken.column_iter() {
            if rank_one(&mut root, column.into_owned(), -1.0) == Health::Diverged {
                return Update::Diverged;
            }
        }
        match self.accept(self.belief.mean + gain * residual, root) {
            Health::Sound => Update::Applied(innovation),
            Health::Diverged => Update::Diverged,
        }
    }

    fn accept(&mut self, mean: SVector<f64, N>, root: SMatrix<f64, N, N>) -> Health {
        let covariance = root * root.transpose();
        let finite = mean.iter().chain(covariance.iter()).all(|value| value.is_finite());
        if !finite {
            return Health::Diverged;
        }
        self.root = root;
        self.belief = Gaussian { mean, covariance };
        Health::Sound
    }
}

/// Factor of `L L' + sign v v'` in place.
fn rank_one<const N: usize>(root: &mut SMatrix<f64, N, N>, mut vector: SVector<f64, N>, sign: f64) -> Health {
    for k in 0..N {
        let (diagonal, entry) = (root[(k, k)], vector[k]);
        let square = diagonal * diagonal + sign * entry * entry;
        if square.is_nan() || square <= 0.0 {
            return Health::Diverged;
        }
        let radius = square.sqrt();
        let (cosine, sine) = (radius / diagonal, entry / diagonal);
        root[(k, k)] = radius;
        for i in k + 1..N {
            root[(i, k)] = (root[(i, k)] + sign * sine * vector[i]) / cosine;
            vector[i] = cosine * vector[i] - sine * root[(i, k)];
        }
    }
    Health::Sound
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{matrix, vector};

    #[test]
    fn rank_one_updates_and_downdates_the_factor() {
        let matrix = matrix![4.0, 1.0, 0.5; 1.0, 3.0, 0.2; 0.5, 0.2, 2.0];
        let vector = vector![0.5, -0.3, 0.8];
        let start = Cholesky::new(matrix).unwrap().unpack();
        for sign in [1.0, -1.0] {
            let mut root = start;
            assert_eq!(rank_one(&mut root, vector, sign), Health::Sound);
            let wanted = matrix + vector * vector.transpose() * sign;
            assert!((root * root.transpose() - wanted).amax() < 1e-14);
        }
        let mut root = start;
        assert_eq!(rank_one(&mut root, vector * 10.0, -1.0), Health::Diverged);
    }
}
