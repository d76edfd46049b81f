//! P2: heat that was ordered and does not come.

use safety_supervisor::Cause;

use super::common::Heater;
use super::{Loop, cold, idle, printing, reaction, seeds};

/// P2: dead 5 s, loose 8 s, weak 15 s.
#[test]
fn p2_a_heater_without_power_is_given_up() {
    let causes = [Cause::HeaterDeficit];
    for (name, start) in [("at target", idle as fn(u64) -> Heater), ("printing", printing)] {
        let fault = |gain: f64| move |heater: &mut Heater| heater.gain = gain;
        assert!(reaction(&format!("P2 dead, {name}"), start, fault(0.0), &causes) <= 5.0);
        assert!(reaction(&format!("P2 loose, {name}"), start, fault(0.2), &causes) <= 8.0);
        assert!(reaction(&format!("P2 weak, {name}"), start, fault(0.5), &causes) <= 15.0);
    }
}

/// P2 on the way up: the fault is there before the heater is switched on, or comes in the middle.
#[test]
fn p2_a_dead_heater_shows_during_heat_up() {
    let causes = [Cause::HeaterDeficit];
    let from_cold = |heater: &mut Heater| (heater.target_c, heater.gain) = (215.0, 0.0);
    assert!(reaction("P2 dead, from cold", cold, from_cold, &causes) <= 5.0);
}

/// Times to the trip of a heater that fails as the set-point falls by 5 K: from the fall, and from when heat is ordered
/// again: a quarter of full power, as a mean of half a second, for noise alone makes single orders of more.
fn found_after_a_fall(seed: u64, gain: f64) -> (f64, f64) {
    let mut run = Loop::new(printing(seed));
    assert_eq!(run.run(60.0 + seed as f64 * 0.137), None, "seed {seed}: {:?}", run.cause);
    (run.heater.target_c, run.heater.gain) = (run.heater.target_c - 5.0, gain);
    let (mut order, mut fall_s) = (run.heater.duty, 0.0);
    while fall_s < 1.0 || order < 0.25 {
        assert_eq!(run.run(0.1), None, "seed {seed}: {:?} before heat is ordered again", run.cause);
        fall_s += 0.1;
        order += (run.heater.duty - order) * 0.1 / 0.5;
        assert!(
            !(1.0..1.1).contains(&fall_s) || order < 0.25,
            "seed {seed}: the order did not fall: {order}"
        );
        assert!(fall_s < 10.0, "seed {seed}: no heat is ordered");
    }
    let time_s = run.run(60.0).unwrap_or(f64::INFINITY);
    assert_eq!(run.cause, Some(Cause::HeaterDeficit), "seed {seed}");
    (fall_s + time_s, time_s)
}

/// P2: no heat is ordered for the first seconds, and that it does not come shows only after them: as soon as ever then.
/// `config/faults.yaml` gives a dead one 9 s from the fall, a loose one 11 s.
#[test]
fn p2_a_heater_that_fails_as_the_set_point_falls_is_found_once_heat_is_ordered_again() {
    for (name, gain, fall_limit_s, limit_s) in [("dead", 0.0, 8.0, 5.0), ("loose", 0.2, 10.0, 8.0)] {
        let times = (0..seeds()).map(|seed| found_after_a_fall(seed, gain));
        let (fall_s, worst_s) =
            times.fold((0.0, 0.0), |worst: (f64, f64), time| (worst.0.max(time.0), worst.1.max(time.1)));
        println!("P2 {name}: worst {fall_s:.2} s from the fall, {worst_s:.2} s from the order");
        assert!(fall_s <= fall_limit_s && worst_s <= limit_s, "{name}: {fall_s} s, {worst_s} s");
    }
}
