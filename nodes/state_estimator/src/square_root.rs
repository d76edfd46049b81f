//! The unscented filter in square-root form: it carries the Cholesky factor of the covariance, which therefore cannot
//! lose its symmetry or its sign to rounding (van der Merwe and Wan 2001).
//!
//! A prediction turns the deviations of all points into the factor by reflections (Householder). A measurement takes
//! `L W Wᵀ Lᵀ` away: the factor becomes `L` times that of `I - W Wᵀ` (Andrews 1968). That can fail, and a failure is a
//! divergence, told as such.

use crate::small::{add_square, cholesky, product, root_of_noise};
use crate::ukf::{
    Gaussian, Health, Measurement, Spread, Told, Transformed, Update, Weights, is_finite, symmetric,
};
use nalgebra::{SMatrix, SVector};

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
        let root = cholesky(&prior.covariance).unwrap_or(SMatrix::repeat(f64::NAN));
        Self { belief: prior, root, weights: Weights::of::<N>(spread) }
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

    /// Replaces the covariance; nothing changes where it is not positive definite.
    pub fn set_covariance(&mut self, covariance: SMatrix<f64, N, N>) {
        let covariance = symmetric(covariance);
        if let Some(root) = cholesky(&covariance) {
            (self.root, self.belief.covariance) = (root, covariance);
        }
    }

    /// Carries the belief through `process` and adds `noise`.
    pub fn predict(
        &mut self,
        noise: &SMatrix<f64, N, N>,
        process: impl FnMut(&SVector<f64, N>) -> SVector<f64, N>,
    ) -> Health {
        let Some(mut root) = root_of_noise(noise) else { return Health::Diverged };
        let mut points = Transformed::new(&self.belief.mean, &self.root, self.weights, process);
        let shift = points.shift * self.weights.shift.sqrt();
        fold_in(&mut root, points.deviations(), shift);
        self.accept(points.mean, &root)
    }

    /// Takes a measurement in, unless its normalised innovation exceeds the gate.
    pub fn update<const M: usize>(
        &mut self,
        measurement: &Measurement<M>,
        observe: impl FnMut(&SVector<f64, N>) -> SVector<f64, M>,
    ) -> Update<M> {
        let points = Transformed::new(&self.belief.mean, &self.root, self.weights, observe);
        let Some(told) = Told::of(&points, measurement) else { return Update::Diverged };
        if told.innovation.nis > measurement.gate {
            return Update::Rejected(told.innovation);
        }
        let mut kept = SMatrix::identity();
        add_square(&mut kept, &told.taken, -1.0);
        let Some(kept) = cholesky(&kept) else { return Update::Diverged };
        let mean = self.belief.mean + product(&self.root, &told.moved);
        match self.accept(mean, &product(&self.root, &kept)) {
            Health::Sound => Update::Applied(told.innovation),
            Health::Diverged => Update::Diverged,
        }
    }

    fn accept(&mut self, mean: SVector<f64, N>, root: &SMatrix<f64, N, N>) -> Health {
        if !is_finite(&mean, root) {
            return Health::Diverged;
        }
        self.root.copy_from(root);
        self.belief.mean = mean;
        self.belief.covariance.fill(0.0);
        add_square(&mut self.belief.covariance, root, 1.0);
        Health::Sound
    }
}

/// Factor of `L Lᵀ + D Dᵀ + E Eᵀ + s sᵀ` in place, by a reflection for each row; the deviations are used up.
fn fold_in<const N: usize>(
    root: &mut SMatrix<f64, N, N>,
    [plus, minus]: [&mut SMatrix<f64, N, N>; 2],
    mut shift: SVector<f64, N>,
) {
    for i in 0..N {
        let row = |k| [plus[(i, k)], minus[(i, k)]];
        let factors: [[f64; 2]; N] = std::array::from_fn(row);
        let last = shift[i];
        let mut product: [f64; N] = std::array::from_fn(|k| shift[k] * last);
        for (point, [up, down]) in factors.iter().enumerate() {
            for (k, entry) in product.iter_mut().enumerate() {
                *entry += plus[(k, point)] * up + minus[(k, point)] * down;
            }
        }
        let diagonal = root[(i, i)];
        let length = (diagonal * diagonal + product[i]).sqrt();
        let head = diagonal + length;
        let scale = 1.0 / (length * head);
        for (k, entry) in product.iter_mut().enumerate() {
            *entry = (*entry + head * root[(k, i)]) * scale;
            // what is above the diagonal has been reflected to zero
            root[(k, i)] = if k < i { 0.0 } else { head * *entry - root[(k, i)] };
        }
        for (point, [up, down]) in factors.iter().enumerate() {
            for (k, entry) in product.iter().enumerate() {
                plus[(k, point)] -= entry * up;
                minus[(k, point)] -= entry * down;
            }
        }
        for (k, entry) in product.iter().enumerate() {
            shift[k] -= entry * last;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{matrix, vector};

    #[test]
    fn deviations_are_folded_into_the_factor() {
        let covariance = matrix![4.0, 1.0, 0.5; 1.0, 3.0, 0.2; 0.5, 0.2, 2.0];
        let plus = matrix![0.5, -0.3, 0.8; 0.1, 0.7, -0.2; 0.0, 0.4, 1.1];
        let minus = matrix![-0.4, 0.3, -0.9; -0.1, -0.6, 0.2; 0.1, -0.4, -1.3];
        let shift = vector![0.2, -0.5, 0.3];
        let mut root = cholesky(&covariance).unwrap();
        fold_in(&mut root, [&mut plus.clone(), &mut minus.clone()], shift);
        let wanted =
            covariance + plus * plus.transpose() + minus * minus.transpose() + shift * shift.transpose();
        assert!((root * root.transpose() - wanted).amax() < 1e-14);
        assert!(root[(0, 1)] == 0.0 && root[(0, 2)] == 0.0 && root[(1, 2)] == 0.0);
        assert!((0..3).all(|index| root[(index, index)] > 0.0));
    }
}
