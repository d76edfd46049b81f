//! The checks one by one, against closed forms of what they measure.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::params;
use models::units::{Celsius, Seconds};
use safety_supervisor::checks::bad_values::Burst;
use safety_supervisor::checks::drive_history::DriveHistory;
use safety_supervisor::checks::frozen::FrozenCheck;
use safety_supervisor::checks::heater::Drive;
use safety_supervisor::checks::heater_start::Start;
use safety_supervisor::checks::range::RangeCheck;
use safety_supervisor::checks::run_out::RunOutCheck;
use safety_supervisor::checks::stale::StaleCheck;
use safety_supervisor::params::{
    BurstParams, DetachedParams, FilamentParams, FrozenParams, RangeParams, RunOutParams, StaleParams,
};
use safety_supervisor::{Defect, Reaction};

#[test]
fn a_burst_is_so_many_within_the_span_and_not_one_less() {
    let mut burst = Burst::new(BurstParams { count: 3, span_s: 1.0 });
    for stamp_s in [10.0, 10.5] {
        burst.note(Seconds(stamp_s));
    }
    assert!(!burst.tripped(Seconds(10.5)));
    burst.note(Seconds(10.9));
    assert!(burst.tripped(Seconds(10.9)) && burst.tripped(Seconds(11.0)));
    assert!(!burst.tripped(Seconds(11.01)), "the oldest of the three is older than the span");
    assert_eq!(burst.total(), 3);
}

#[test]
fn a_range_trips_on_samples_in_a_row_at_either_end() {
    for (good_c, bad_c) in [(0.0, -0.1), (285.0, 285.1)] {
        let mut check = RangeCheck::new(RangeParams { min_c: 0.0, max_c: 285.0, samples: 3 });
        for (time_s, temp_c) in [(0.0, bad_c), (0.1, bad_c), (0.2, good_c), (0.3, bad_c), (0.4, bad_c)] {
            check.on_sample(Seconds(time_s), Celsius(temp_c));
            assert_eq!((check.tripped(), check.is_inside()), (false, temp_c.to_bits() == good_c.to_bits()));
        }
        check.on_sample(Seconds(0.5), Celsius(bad_c));
        assert!(check.tripped());
        check.on_sample(Seconds(0.6), Celsius(good_c));
        assert!(!check.tripped());
    }
}

/// A spike of 0.1 s is ten readings of 100 Hz, and as little as one of 10 Hz; 0.2 s of them are three.
#[test]
fn a_range_counts_readings_of_ten_hertz() {
    let mut check = RangeCheck::new(RangeParams { min_c: 0.0, max_c: 285.0, samples: 3 });
    let tripped = (0..100_u32).find(|tick| {
        check.on_sample(Seconds(50.0 + 0.01 * f64::from(*tick)), Celsius(450.0));
        assert!(!check.is_inside());
        check.tripped()
    });
    assert!(tripped.is_some_and(|tick| (14..=20).contains(&tick)), "{tripped:?}");
}

#[test]
fn the_file_is_what_is_tested_here() {
    let params = params();
    assert_eq!(params.detached, DetachedParams { fall_k_s: 5.0, span_max_s: 1.2, samples: 5 });
    assert_eq!(params.run_out, RunOutParams { debounce_s: 0.3 });
    assert_eq!(
        params.filament,
        FilamentParams { window_m: 0.005, play_m: 1e-4, slip_max: 0.42, surplus_max: 0.25 }
    );
}

fn frozen(duty: [f64; 2], moved_k: f64) -> Option<u32> {
    let params = FrozenParams {
        suspect_s: 0.5,
        short_s: 3.0,
        middle_s: 5.0,
        long_s: 9.0,
        duty_change: 0.05,
        duty_stop: 0.99,
        duty_in_use: 0.02,
        moved_k: 1.5,
        room_max_c: 60.0,
    };
    let mut check = FrozenCheck::new(params);
    check.on_duty(duty[0]);
    (0..200).find(|tenths| {
        check.on_sample(Seconds(50.0 + f64::from(*tenths) * 0.1), Celsius(210.0));
        check.on_duty(duty[(tenths % 2) as usize]);
        assert!((check.still().0 - f64::from(*tenths) * 0.1).abs() < 1e-9);
        check.tripped(moved_k)
    })
}

/// In tenths of a second; rounding of the sums may cost one more.
#[test]
fn s2_a_still_reading_trips_sooner_the_more_it_should_have_moved() {
    let near =
        |found: Option<u32>, tenths: u32| found.is_some_and(|found| found == tenths || found == tenths + 1);
    assert!(near(frozen([1.0, 1.0], 0.0), 30), "the heater at its stop");
    assert!(near(frozen([0.5, 0.5], 1.5), 30), "the balance moved");
    assert!(near(frozen([0.5, 0.5], -1.5), 30), "or fell");
    assert!(near(frozen([0.50, 0.56], 0.0), 50), "the duty varies");
    assert!(near(frozen([0.5, 0.5], 0.0), 90), "the heater is in use");
    assert!(near(frozen([0.50, 0.53], 1.4), 90), "neither");
    assert_eq!(frozen([0.0, 0.0], 0.0), None, "nothing heats, nothing moves");
    assert_eq!(frozen([0.0, 0.04], 0.0), None, "on and off again");
}

#[test]
fn s2_a_reading_that_moves_begins_anew() {
    let mut check = FrozenCheck::new(params().frozen);
    check.on_duty(1.0);
    for tenths in 0..200 {
        let temp_c = 210.0 + f64::from(tenths / 25) * 1e-3;
        check.on_sample(Seconds(f64::from(tenths) * 0.1), Celsius(temp_c));
        assert!(!check.tripped(9.0), "2.5 s at most");
    }
    check.on_sample(Seconds(99.0), Celsius(210.007));
    assert!(check.tripped(0.0));
    check.reset();
    assert!(!check.tripped(9.0) && check.still().0 == 0.0);
}

