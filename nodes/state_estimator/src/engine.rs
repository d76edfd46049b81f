//! The filter's form, behind one parameter: all three have the same interface and know nothing of the printer.

use crate::extended::Ekf;
use crate::square_root::SquareRootUkf;
use crate::ukf::{Gaussian, Health, Measurement, Spread, Ukf, Update};
use nalgebra::{SMatrix, SVector};
use serde::Deserialize;

/// Which filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// Unscented, carrying the root of the covariance.
    SquareRoot,
    /// Unscented, carrying the covariance.
    Unscented,
    /// Extended.
    Extended,
}

/// A filter of one of the forms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Engine<const N: usize> {
    /// See [`Form::SquareRoot`].
    SquareRoot(SquareRootUkf<N>),
    /// See [`Form::Unscented`].
    Unscented(Ukf<N>),
    /// See [`Form::Extended`].
    Extended(Ekf<N>),
}

impl<const N: usize> Engine<N> {
    /// Starts from a prior; the spread is that of sigma points, which the extended form has none of.
    #[must_use]
    pub fn new(form: Form, prior: Gaussian<N>, spread: Spread) -> Self {
        match form {
            Form::SquareRoot => Self::SquareRoot(SquareRootUkf::new(prior, spread)),
            Form::Unscented => Self::Unscented(Ukf::new(prior, spread)),
            Form::Extended => Self::Extended(Ekf::new(prior)),
        }
    }

    /// What is believed now.
    #[must_use]
    pub fn belief(&self) -> &Gaussian<N> {
        match self {
            Self::SquareRoot(filter) => filter.belief(),
            Self::Unscented(filter) => filter.belief(),
            Self::Extended(filter) => filter.belief(),
        }
    }

    fn set_covariance(&mut self, covariance: SMatrix<f64, N, N>) {
        match self {
            Self::SquareRoot(filter) => filter.set_covariance(covariance),
            Self::Unscented(filter) => filter.set_covariance(covariance),
            Self::Extended(filter) => filter.set_covariance(covariance),
        }
    }

    fn set_mean(&mut self, mean: SVector<f64, N>) {
        match self {
            Self::SquareRoot(filter) => filter.set_mean(mean),
            Self::Unscented(filter) => filter.set_mean(mean),
            Self::Extended(filter) => filter.set_mean(mean),
        }
    }

    /// Adds to the covariance: for a state that may have jumped.
    pub fn inflate(&mut self, addition: &SMatrix<f64, N, N>) {
        self.set_covariance(self.belief().covariance + addition);
    }

    /// Takes a state's correlations away: what is measured of others says nothing of it any more, so that it stands
    /// while its own uncertainty goes on.
    pub fn freeze(&mut self, index: usize) {
        let mut covariance = self.belief().covariance;
        let own = covariance[(index, index)];
        covariance.row_mut(index).fill(0.0);
        covariance.column_mut(index).fill(0.0);
        covariance[(index, index)] = own;
        self.set_covariance(covariance);
    }

    /// Brings a state that cannot be outside of these bounds back to them, and with it what is known together with it; the
    /// covariance stays.
    pub fn confine(&mut self, index: usize, (least, most): (f64, f64)) {
        let Gaussian { mean, covariance } = self.belief();
        let (off, own) = (mean[index].clamp(least, most) - mean[index], covariance[(index, index)]);
        if off != 0.0 && own > 0.0 {
            let moved = mean + covariance.column(index) * (off / own);
            self.set_mean(moved);
        }
    }

    /// Carries the belief through `process` and adds `noise`.
    pub fn predict(
        &mut self,
        noise: &SMatrix<f64, N, N>,
        process: impl FnMut(&SVector<f64, N>) -> SVector<f64, N>,
    ) -> Health {
        match self {
            Self::SquareRoot(filter) => filter.predict(noise, process),
            Self::Unscented(filter) => filter.predict(noise, process),
            Self::Extended(filter) => filter.predict(noise, process),
        }
    }

