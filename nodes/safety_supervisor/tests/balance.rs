//! The energy balance of the heater against closed forms: what it measures is power, in watts.
#![allow(clippy::unwrap_used, reason = "a test may panic")]
#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts of steps")]

mod common;

use common::params;
use models::units::{Celsius, Seconds};
use safety_supervisor::checks::heater::{Drive, HeaterCheck, HeaterFault};
use safety_supervisor::params::HeaterParams;

/// The shipped constants, with nothing that becomes usual.
fn strict() -> HeaterParams {
    HeaterParams { usual_time_s: 1e12, usual_max_w: 0.0, ..params().heater }
}

/// What the hot end does at a moment.
#[derive(Debug, Clone, Copy)]
struct Moment {
    sensor_c: f64,
    duty: f64,
    fan: f64,
    feed_m_s: f64,
}

/// Steps of 0.1 s from `from_s` on; the state of the printer comes with each reading.
fn follow(check: &mut HeaterCheck, (from_s, span_s): (f64, f64), moment: impl Fn(f64) -> Moment) {
    let mut motor_position_m = 1.0;
    let steps = (span_s / 0.1).round() as u32;
    for step in 0..steps {
        let time_s = f64::from(step) * 0.1;
        let now = moment(time_s);
        motor_position_m += now.feed_m_s * 0.1;
        let stamp = Seconds(from_s + time_s);
        check.on_drive(stamp, Drive { duty: now.duty, fan: now.fan, motor_position_m, slip: 0.0 });
        check.on_sample(stamp, Celsius(now.sensor_c));
    }
}

/// A temperature that stands still tells by how much order and losses differ, each by its own constant.
#[test]
fn at_rest_the_excess_is_what_losses_take_less_what_was_ordered() {
    for (sensor_c, duty, fan, feed_m_s) in [
        (210.0, 0.0, 0.0, 0.0),
        (210.0, 0.3145, 0.0, 0.0),
        (210.0, 0.3, 1.0, 0.0),
        (210.0, 0.3, 0.0, 2e-3),
        (240.0, 0.5, 0.5, 1e-3),
        (25.0, 0.0, 1.0, 0.0),
        (15.0, 0.0, 0.0, 0.0),
    ] {
        let mut check = HeaterCheck::new(strict());
        follow(&mut check, (1000.0, 40.0), |_| Moment { sensor_c, duty, fan, feed_m_s });
        let expected_w = (0.068 + 0.029 * fan + 4.7 * feed_m_s) * (sensor_c - 25.0) - 40.0 * duty;
        let excess_w = check.excess_w();
        assert!(
            (excess_w - expected_w).abs() < 1e-3,
            "{sensor_c} {duty} {fan} {feed_m_s}: {excess_w} {expected_w}"
        );
        // The block is as warm as its thermistor, and what warms it is nothing.
        assert!((check.block().0 - sensor_c).abs() < 0.01);
        let balance = check.balance().unwrap();
        assert!((balance.disturbance_w - expected_w).abs() < 0.05 && balance.warming_w.abs() < 0.05);
    }
}

/// A heater without losses to speak of, as the thermistor sees it through its lag `tau`: with power `p` from zero on
/// `T_s = T_0 + p/C (t - tau (1 - e^(-t/tau)))`.
fn ramp_c(power_w: f64, time_s: f64) -> f64 {
    let (capacity, lag_s) = (16.7, 4.5);
    210.0 + power_w / capacity * (time_s - lag_s * (1.0 - (-time_s / lag_s).exp()))
}

/// The error of a triple pole at -w dies as `e^-wt (1 + wt + (wt)^2/2)`: that much of 20 W is not seen yet.
#[test]
fn power_that_nobody_ordered_shows_with_three_equal_poles() {
    let lossless = HeaterParams { loss_w_k: 1e-9, fan_loss_w_k: 0.0, feed_heat_j_k_m: 0.0, ..strict() };
    let rest = Moment { sensor_c: 210.0, duty: 0.0, fan: 0.0, feed_m_s: 0.0 };
    for seconds in [2.0_f64, 3.0, 4.0, 6.0] {
        let mut check = HeaterCheck::new(HeaterParams { spike_k: 100.0, ..lossless });
        follow(&mut check, (0.0, 30.0), |_| rest);
        follow(&mut check, (30.0, seconds + 0.1), |time_s| Moment { sensor_c: ramp_c(20.0, time_s), ..rest });
        let left = (-seconds).exp() * (1.0 + seconds + seconds * seconds / 2.0);
        let seen = check.excess_w() / 20.0;
        // Steps of a tenth of the time constant: the discrete poles lie at (1 - 0.1)^10 = 0.35 a second, not at 0.37.
        assert!((seen - (1.0 - left)).abs() < 0.06, "{seconds} s: {seen} of {}", 1.0 - left);
    }
}

