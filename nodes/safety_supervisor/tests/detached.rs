//! P3: a reading that falls faster than any heater cools.

use models::units::{Celsius, Seconds};
use safety_supervisor::checks::detached::DetachedCheck;
use safety_supervisor::params::DetachedParams;

/// Four samples of 10 Hz and the one before them span 0.4 s.
#[test]
fn a_fall_faster_than_any_cooling_trips_and_nothing_slower_or_shorter() {
    let params = DetachedParams { fall_k_s: 5.0, span_max_s: 1.2, samples: 5 };
    let after = |samples: u32, fall_k_s: f64, period_s: f64| {
        let mut check = DetachedCheck::new(params);
        for number in 0..samples {
            let time_s = 100.0 + f64::from(number) * period_s;
            check.on_sample(Seconds(time_s), Celsius(210.0 - fall_k_s * f64::from(number) * period_s));
        }
        check.tripped()
    };
    // The first span needs four samples before it, the fifth in a row four more.
    assert!(!after(8, 5.5, 0.1) && after(9, 5.5, 0.1));
    assert!(!after(25, 4.5, 0.1), "slower");
    assert!(after(60, 4.5, 0.1), "but for seconds");
    assert!(!after(300, 2.4, 0.1), "still slower");
    assert!(!after(50, -5.5, 0.1), "rising");
    assert!(!after(6, 5.5, 1.2), "1.2 s are a gap, not a span");
    assert!(
        !after(4, 5.5, 0.25) && after(5, 5.5, 0.25),
        "two readings of 4 Hz are a span, and three spans in a row"
    );
    assert!(!after(2, 5.5, 1.0) && after(3, 5.5, 1.0), "one of 1 Hz, and two");
    assert!(!after(50, 5.5, 0.0), "no time at all");
    assert!(after(50, 5.5, 0.24), "0.96 s are one");
}

/// A fall is known with its first fast span, long before it trips, and over with the first slow one.
#[test]
fn a_fall_is_known_before_it_trips() {
    let mut check = DetachedCheck::new(DetachedParams { fall_k_s: 5.0, span_max_s: 1.2, samples: 5 });
    let mut falling = |number: u32, temp_c: f64| {
        check.on_sample(Seconds(f64::from(number) * 0.1), Celsius(temp_c));
        (check.is_falling(), check.tripped())
    };
    for number in 0..5 {
        assert_eq!(falling(number, 210.0), (false, false));
    }
    assert_eq!(falling(5, 207.0), (true, false));
    for number in 6..9 {
        falling(number, 207.0);
    }
    assert_eq!(falling(9, 207.0), (false, false));
}

/// A reading of 10 Hz that sinks at 4 K/s for 8 s and then falls at 20 K/s: first half of 5 K/s is the limit, which no heater
/// keeps up for seconds, and with the fifth fast span 5 K/s itself.
#[test]
fn a_fall_is_told_beside_the_limit_that_it_went_beyond() {
    let mut check = DetachedCheck::new(DetachedParams { fall_k_s: 5.0, span_max_s: 1.2, samples: 5 });
    let (mut temp_c, mut fast) = (210.0, 0);
    for number in 0..200_u32 {
        let rate_k_s = match number {
            0..100 => 0.0,
            100..180 => 4.0,
            _ => 20.0,
        };
        temp_c -= 0.1 * rate_k_s;
        check.on_sample(Seconds(0.1 * f64::from(number)), Celsius(temp_c));
        fast = if check.is_falling() { fast + 1 } else { 0 };
        let (fall_k_s, most_k_s) = check.fall_k_s();
        let (falls_k_s, limit_k_s) = match (fast >= 5, check.tripped()) {
            (true, _) => (6.0..20.1, 5.0),
            (false, true) => (2.5..5.1, 2.5),
            (false, false) => (-0.1..5.0, 5.0),
        };
        assert!(falls_k_s.contains(&fall_k_s), "{number}: {fall_k_s} of {most_k_s}");
        assert!((most_k_s - limit_k_s).abs() < 1e-9, "{number}: {fall_k_s} of {most_k_s}");
    }
    assert_eq!(fast, 20, "from the first fast reading on");
}

/// A fifth of 5 K/s is at rest, either way.
#[test]
fn a_reading_that_has_all_but_stopped_is_at_rest() {
    for (rate_k_s, at_rest) in [(0.9, true), (1.1, false), (4.0, false), (-0.9, true), (-1.1, false)] {
        let mut check = DetachedCheck::new(DetachedParams { fall_k_s: 5.0, span_max_s: 1.2, samples: 5 });
        for number in 0..5 {
            let time_s = f64::from(number) * 0.1;
            check.on_sample(Seconds(time_s), Celsius(210.0 - rate_k_s * time_s));
        }
        assert_eq!(check.is_at_rest(), at_rest, "{rate_k_s}");
    }
}

#[test]
fn a_spike_is_no_fall() {
    let mut check = DetachedCheck::new(DetachedParams { fall_k_s: 5.0, span_max_s: 1.2, samples: 5 });
    for number in 0..100 {
        let temp_c = if number % 10 == 4 { 40.0 } else { 210.0 };
        check.on_sample(Seconds(f64::from(number) * 0.1), Celsius(temp_c));
        assert!(!check.tripped(), "{number}");
    }
}