    /// Takes a measurement in, unless its normalised innovation exceeds the gate.
    pub fn update<const M: usize>(
        &mut self,
        measurement: &Measurement<M>,
        observe: impl FnMut(&SVector<f64, N>) -> SVector<f64, M>,
    ) -> Update<M> {
        match self {
            Self::SquareRoot(filter) => filter.update(measurement, observe),
            Self::Unscented(filter) => filter.update(measurement, observe),
            Self::Extended(filter) => filter.update(measurement, observe),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{matrix, vector};

    const SPREAD: Spread = Spread { alpha: 0.3, beta: 2.0, kappa: 0.0 };

    /// The root form equals the plain one on any model.
    #[test]
    fn the_forms_agree() {
        let prior = Gaussian {
            mean: vector![1.0, 0.5, 0.1],
            covariance: SMatrix::from_diagonal(&vector![0.04, 0.01, 0.01]),
        };
        let noise = SMatrix::from_diagonal(&vector![1e-4, 1e-4, 1e-6]);
        let form = |form| Engine::new(form, prior, SPREAD);
        let mut filters = [form(Form::Unscented), form(Form::SquareRoot)];
        for step in 0..200 {
            let value = vector![0.4 + 0.1 * (f64::from(step) * 0.3).sin()];
            for filter in &mut filters {
                let health =
                    filter.predict(&noise, |x| vector![x[0] * 0.9 + 0.1 + x[1] * x[2], x[1], x[2].sin()]);
                assert_eq!(health, Health::Sound);
                let measurement = Measurement { value, noise: matrix![0.01], gate: f64::INFINITY };
                assert!(matches!(filter.update(&measurement, |x| vector![x[0] * x[1]]), Update::Applied(_)));
            }
            let [plain, root] = &filters;
            assert!((plain.belief().mean - root.belief().mean).amax() < 1e-11);
            assert!((plain.belief().covariance - root.belief().covariance).amax() < 1e-11);
        }
    }

    /// The same with noises that know of one another and two values at a time; a spread of beta 1 at the widest alpha, where
    /// the mean's shift weighs nothing, and a wide one.
    #[test]
    fn the_forms_agree_where_noise_is_correlated() {
        let prior = Gaussian { mean: vector![1.0, 0.5], covariance: matrix![0.04, 0.01; 0.01, 0.02] };
        let noise = matrix![2e-3, -1e-3; -1e-3, 1e-3];
        for (alpha, beta) in [(1.0, 1.0), (0.3, 2.0), (0.5, 10.0)] {
            let spread = Spread { alpha, beta, kappa: 0.0 };
            let mut filters =
                [Form::Unscented, Form::SquareRoot].map(|form| Engine::new(form, prior, spread));
            for step in 0..50 {
                let wave = (f64::from(step) * 0.3).sin();
                let measurement = Measurement {
                    value: vector![0.5 + 0.1 * wave, 0.3 * wave],
                    noise: matrix![0.01, 0.004; 0.004, 0.02],
                    gate: f64::INFINITY,
                };
                for filter in &mut filters {
                    assert_eq!(
                        filter.predict(&noise, |x| vector![x[0] + x[1] * x[1], x[1].sin()]),
                        Health::Sound
                    );
                    let update = filter.update(&measurement, |x| vector![x[0] * x[1], x[0] + x[1]]);
                    assert!(matches!(update, Update::Applied(_)));
                }
                let [plain, root] = &filters;
                assert!((plain.belief().mean - root.belief().mean).amax() < 1e-10);
                assert!((plain.belief().covariance - root.belief().covariance).amax() < 1e-10);
            }
        }
    }

    /// Central differences of a line are its slope but for rounding: on a linear model all forms are Kalman's filter.
    #[test]
    fn the_forms_agree_on_a_linear_model() {
        let prior = Gaussian { mean: vector![1.0, -0.5], covariance: matrix![1.0, 0.2; 0.2, 0.5] };
        let transition = matrix![1.0, 0.1; -0.2, 0.9];
        let noise = SMatrix::from_diagonal(&vector![1e-3, 2e-3]);
        let mut filters = [Form::Unscented, Form::Extended].map(|form| Engine::new(form, prior, SPREAD));
        for step in 0..50 {
            let value = vector![(f64::from(step) * 0.3).sin()];
            for filter in &mut filters {
                assert_eq!(filter.predict(&noise, |x| transition * x), Health::Sound);
                let measurement = Measurement { value, noise: matrix![0.04], gate: f64::INFINITY };
                assert!(matches!(
                    filter.update(&measurement, |x| vector![x[0] + 2.0 * x[1]]),
                    Update::Applied(_)
                ));
            }
            let [plain, extended] = &filters;
            // rounding of the differences: 1e-16 over a step of 1e-3 deviations, over fifty steps
            assert!((plain.belief().mean - extended.belief().mean).amax() < 1e-9);
            assert!((plain.belief().covariance - extended.belief().covariance).amax() < 1e-9);
        }
    }

    /// With beta 2 the variance of a Gaussian's square is exact, whatever alpha: `4 m² σ² + 2 σ⁴`, and its mean `m² + σ²`.
    #[test]
    fn mean_and_variance_of_a_square_are_exact() {
        for form in [Form::SquareRoot, Form::Unscented] {
            for alpha in [0.01, 0.3, 1.0] {
                let prior = Gaussian { mean: vector![1.5], covariance: matrix![0.04] };
                let mut filter = Engine::new(form, prior, Spread { alpha, beta: 2.0, kappa: 0.0 });
                assert_eq!(filter.predict(&matrix![1e-3], |x| x.component_mul(x)), Health::Sound);
                let belief = filter.belief();
                assert!((belief.mean[0] - 2.29).abs() < 1e-10);
                assert!((belief.covariance[(0, 0)] - (0.36 + 0.0032 + 1e-3)).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn what_is_not_finite_diverges_and_leaves_the_filter_as_it_was() {
        for form in [Form::SquareRoot, Form::Unscented] {
            let prior = Gaussian { mean: vector![1.0, 0.5], covariance: SMatrix::identity() };
            let mut filter = Engine::new(form, prior, SPREAD);
            let noise = SMatrix::identity();
            for broken in [f64::NAN, f64::INFINITY, 1e200] {
                for index in 0..2 {
                    let process = |x: &SVector<f64, 2>| {
                        let mut next = *x;
                        next[index] *= broken;
                        next
                    };
                    assert_eq!(filter.predict(&noise, process), Health::Diverged, "{form:?} {broken}");
                }
                let measurement = Measurement { value: vector![broken], noise: matrix![0.1], gate: f64::MAX };
                let update = filter.update(&measurement, |x| vector![x[0]]);
                assert!(!matches!(update, Update::Applied(_)), "{form:?} {broken}");
            }
            assert_eq!(filter, Engine::new(form, prior, SPREAD));
        }
    }

    /// Half a unit up or down, 0.4 of the other: what its correlation says. Nothing moves a state that is within.
    #[test]
    fn a_state_is_brought_back_with_what_is_known_together_with_it() {
        for form in [Form::SquareRoot, Form::Unscented, Form::Extended] {
            let prior = Gaussian { mean: vector![-0.5, 1.0], covariance: matrix![1.0, 0.8; 0.8, 1.0] };
            let mut filter = Engine::new(form, prior, SPREAD);
            filter.confine(1, (0.0, 1.0));
            assert_eq!(*filter.belief(), prior);
            for (bounds, [own, other]) in [((0.0, 1.0), [0.0, 1.4]), ((-2.0, -0.5), [-0.5, 1.0])] {
                filter.confine(0, bounds);
                let belief = filter.belief();
                assert!((belief.mean[0] - own).abs() < 1e-12 && (belief.mean[1] - other).abs() < 1e-12);
                assert_eq!(belief.covariance, prior.covariance);
            }
        }
    }

    #[test]
    fn a_frozen_state_is_not_moved_by_measurements_of_others() {
        for form in [Form::SquareRoot, Form::Unscented, Form::Extended] {
            let prior = Gaussian { mean: vector![0.0, 0.0], covariance: matrix![1.0, 0.8; 0.8, 1.0] };
            let mut filter = Engine::new(form, prior, SPREAD);
            filter.freeze(1);
            let measurement = Measurement { value: vector![2.0], noise: matrix![0.1], gate: f64::INFINITY };
            filter.update(&measurement, |x| vector![x[0]]);
            let belief = filter.belief();
            assert!(belief.mean[0] > 1.0 && belief.mean[1].abs() < 1e-12);
            assert!((belief.covariance[(1, 1)] - 1.0).abs() < 1e-12);
        }
    }
}
