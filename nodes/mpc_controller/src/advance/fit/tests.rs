use super::*;

impl Fit {
    /// Frames that were taken in, older ones for less.
    pub(in crate::advance) fn weight(&self) -> f64 {
        self.weight
    }

    /// Sums of what the frames told where the factor is 1, and of that times what the factor did to them.
    pub(in crate::advance) fn told(&self) -> (f64, f64) {
        (self.driven.plain - self.errors.plain, self.driven.products[0] - self.errors.products[0])
    }
}

/// What the printer needs of each part of the law `[-]`.
fn coefficients(needs: &Learnt) -> Triple {
    Triple::new(needs.factor, needs.index * needs.force(), needs.narrowed)
}

const NOISE: f64 = 0.05;
const REACH: Triple = Triple::new(0.4, 0.2, 0.5);

/// Frames of a printer of `needs`, about a constant error, whose levers go through all of their range.
fn frames(fit: &mut Fit, needs: Triple, offset: f64, is_narrowed: bool) {
    for frame in 0..400 {
        let wave = |rate: f64| (rate * f64::from(frame)).sin();
        let narrowed = if is_narrowed { 0.4 * wave(2.3) } else { 0.0 };
        let levers = Triple::new(0.6 * wave(0.7), 0.3 * wave(1.9), narrowed);
        // what the drive pushes beside it shows in the width
        let error = 0.2 * (levers[0] + levers[2]);
        let driven = needs.dot(&levers) + offset + needs[0] * error;
        fit.take(levers, (driven, error), 1.0 - 1.0 / 200.0);
    }
}

/// What a constant error adds to every answer is no law's, and the prior of `NOISE` over the reach takes some per cent.
#[test]
fn each_coefficient_is_found_beside_a_constant_error() {
    let mut fit = Fit::default();
    let needs = Learnt { factor: 1.2, index: 0.1, narrowed: 0.25 };
    frames(&mut fit, coefficients(&needs), 0.07, true);
    let found = fit.learnt(NOISE, REACH);
    let apart = [found.factor - 1.2, found.index - 0.1, found.narrowed - 0.25];
    assert!(apart.iter().all(|apart| apart.abs() < 0.01), "{found:?}");
}

/// A width shows `(d - rho h)/rho` of a printer that needs rho: the error is weighed with the factor that it tells.
#[test]
fn errors_are_weighed_with_the_factor_that_they_tell() {
    for needed in [0.7, 1.0, 1.35] {
        let mut fit = Fit::default();
        for frame in 0..400 {
            let lever = 0.6 * (0.7 * f64::from(frame)).sin();
            let error = (1.0 / needed - 1.0) * lever + 0.03;
            fit.take(Triple::new(lever, 0.0, 0.0), (lever, error), 1.0 - 1.0 / 200.0);
        }
        let found = fit.learnt(NOISE, REACH).factor;
        assert!((found - needed).abs() < 0.01, "{found} of {needed}");
    }
}

#[test]
fn each_stays_within_its_reach_and_none_is_learnt_without() {
    let mut fit = Fit::default();
    frames(&mut fit, Triple::new(3.0, -2.0, 4.0), 0.0, true);
    let found = fit.learnt(NOISE, REACH);
    let expected = Learnt { factor: 1.4, index: -0.2, narrowed: 0.5 };
    assert_eq!(found, expected);
    assert_eq!(fit.learnt(NOISE, Triple::new(0.0, 0.2, 0.5)), Learnt::NOTHING);
    let factor_alone = fit.learnt(NOISE, Triple::new(0.4, 0.0, 0.0));
    assert!(factor_alone.index.abs() < 1e-6 && factor_alone.narrowed.abs() < 1e-6, "{factor_alone:?}");
    assert_eq!(Fit::default().learnt(NOISE, REACH), Learnt::NOTHING);
}

/// A nozzle that narrows is told apart from what was learnt of it while it was sound; once it has come free that is what is left.
#[test]
fn a_narrowing_is_told_apart_and_forgotten() {
    let mut fit = Fit::default();
    frames(&mut fit, Triple::new(1.1, 0.05, 0.0), 0.0, false);
    let sound = fit.learnt(NOISE, REACH);
    frames(&mut fit, Triple::new(1.1, 0.05, 0.3), 0.0, true);
    let narrowed = fit.learnt(NOISE, REACH);
    assert!((narrowed.narrowed - 0.3).abs() < 0.01 && (narrowed.factor - 1.1).abs() < 0.01, "{narrowed:?}");
    fit.forget_narrowing();
    let free = fit.learnt(NOISE, REACH);
    assert!(free.narrowed.abs() < 1e-12 && (free.factor - sound.factor).abs() < 0.02, "{free:?}");
}

/// The whole law times the factor, its melt's part more where the nozzle has narrowed, bent about `INDEX_AT_M_S`.
#[test]
fn a_law_with_what_was_learnt_is_the_sum_of_its_parts() {
    let law = AdvanceLaw { linear_s: 0.4, shear: 1e-2, index: 0.45 };
    let learnt = Learnt { factor: 1.1, index: 0.02, narrowed: 0.2 };
    for feed_m_s in [0.6e-3, INDEX_AT_M_S, 2.4e-3] {
        let sum_m = coefficients(&learnt).dot(&parts_m(&law, feed_m_s, 1e-4));
        let held_m = learnt.of(law).held_m(feed_m_s);
        // of second order in the offset of the index
        assert!((held_m / sum_m - 1.0).abs() < 2e-4, "{held_m} {sum_m}");
    }
}
