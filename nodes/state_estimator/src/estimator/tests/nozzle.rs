//! A sensor in the nozzle, where one is fitted.

use super::*;

fn nozzle_c(estimate: &Estimate) -> f64 {
    Celsius::from(Kelvin(estimate.x[state::NOZZLE])).0
}

fn nozzle_std_k(estimate: &Estimate) -> f64 {
    estimate.p[(state::NOZZLE, state::NOZZLE)].sqrt()
}

/// A joint that conducts worse than the model's: only a sensor shows that the nozzle is 6 K colder.
#[test]
fn a_sensor_in_the_nozzle_tells_what_the_model_cannot_know() {
    let mut rig = Rig::new();
    let blind = rig.run(6000);
    assert!(!blind.observed[state::NOZZLE] && nozzle_std_k(&blind) > 1.0, "{}", nozzle_std_k(&blind));
    let truth_c = nozzle_c(&blind) - 6.0;
    rig.nozzle = Some(Celsius(truth_c));
    let seen = rig.run(1000);
    assert!((nozzle_c(&seen) - truth_c).abs() < 0.3, "{} of {truth_c}", nozzle_c(&seen));
    assert!(seen.observed[state::NOZZLE] && nozzle_std_k(&seen) < 0.3, "{}", nozzle_std_k(&seen));
    assert!(seen.alive[Channel::Nozzle as usize]);
    assert_eq!(seen.resets, 0);
}

/// Its own walk counts while it is fitted, but where widths tell of the slip.
#[test]
fn a_sensor_in_the_nozzle_is_followed_by_its_own_walk() {
    let std_k = |walk: &str, encoder: bool, fitted: bool| {
        let mut rig = Rig::with(&[("nozzle_seen_k: 0.06 ", walk)]);
        rig.encoder = encoder;
        let before_c = nozzle_c(&rig.run(100));
        rig.nozzle = fitted.then_some(Celsius(before_c));
        nozzle_std_k(&rig.run(1000))
    };
    let ratio = |encoder, fitted| {
        std_k("nozzle_seen_k: 0.2 ", encoder, fitted) / std_k("nozzle_seen_k: 0.02 ", encoder, fitted)
    };
    assert!(ratio(true, true) > 1.5, "{}", ratio(true, true));
    assert!((ratio(true, false) - 1.0).abs() < 1e-9, "none is fitted");
    assert!((ratio(false, true) - 1.0).abs() < 1e-9, "widths tell of the slip");
}

/// It fails: what the model says counts again, and that it is not known well.
#[test]
fn a_sensor_that_falls_silent_is_out() {
    let mut rig = Rig::new();
    let before_c = nozzle_c(&rig.run(6000));
    rig.nozzle = Some(Celsius(before_c - 6.0));
    rig.run(1000);
    rig.nozzle = None;
    let silent = rig.run(6000);
    assert!(!silent.alive[Channel::Nozzle as usize] && !silent.observed[state::NOZZLE]);
    assert!(nozzle_std_k(&silent) > 1.0, "{}", nozzle_std_k(&silent));
    assert!((nozzle_c(&silent) - before_c).abs() < 1.0, "{} of {before_c}", nozzle_c(&silent));
}

/// It reads 60 K less at once, as one that has fallen out: told as a model that does not fit, and the filter goes on.
#[test]
fn a_sensor_that_reads_what_cannot_be_is_told() {
    let mut rig = Rig::new();
    let sound_c = nozzle_c(&rig.run(6000));
    rig.nozzle = Some(Celsius(sound_c));
    assert_eq!(rig.run(2000).health, EstimateHealth::Sound);
    rig.nozzle = Some(Celsius(sound_c - 60.0));
    let odd = rig.run(9000);
    assert_eq!(odd.health, EstimateHealth::Mismatch, "chi2 {:?}", odd.window[Channel::Nozzle as usize]);
    assert_eq!(odd.resets, 0);
    assert!(
        (Celsius::from(Kelvin(odd.x[state::BLOCK])).0 - 226.0).abs() < 3.0,
        "the block is the thermistor's"
    );
}

/// A part fan that turns at 30 % of what its duty gives cools by as much.
#[test]
fn a_fan_cools_as_it_turns_not_as_it_is_driven() {
    let settled_c = |fan| {
        let mut rig = Rig::new();
        rig.host = Box::new(move |status| (status.fan, status.part_fan_speed_1_s) = fan);
        nozzle_c(&rig.run(6000))
    };
    let (driven_c, weak_c) = (settled_c((1.0, None)), settled_c((0.3, None)));
    assert!(weak_c > driven_c + 2.0, "{weak_c} of {driven_c}");
    assert!((settled_c((1.0, Some(0.3 * 83.0))) - weak_c).abs() < 1e-9);
    assert!((settled_c((1.0, Some(90.0))) - driven_c).abs() < 1e-9, "no more than full");
}