fn fault_after(power_w: f64, duty: f64, span_s: f64, params: HeaterParams) -> Option<HeaterFault> {
    let mut check = HeaterCheck::new(HeaterParams { loss_w_k: 1e-9, ..params });
    let rest = Moment { sensor_c: 210.0, duty: 0.0, fan: 0.0, feed_m_s: 0.0 };
    follow(&mut check, (0.0, 30.0), |_| rest);
    assert_eq!(check.fault(false), None);
    follow(&mut check, (30.0, span_s), |time_s| Moment { sensor_c: ramp_c(power_w, time_s), duty, ..rest });
    check.fault(false)
}

/// 16 W without order trip the fast observer, 10.5 W that are missing; slower and less the slow one.
#[test]
fn p1_p2_the_limits_are_those_of_the_file() {
    let params = HeaterParams { spike_k: 100.0, ..strict() };
    assert_eq!(fault_after(17.0, 0.0, 20.0, params), Some(HeaterFault::StuckOn));
    assert_eq!(fault_after(15.0, 0.0, 20.0, params), None);
    assert_eq!(fault_after(0.0, 0.275, 7.0, params), Some(HeaterFault::Deficit), "11 W are missing");
    assert_eq!(fault_after(0.0, 0.2, 5.0, params), None, "8 W are for the slow one");
    assert_eq!(fault_after(0.0, 0.2, 20.0, params), Some(HeaterFault::Deficit));
    assert_eq!(fault_after(0.0, 0.1, 30.0, params), None, "4 W are nothing");
    // 7 W are a deficit as more than half of 12 W, and none of 18 W: a draught is no share of the order.
    assert_eq!(fault_after(5.0, 0.3, 30.0, params), Some(HeaterFault::Deficit));
    assert_eq!(fault_after(11.0, 0.45, 30.0, params), None);
    assert_eq!(fault_after(-20.0, 0.0, 20.0, params), None, "no more can be missing than was ordered");
    // Of 40 W that were ordered and warm, a quarter of what arrives is the error of the capacity.
    assert_eq!(fault_after(33.0, 1.0, 20.0, params), None);
    assert_eq!(fault_after(25.0, 1.0, 20.0, params), Some(HeaterFault::Deficit));
}

#[test]
fn a_disturbance_that_lasts_becomes_usual_as_far_as_it_may() {
    let params = HeaterParams { usual_time_s: 45.0, usual_max_w: 6.0, ..strict() };
    let rest = |duty: f64| Moment { sensor_c: 210.0, duty, fan: 0.0, feed_m_s: 0.0 };
    let losses_w = 0.068 * 185.0;
    for (beyond_w, left_w) in [(4.0, 0.0), (9.0, 3.0), (-9.0, -3.0)] {
        let mut check = HeaterCheck::new(params);
        follow(&mut check, (0.0, 600.0), |_| rest((losses_w - beyond_w) / 40.0));
        let excess_w = check.excess_w();
        assert!((excess_w - left_w).abs() < 0.01, "{beyond_w}: {excess_w}");
    }
    // After 45 s and the observer's own 3 s two thirds of 4 W are usual.
    let mut check = HeaterCheck::new(params);
    follow(&mut check, (0.0, 49.0), |_| rest((losses_w - 4.0) / 40.0));
    assert!((check.excess_w() - 4.0 * (-1.0_f64).exp()).abs() < 0.15, "{}", check.excess_w());
}

