//! Counts that start anew, and samples that are too old or do not come.

use super::*;

/// An encoder that was plugged in again counts from elsewhere: no speed lies between its two counts.
#[test]
fn an_encoders_new_count_is_no_speed() {
    let mut rig = Rig::new();
    let before = rig.run(1000);
    rig.fed_m = -5.0;
    let after = rig.run(500);
    let nis = after.nis_mean[Channel::Encoder as usize].unwrap();
    assert!(nis < 1.0, "{nis}");
    assert_eq!((after.steps, after.resets), (before.steps, before.resets));
    assert_eq!(after.gated, before.gated);
    assert!((after.x[state::FLOW] / FEED_M_S - 1.0).abs() < 0.03, "{}", after.x[state::FLOW]);
}

/// A job that sets the motor's count anew, 5 m back.
#[test]
fn a_motors_new_count_is_no_speed() {
    let mut rig = Rig::new();
    let before = rig.run(1000);
    rig.motor_m = -5.0;
    let after = rig.run(500);
    assert_eq!((after.steps, after.resets), (before.steps, before.resets));
    assert_eq!(after.gated, before.gated);
    assert!((after.x[state::FLOW] / FEED_M_S - 1.0).abs() < 0.03, "{}", after.x[state::FLOW]);
}

/// A reading of before the print tells nothing of now: the filter waits for the next.
#[test]
fn no_filter_starts_from_an_old_temperature() {
    let mut estimator = Rig::new().estimator;
    estimator.on_event(Event::Hotend { stamp: Seconds(0.1), temp: Celsius(25.0) });
    let mut tick = |now_s: f64, temp: Option<f64>| {
        estimator.on_event(Event::Printer(status(now_s, 0.0)));
        if let Some(temp) = temp {
            estimator.on_event(Event::Hotend { stamp: Seconds(now_s - 0.5), temp: Celsius(temp) });
        }
        estimator.on_event(Event::Tick { now: Seconds(now_s) })
    };
    assert_eq!(tick(10.0, None), None, "9.9 s old");
    // not older than the limit of 0.5 s
    let started = tick(10.5, Some(226.0)).unwrap();
    assert!((Celsius::from(Kelvin(started.x[state::BLOCK])).0 - 226.0).abs() < 1.0);
}

#[test]
fn without_a_status_there_is_no_estimate_and_a_silent_channel_is_out() {
    let mut rig = Rig::new();
    rig.run(200);
    for step in 1..=20 {
        let now_s = 2.0 + f64::from(step) * 0.05;
        rig.motor_m += FEED_M_S * 0.05;
        rig.estimator.on_event(Event::Printer(status(now_s, rig.motor_m)));
        let estimate = rig.estimator.on_event(Event::Tick { now: Seconds(now_s) }).unwrap();
        if step == 20 {
            assert!(!estimate.alive[Channel::Encoder as usize]);
            assert!(!estimate.alive[Channel::Thermistor as usize]);
            assert!(estimate.alive[Channel::Width as usize]);
        }
    }
    // age limit 0.25 s
    assert!(rig.estimator.on_event(Event::Tick { now: Seconds(3.2) }).is_some());
    assert!(rig.estimator.on_event(Event::Tick { now: Seconds(3.3) }).is_none());
}

/// A wheel that sticks for 0.3 s: no count comes, and none of it is a slip.
#[test]
fn an_encoder_that_stands_for_a_moment_tells_no_slip() {
    let mut rig = Rig::new();
    rig.run(1000);
    rig.slip = 1.0;
    for _ in 0..6 {
        let slip = rig.run(5).x[state::SLIP];
        assert!(slip < 0.05, "{slip}");
    }
    rig.slip = 0.01;
    let after = rig.run(300);
    assert!((after.x[state::SLIP] - 0.01).abs() < 0.02 && after.resets == 0, "{}", after.x[state::SLIP]);
}

/// 3.4 counts in 50 ms: each speed is known to 12 %, the way of half a second to 1.2 %.
#[test]
fn a_slip_of_a_slow_road_is_told_within_half_a_second() {
    let mut rig = Rig::new();
    rig.feed_m_s = 0.68e-3;
    let before = rig.run(3000);
    assert_eq!(before.steps, 0);
    rig.slip = 0.1;
    let after = rig.run(60);
    assert!((after.x[state::SLIP] - 0.1).abs() < 0.03 && after.steps > 0, "{}", after.x[state::SLIP]);
}
