//! Counts that start anew, and what is too old to begin with.

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
