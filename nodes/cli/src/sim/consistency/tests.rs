//! Errors over stated deviations.

use super::*;
use models::command::EstimateHealth;
use models::units::Seconds;
use nalgebra::SMatrix;
use state_estimator::{CHANNELS, Channel, Refusals, state};

/// The names stand where the estimator's indices point.
#[test]
fn the_states_are_named_in_the_estimators_order() {
    let named = [
        (state::BLOCK, "block"),
        (state::NOZZLE, "nozzle"),
        (state::SENSOR, "thermistor"),
        (state::FLOW, "flow"),
        (state::SLIP, "slip"),
        (state::GAIN, "gain"),
    ];
    for (index, name) in named {
        assert_eq!(STATE_NAMES[index], name);
    }
}

/// A block at this many kelvin, of which the estimator is sure to 2 K; the other states are known and right.
fn estimated(block_k: f64) -> Estimate {
    let mut p = SMatrix::identity();
    p[(state::BLOCK, state::BLOCK)] = 4.0;
    let x = SVector::from([block_k, 0.0, 0.0, 0.0, 0.0, 0.0]);
    Estimate {
        stamp: Seconds(0.0),
        x,
        p,
        nis: [None; CHANNELS],
        nis_mean: [None; CHANNELS],
        innovations: [None; CHANNELS],
        measured: [0; CHANNELS],
        gated: [0; CHANNELS],
        alive: [false; CHANNELS],
        observed: [false; STATES],
        window: [None; CHANNELS],
        reference_feed_m_s: 0.0,
        steps: 0,
        resets: 0,
        noise_scale: [1.0; CHANNELS],
        melt_lag: 1.0,
        health: EstimateHealth::Sound,
        refusals: Refusals::default(),
    }
}

fn of(estimates: &[Estimate]) -> Consistency {
    let laid = Truth { depositing: true, ..Truth::default() };
    let mut consistency = Consistency::default();
    estimates.iter().for_each(|estimate| consistency.add(estimate, &laid));
    consistency
}

/// 1.96 times 2 K are 3.92 K, to either side.
#[test]
fn an_interval_covers_what_is_within_its_stated_deviations() {
    let errors_k = [3.9, -3.9, 3.95, -3.95];
    let [block, others @ ..] = of(&errors_k.map(estimated)).coverage().unwrap();
    assert_eq!((block, others), (0.5, [1.0; 5]));
}

/// (2 K / 2 K)^2 = 1, (4 / 2)^2 = 4, (6 / 2)^2 = 9: the one between is told, in whatever order they come.
#[test]
fn the_error_is_squared_over_the_stated_variance() {
    assert_eq!(of(&[6.0, 2.0, -4.0].map(estimated)).median(), Some(4.0));
}

/// Errors of 2 and 2 with variances of 4 and a covariance of 2: (2, 2) P^-1 (2, 2) = 16 / 12.
#[test]
fn states_that_err_together_are_weighed_together() {
    let mut estimate = estimated(2.0);
    estimate.x[state::NOZZLE] = 2.0;
    estimate.p[(state::NOZZLE, state::NOZZLE)] = 4.0;
    estimate.p[(state::BLOCK, state::NOZZLE)] = 2.0;
    estimate.p[(state::NOZZLE, state::BLOCK)] = 2.0;
    let median = of(&[estimate]).median().unwrap();
    assert!((median - 4.0 / 3.0).abs() < 1e-12, "{median}");
}

#[test]
fn a_covariance_that_is_none_vouches_for_nothing() {
    let mut estimate = estimated(0.0);
    estimate.p[(state::GAIN, state::GAIN)] = -1.0;
    assert_eq!(of(&[estimate]).median(), Some(f64::INFINITY));
}

/// Block 4 K off, of which 2 K are stated: 4 of one degree of freedom, whatever the others do that nothing tells of.
#[test]
fn states_that_nothing_tells_of_do_not_count_as_told() {
    let mut estimate = estimated(4.0);
    estimate.observed[state::BLOCK] = true;
    let mut off = estimate;
    (off.x[state::GAIN], off.observed[state::GAIN]) = (3.0, true);
    let told = of(&[estimate, off, estimate]).told().unwrap();
    assert_eq!(
        told,
        Told { states: vec!["block"], nees_median: 4.0, true_median: 0.455, band: [0.00098, 5.02] }
    );
    // 4 and 9 of two, once these are told of most of the time.
    let told = of(&[estimate, off, off]).told().unwrap();
    assert_eq!(
        told,
        Told { states: vec!["block", "gain"], nees_median: 13.0, true_median: 1.386, band: [0.0506, 7.38] }
    );
}