fn drive(duty: f64, fan: f64, motor_position_m: f64) -> Drive {
    Drive { duty, fan, motor_position_m, slip: 0.0 }
}

#[test]
fn means_of_duty_fan_and_feed_are_weighted_by_time() {
    let mut history = DriveHistory::default();
    assert_eq!(history.means(Seconds(0.0), Seconds(1.0)), None);
    for (stamp_s, duty, fan, motor_m) in
        [(10.0, 0.2, 1.0, 0.0), (10.5, 0.6, 0.0, 1e-3), (11.0, 1.0, 0.5, 3e-3)]
    {
        history.push(Seconds(stamp_s), drive(duty, fan, motor_m));
    }
    // 0.25 s of the first, 0.5 s of the second, 1.25 s of the last one, which holds on: over 2 s.
    let means = history.means(Seconds(10.25), Seconds(12.25)).unwrap();
    assert!((means.duty - (0.2 * 0.25 + 0.6 * 0.5 + 1.0 * 1.25) / 2.0).abs() < 1e-12);
    assert!((means.fan - (1.0 * 0.25 + 0.5 * 1.25) / 2.0).abs() < 1e-12);
    // Half way of the first millimetre to the end of the third.
    assert!((means.feed_m_s - 2.5e-3 / 2.0).abs() < 1e-12);
    // What is before the first state is held on as well.
    let before = history.means(Seconds(9.0), Seconds(10.25)).unwrap();
    assert!((before.duty - 0.2).abs() < 1e-12 && (before.feed_m_s - 0.5e-3 / 1.25).abs() < 1e-12);
    assert_eq!(history.means(Seconds(10.5), Seconds(10.5)), None);
    assert_eq!(history.means(Seconds(10.6), Seconds(10.5)), None);
}

#[test]
fn a_line_through_samples_of_one_moment_is_level() {
    let mut start = Start::default();
    let begun =
        (0..10).filter_map(|number| start.on_sample(Seconds(3.0), Celsius(f64::from(number)), 4.5)).next();
    let begun = begun.unwrap();
    assert!((begun.sensor_c - 4.5).abs() < 1e-12 && (begun.block_c - 4.5).abs() < 1e-12, "{begun:?}");
}

#[test]
fn p7_the_switch_is_believed_once_it_stays() {
    let mut check = RunOutCheck::new(RunOutParams { debounce_s: 0.3 });
    for (stamp_s, present, tripped) in [
        (100.0, Some(false), false),
        (100.2, Some(false), false),
        (100.25, Some(true), false),
        (100.3, Some(false), false),
        (100.59, Some(false), false),
        (100.61, Some(false), true),
        (100.7, None, false),
        (102.0, None, false),
    ] {
        check.on_switch(Seconds(stamp_s), present);
        assert_eq!(check.tripped(Seconds(stamp_s)), tripped, "{stamp_s}");
    }
}

#[test]
fn s7_ages_call_for_more_step_by_step_and_only_where_a_step_is_given() {
    let full = StaleParams { degraded_s: 0.3, pause_s: Some(1.5), safe_off_s: Some(3.0) };
    let mut check = StaleCheck::new(full);
    assert!(check.reaction(Seconds(1e6)).is_none() && !check.is_seen());
    check.restart(Seconds(5.0));
    assert!(!check.is_seen(), "what was never heard has no age");
    check.expect(Seconds(10.0));
    check.expect(Seconds(11.0));
    for (age_s, reaction) in [
        (0.29, None),
        (0.31, Some(Reaction::Degrade)),
        (1.49, Some(Reaction::Degrade)),
        (1.51, Some(Reaction::Pause)),
        (2.99, Some(Reaction::Pause)),
        (3.01, Some(Reaction::SafeOff)),
    ] {
        assert_eq!(check.reaction(Seconds(10.0 + age_s)), reaction, "{age_s}");
    }
    check.forgive(Seconds(12.1), Seconds(2.0));
    assert_eq!(check.reaction(Seconds(12.31)), Some(Reaction::Degrade));
    // Heard since the clock went on or back: as old as it is, neither ahead of the clock nor an hour behind.
    for gap_s in [3600.0, -3600.0] {
        check.forgive(Seconds(12.0), Seconds(gap_s));
        assert_eq!(check.reaction(Seconds(12.31)), Some(Reaction::Degrade), "{gap_s}");
    }
    assert_eq!(check.reaction(Seconds(12.29)), None);
    check.restart(Seconds(20.0));
    assert_eq!(check.reaction(Seconds(20.2)), None);
    let mut mild = StaleCheck::new(StaleParams { degraded_s: 0.5, pause_s: None, safe_off_s: None });
    mild.note(Seconds(0.0));
    assert_eq!(mild.reaction(Seconds(1e6)), Some(Reaction::Degrade));
}

#[test]
fn names_of_the_judges_classes() {
    for (name, defect) in [
        ("ok", None),
        ("under", Some(Defect::Under)),
        ("over", Some(Defect::Over)),
        ("spaghetti", Some(Defect::Spaghetti)),
        ("shift", Some(Defect::Shift)),
        ("stringing", Some(Defect::Stringing)),
        ("blobs", Some(Defect::Blobs)),
        ("warping", Some(Defect::Other)),
    ] {
        assert_eq!(Defect::from_name(name), defect);
    }
}