/// S2: while the reading repeats itself the balance adds up to how far it should have gone.
#[test]
fn s2_a_reading_that_stands_still_is_told_how_far_it_should_have_gone() {
    let mut check = HeaterCheck::new(strict());
    let standing = |duty: f64| Moment { sensor_c: 210.0, duty, fan: 0.0, feed_m_s: 0.0 };
    follow(&mut check, (0.0, 2.1), |time_s| Moment { sensor_c: 210.0 + 1e-6 * time_s, ..standing(0.0) });
    assert!(check.moved_k().abs() < 1e-12, "it moves by itself");
    follow(&mut check, (2.1, 10.0), |_| standing(0.8));
    // (32 W - 12.58 W) / 16.7 J/K for 9.9 s after the first of the repeated readings, through a lag of 4.5 s; the
    // balance has just begun, and sees the block 0.6 K off.
    let lagged_s = 9.9 - 4.5 * (1.0 - (-9.9_f64 / 4.5).exp());
    let expected_k = (40.0 * 0.8 - 0.068 * 185.0) / 16.7 * lagged_s;
    assert!((check.moved_k() - expected_k).abs() < 0.7, "{} {expected_k}", check.moved_k());
    check.reset();
    assert!(check.moved_k().abs() < 1e-12 && check.balance().is_none());
}

/// What has become usual warms nothing: a reading under 4 W of a draught may repeat itself.
#[test]
fn s2_what_is_usual_does_not_add_up() {
    let mut check = HeaterCheck::new(HeaterParams { usual_time_s: 45.0, usual_max_w: 6.0, ..strict() });
    let standing = Moment { sensor_c: 210.0, duty: (0.068 * 185.0 - 4.0) / 40.0, fan: 0.0, feed_m_s: 0.0 };
    follow(&mut check, (0.0, 600.0), |_| standing);
    let before_k = check.moved_k();
    follow(&mut check, (600.0, 10.0), |_| standing);
    assert!((check.moved_k() - before_k).abs() < 0.01, "{}", check.moved_k() - before_k);
}

/// A gap of more than 1.5 s says nothing of the heat in between: the balance begins anew, and what it says counts
/// after ten samples and five time constants.
#[test]
fn a_gap_begins_anew() {
    let dead = |_| Moment { sensor_c: 210.0, duty: 0.5, fan: 0.0, feed_m_s: 0.0 };
    let mut check = HeaterCheck::new(strict());
    follow(&mut check, (0.0, 30.0), dead);
    assert!(check.balance().is_some() && check.excess_w().abs() > 1.0);
    follow(&mut check, (31.3, 0.1), dead);
    assert!(check.balance().is_some() && check.is_judging(), "1.4 s are none");
    follow(&mut check, (33.0, 1.0), dead);
    assert!(check.balance().is_none() && check.excess_w().abs() < 1e-12);
    follow(&mut check, (34.0, 4.5), dead);
    assert!(!check.is_judging(), "the fast one needs 5 s");
    follow(&mut check, (38.5, 1.0), dead);
    assert!(check.is_judging() && check.balance().is_none());
    follow(&mut check, (39.5, 4.0), dead);
    assert!(check.balance().is_none(), "the slow one needs 10 s");
    follow(&mut check, (43.5, 2.0), dead);
    assert!(check.balance().is_some());
}

/// Three spikes are left out, what stays after them is taken for what it is.
#[test]
fn s4_spikes_are_no_heat() {
    let holding = Moment { sensor_c: 210.0, duty: 0.3145, fan: 0.0, feed_m_s: 0.0 };
    for (count, believed) in [(1_u32, false), (3, false), (5, true)] {
        let mut check = HeaterCheck::new(strict());
        follow(&mut check, (0.0, 30.0), |_| holding);
        follow(&mut check, (30.0, f64::from(count) * 0.1), |_| Moment { sensor_c: 260.0, ..holding });
        assert_eq!(check.excess_w().abs() > 10.0, believed, "{count}: {}", check.excess_w());
    }
}

/// A sample waits for the state of its moment; a state that comes late is used all the same.
#[test]
fn samples_wait_for_the_state_of_their_moment() {
    let drive = |duty: f64| Drive { duty, fan: 0.0, motor_position_m: 0.0, slip: 0.0 };
    let mut check = HeaterCheck::new(strict());
    for step in 0..400_u32 {
        let stamp = Seconds(f64::from(step) * 0.1);
        check.on_sample(stamp, Celsius(210.0));
        if step % 5 == 4 {
            check.on_drive(stamp, drive(0.5));
        }
    }
    let expected_w = 0.068 * 185.0 - 20.0;
    assert!((check.excess_w() - expected_w).abs() < 1e-2, "{} {expected_w}", check.excess_w());
}