/// Of a block and a thermistor that err together alone their own covariance counts: 16 / 12, as above.
#[test]
fn what_is_told_of_is_weighed_by_its_own_covariance() {
    let mut estimate = estimated(2.0);
    (estimate.x[state::SENSOR], estimate.p[(state::SENSOR, state::SENSOR)]) = (2.0, 4.0);
    (estimate.p[(state::BLOCK, state::SENSOR)], estimate.p[(state::SENSOR, state::BLOCK)]) = (2.0, 2.0);
    (estimate.observed[state::BLOCK], estimate.observed[state::SENSOR]) = (true, true);
    estimate.x[state::SLIP] = 7.0;
    let median = of(&[estimate]).told().unwrap().nees_median;
    assert!((median - 4.0 / 3.0).abs() < 1e-12, "{median}");
}

#[test]
fn where_nothing_is_told_of_nothing_is_said_of_it() {
    assert_eq!(of(&[estimated(0.0)]).told(), None);
    assert_eq!(of(&[]).told(), None);
}

/// Wilson and Hilferty, from three degrees on: degrees (1 - a +- 1.96 sqrt(a))^3 with a = 2 / (9 degrees).
#[test]
fn the_bands_are_a_chi_squares() {
    for (degrees, band) in (1_u8..).map(f64::from).zip(BANDS).skip(2) {
        let a = 2.0 / (9.0 * degrees);
        let bounds = [-COVERED, COVERED].map(|z| degrees * (1.0 - a + z * a.sqrt()).powi(3));
        for (bound, stated) in bounds.into_iter().zip(band) {
            assert!((bound - stated).abs() < 0.02 * stated + 0.035, "{degrees}: {bound}, {stated}");
        }
    }
    // Of an even number of degrees what lies above is a sum of a Poisson distribution.
    for (half, band) in [(1, BANDS[1]), (2, BANDS[3]), (3, BANDS[5])] {
        let above = band.map(|bound| {
            let terms = (1..half).scan(1.0, |term, k| {
                *term *= 0.5 * bound / f64::from(k);
                Some(*term)
            });
            (-0.5 * bound).exp() * (1.0 + terms.sum::<f64>())
        });
        assert!((above[0] - 0.975).abs() < 2e-4 && (above[1] - 0.025).abs() < 2e-4, "{half}: {above:?}");
    }
    // One degree: the square of a Gaussian; two: an exponential distribution of mean 2.
    assert!((BANDS[0][1].sqrt() - 2.2414).abs() < 1e-3 && (BANDS[0][0].sqrt() - 0.03134).abs() < 1e-4);
    let two = [0.975_f64, 0.025].map(|above| -2.0 * above.ln());
    assert!(BANDS[1].iter().zip(two).all(|(stated, bound)| (stated - bound).abs() < 0.005), "{two:?}");
}

#[test]
fn only_what_is_laid_counts() {
    let mut consistency = Consistency::default();
    consistency.add(&estimated(100.0), &Truth::default());
    assert_eq!((consistency.coverage(), consistency.median()), (None, None));
    assert_eq!(consistency.blind().map(|names| names.len()), [0, 0]);
}

/// One moment is enough to be told of, or to move; slip is held where neither encoder nor widths live.
#[test]
fn blind_is_what_was_never_observed_and_held_what_never_moved() {
    let mut seen = estimated(0.0);
    (seen.observed[state::BLOCK], seen.observed[state::FLOW]) = (true, true);
    let blind = of(&[estimated(0.0), seen]).blind();
    assert_eq!(blind, [vec!["nozzle", "thermistor", "slip", "gain"], vec!["slip"]]);
    seen.alive[Channel::Encoder as usize] = true;
    assert_eq!(of(&[estimated(0.0), seen]).blind()[1], Vec::<&str>::new());
}

/// Wilson and Hilferty: the cube root of a chi-square over its degrees is about normal, with mean and median
/// 1 - 2 / (9 degrees).
#[test]
fn the_median_of_a_true_covariance_is_below_the_mean() {
    for (degrees, stated) in (1_u8..).map(f64::from).zip(MEDIANS) {
        let median = degrees * (1.0 - 2.0 / (9.0 * degrees)).powi(3);
        assert!((stated - median).abs() < 0.02, "{degrees}: {median}");
    }
}
