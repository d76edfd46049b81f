use super::*;
use crate::health::tests::PARAMS as HEALTH;
use crate::ukf::Innovation;
use nalgebra::{Matrix1, Vector1};

const TRUST: RawTrust = RawTrust {
    age_limit_s: 0.5,
    gate: 16.0,
    step_samples: 8,
    step_fade: 0.6,
    gate_again: 4.0,
    step_threshold: 4.5,
};

/// An innovation of so many sigma, behind the gate of [`TRUST`].
fn update(sigmas: f64) -> Update<1> {
    let nis = sigmas * sigmas;
    let innovation = Innovation { residual: Vector1::new(sigmas), covariance: Matrix1::new(1.0), nis };
    if nis > TRUST.gate { Update::Rejected(innovation) } else { Update::Applied(innovation) }
}

/// Another rule than the channel's own: 2 * 3.8 / sqrt 2 = 5.4.
#[test]
fn a_step_is_looked_for_by_the_rule_that_is_asked_for() {
    let step = Step { samples: 2, threshold: 5.0, fade: 0.0 };
    let mut record = Record::new(TRUST, HEALTH, false);
    assert_eq!(record.note(&update(3.8), 0.0, step), Verdict::Consistent);
    assert_eq!(record.note(&update(3.8), 0.0, step), Verdict::Stepped);
    let mut record = Record::new(TRUST, HEALTH, false);
    let own = record.step();
    for _ in 0..7 {
        assert_eq!(record.note(&update(3.8), 0.0, own), Verdict::Consistent);
    }
    assert_eq!(record.note(&update(3.8), 0.0, own), Verdict::Stepped);
}

/// Ten against it are a divergence, the eleventh after a restart is the first of new ones.
#[test]
fn what_spoke_against_a_filter_is_over_when_it_starts_anew() {
    let mut record = Record::new(TRUST, HEALTH, true);
    let own = record.step();
    let note = |record: &mut Record, count: usize| {
        record.note(&update(if count.is_multiple_of(2) { 5.0 } else { -5.0 }), 0.0, own)
    };
    for count in 0..9 {
        assert_eq!(note(&mut record, count), Verdict::Rejected);
    }
    assert_eq!(note(&mut record, 9), Verdict::Diverged);
    record.restart();
    assert_eq!(note(&mut record, 10), Verdict::Rejected);
}

/// What is alive but was never used, or not for half a minute, tells of nothing; nor does what was used and is silent.
#[test]
fn a_channel_tells_while_it_is_alive_and_something_of_it_is_used() {
    let told = |seen_s: Option<f64>, used_s: Option<f64>| {
        let mut record = Record::new(TRUST, HEALTH, false);
        (record.seen_s, record.used_s) = (seen_s, used_s);
        record.tells(100.0)
    };
    assert!(told(Some(99.6), Some(99.6)) && told(Some(99.6), Some(70.1)));
    assert!(!told(Some(99.6), None) && !told(Some(99.6), Some(69.9)));
    assert!(!told(Some(99.4), Some(99.4)) && !told(None, None));
}

/// What the newest innovation deviates by is told with its sign, until it is older than the channel's limit or a step.
#[test]
fn an_innovation_deviates_until_it_is_old() {
    let mut record = Record::new(TRUST, HEALTH, false);
    assert!(record.deviates(100.0).abs() < 1e-12);
    let own = record.step();
    record.note(&update(1.0), 0.0, own);
    record.note(&update(-3.0), 0.0, own);
    record.used_s = Some(100.0);
    assert!((record.deviates(100.5) + 3.0).abs() < 1e-12 && record.deviates(100.6).abs() < 1e-12);
    record.begin();
    assert!(record.deviates(100.5).abs() < 1e-12);
}
