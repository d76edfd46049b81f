use super::super::geometry::Geometry;
use super::super::kinematics::tests::{g1, numbers};
use super::super::pose::SurfacePoint;
use super::*;

fn at(machine: &Geometry, height_m: f64) -> Station<'_> {
    machine.station(&SurfacePoint::on_hemisphere(0.075, height_m).unwrap()).unwrap()
}

fn step(angle_deg: f64) -> AxisError {
    AxisError::of_motors(angle_deg.to_radians(), 0.01)
}

#[test]
fn a_full_step_moves_a_carriage_by_a_twentieth_of_a_millimetre() {
    assert!((step(1.8).carriage_m - 5e-5).abs() < 1e-18);
}

#[test]
fn without_errors_there_is_none() {
    let machine = g1();
    let shift = at(&machine, 0.03).shift(&[0.0; 4], 0.0).unwrap();
    assert!(shift.vector_m.norm() < 1e-12);
}

/// Central differences: the third-order term of a 1e-7 m step at a gain of 30 and a fold within millimetres is below 1e-5.
#[test]
fn gains_are_the_slopes_of_the_exact_error() {
    let machine = g1();
    let off_axis =
        SurfacePoint { position_m: Vector3::new(0.03, -0.04, 0.05), normal: Vector3::new(0.6, -0.2, 0.7) };
    for station in [at(&machine, 0.0), at(&machine, 0.045), machine.station(&off_axis).unwrap()] {
        for index in 0..CARRIAGES {
            let shift = |sign: f64| {
                let mut carriage_m = [0.0; CARRIAGES];
                carriage_m[index] = sign * 1e-7;
                station.shift(&carriage_m, 0.0).unwrap().normal_m
            };
            let slope = (shift(1.0) - shift(-1.0)) / 2e-7;
            assert!((slope - station.gain().carriages[index]).abs() < 1e-4 * slope.abs().max(0.1), "{slope}");
        }
        let shift = |sign: f64| station.shift(&[0.0; 4], sign * 1e-5).unwrap().normal_m;
        let slope = (shift(1.0) - shift(-1.0)) / 2e-5;
        assert!((slope - station.gain().table_m_rad).abs() < 1e-6, "{slope}");
    }
}

/// Model book 4.3: the worst combination is (-, -, +, +), and at the pole the platform shifts along Z alone.
#[test]
fn the_worst_combination_turns_the_platform() {
    let machine = g1();
    let worst = at(&machine, 0.015).extremal(&step(0.1));
    let same = worst.signs[0] * worst.signs[1] > 0.0 && worst.signs[2] * worst.signs[3] > 0.0;
    assert!(same && worst.signs[0] * worst.signs[2] < 0.0, "{worst:?}");
    assert!((at(&machine, 0.075).gain().carriage_sum() - 1.0).abs() < 1e-9);
}

/// Down to 1 near the pole, where all gains have one sign: equal errors are the worst there.
#[test]
fn the_gain_falls_with_height() {
    let machine = g1();
    let gains: Vec<f64> =
        (0..=75).map(|mm| at(&machine, 1e-3 * f64::from(mm)).gain().carriage_sum()).collect();
    assert!(gains.windows(2).all(|pair| pair[1] < pair[0] || (pair[1] - 1.0).abs() < 1e-9), "{gains:?}");
}

/// A small error is symmetric: with every sign turned the first order only changes its sign.
#[test]
fn small_errors_are_symmetric_to_first_order() {
    let machine = g1();
    let station = at(&machine, 0.02);
    let carriage_m = [2e-7, -1e-7, 1e-7, 3e-7];
    let there = station.shift(&carriage_m, 0.0).unwrap().normal_m;
    let back = station.shift(&carriage_m.map(|error| -error), 0.0).unwrap().normal_m;
    assert!((there + back).abs() < 1e-3 * there.abs());
}

/// Uniform errors of first order have the variance `sum(G^2) delta^2/3`; 4000 draws are within 5 % of its root
/// (4 standard errors of 1/sqrt(2 * 4000)).
#[test]
fn random_errors_spread_as_their_gains_say() {
    let machine = g1();
    let station = at(&machine, 0.045);
    let error = AxisError { carriage_m: 1e-6, table_rad: 0.0 };
    let mut next = numbers();
    let spread = station.monte_carlo(&error, 4000, &mut || 2.0 * next() - 1.0);
    let squares: f64 = station.gain().carriages.iter().map(|gain| gain * gain).sum();
    let expected_m = (squares / 3.0).sqrt() * 1e-6;
    assert!((spread.deviation_m / expected_m - 1.0).abs() < 0.05, "{spread:?} {expected_m}");
    assert!(spread.failed == 0 && spread.largest_m <= station.extremal(&error).largest_m * (1.0 + 1e-9));
}
