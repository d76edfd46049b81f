use super::*;
use nalgebra::{matrix, vector};
use proptest::prelude::*;

const SPREAD: Spread = Spread { alpha: 0.3, beta: 2.0, kappa: 0.0 };

#[test]
fn nis_weighs_the_residual_by_its_covariance() {
    // S⁻¹ = [[0.5, -0.3], [-0.3, 1.2]] / 0.51
    let nis = nis(&vector![1.5, -0.4], &matrix![1.2, 0.3; 0.3, 0.5]).unwrap();
    assert!((nis - 3.288_235_294_117_647).abs() < 1e-12);
    assert_eq!(super::nis(&vector![1.0, 1.0], &matrix![1.0, 2.0; 2.0, 1.0]), None);
}

#[test]
fn nees_uses_the_error_and_not_the_estimate() {
    let estimate = Gaussian {
        mean: vector![482.2, 0.002_04, 0.021],
        covariance: SMatrix::from_diagonal(&vector![1.0, 1e-8, 1e-4]),
    };
    let nees = nees(&vector![483.0, 0.002, 0.03], &estimate).unwrap();
    assert!((nees - 1.61).abs() < 1e-9);
}

/// On a linear model the unscented transform is exact: the filter is Kalman's.
#[test]
fn equals_the_kalman_filter_on_a_linear_model() {
    let transition = matrix![1.0, 0.1, 0.0; -0.2, 0.9, 0.05; 0.0, 0.0, 1.0];
    let noise = SMatrix::from_diagonal(&vector![1e-3, 2e-3, 1e-4]);
    let observe = matrix![1.0, 0.0, 0.5; 0.0, 2.0, 0.0];
    let sensor = matrix![0.04, 0.01; 0.01, 0.09];
    let mut mean = vector![1.0, -0.5, 0.2];
    let mut covariance: SMatrix<f64, 3, 3> = SMatrix::from_diagonal(&vector![1.0, 0.5, 0.25]);
    let mut filter = Ukf::new(Gaussian { mean, covariance }, SPREAD);
    for step in 0..50 {
        mean = transition * mean;
        covariance = transition * covariance * transition.transpose() + noise;
        assert_eq!(filter.predict(&noise, |x| transition * x), Health::Sound);
        let value = vector![(f64::from(step) * 0.3).sin(), (f64::from(step) * 0.2).cos()];
        let innovation = observe * covariance * observe.transpose() + sensor;
        let gain = covariance * observe.transpose() * innovation.try_inverse().unwrap();
        mean += gain * (value - observe * mean);
        covariance -= gain * innovation * gain.transpose();
        let measurement = Measurement { value, noise: sensor, gate: f64::INFINITY };
        assert!(matches!(filter.update(&measurement, |x| observe * x), Update::Applied(_)));
        assert!((filter.belief().mean - mean).amax() < 1e-10);
        assert!((filter.belief().covariance - covariance).amax() < 1e-10);
    }
}

#[test]
fn a_value_beyond_the_gate_leaves_the_filter_as_it_was() {
    let mut filter = Ukf::new(Gaussian { mean: vector![0.0], covariance: matrix![1.0] }, SPREAD);
    let before = filter;
    // S = 1 + 1, r = 10: NIS = 50
    let outcome =
        filter.update(&Measurement { value: vector![10.0], noise: matrix![1.0], gate: 20.0 }, |x| *x);
    let Update::Rejected(innovation) = outcome else { panic!("{outcome:?}") };
    assert!((innovation.nis - 50.0).abs() < 1e-9);
    assert_eq!(filter, before);
}

#[test]
fn an_indefinite_covariance_and_a_nan_are_outcomes() {
    let mut filter =
        Ukf::new(Gaussian { mean: vector![0.0, 0.0], covariance: matrix![1.0, 2.0; 2.0, 1.0] }, SPREAD);
    assert_eq!(filter.predict(&SMatrix::identity(), |x| *x), Health::Diverged);
    let mut filter = Ukf::new(Gaussian { mean: vector![0.0], covariance: matrix![1.0] }, SPREAD);
    assert_eq!(filter.predict(&matrix![1.0], |_| vector![f64::NAN]), Health::Diverged);
    let outcome =
        filter.update(&Measurement { value: vector![f64::NAN], noise: matrix![1.0], gate: 20.0 }, |x| *x);
    assert_eq!(outcome, Update::Diverged);
    assert_eq!(filter.belief().mean, vector![0.0]);
}

/// A weight that is no power of two, on columns whose products with it round: each half of the matrix is computed on its own.
#[test]
fn a_square_with_a_weight_is_symmetric_to_the_last_bit() {
    let columns = SMatrix::<f64, 5, 3>::from_fn(|row, column| (1.0 + (3 * row + column) as f64).sqrt() / 3.0);
    for weight in [1.91, -0.37, 1.0 / 3.0] {
        let mut matrix = SMatrix::<f64, 5, 5>::identity() * 1e-3;
        crate::small::add_square(&mut matrix, &columns, weight);
        assert!((matrix - matrix.transpose()).amax() <= 0.0, "{weight}: {matrix:e}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// Whatever comes, the covariance stays symmetric and positive definite.
    #[test]
    fn the_covariance_stays_symmetric_and_positive(
        start in prop::array::uniform3(0.01f64..10.0),
        values in prop::collection::vec((-5.0f64..5.0, 1e-4f64..4.0), 1..20),
    ) {
        let mut filter =
            Ukf::new(Gaussian { mean: vector![1.0, 0.5, 0.1], covariance: SMatrix::from_diagonal(&start.into()) }, SPREAD);
        let noise = SMatrix::from_diagonal(&vector![1e-4, 1e-4, 1e-6]);
        for (value, variance) in values {
            filter.predict(&noise, |x| vector![x[0] * 0.9 + x[1] * x[2], x[1], x[2].sin()]);
            filter.update(
                &Measurement { value: vector![value], noise: matrix![variance], gate: 30.0 },
                |x| vector![x[0] * x[1]],
            );
            let covariance = filter.belief().covariance;
            prop_assert!((covariance - covariance.transpose()).amax() <= 0.0);
            prop_assert!(nalgebra::Cholesky::new(covariance).is_some());
        }
    }
}
