use super::*;

fn drive(duty: f64, motor_position_m: f64) -> Drive {
    Drive { duty, fan: 0.0, motor_position_m, slip: 0.0 }
}

#[test]
fn means_follow_the_stamps_whenever_the_states_came() {
    let mut history = DriveHistory::default();
    for (stamp_s, duty) in [(1.0, 1.0), (1.02, 0.0), (1.06, 1.0)] {
        history.push(Seconds(stamp_s), drive(duty, 0.1 * stamp_s));
    }
    // On for 20 ms, off for 40 ms, on for the last 40 ms: 60 %.
    let means = history.means(Seconds(1.0), Seconds(1.1)).unwrap();
    assert!((means.duty - 0.6).abs() < 1e-12, "{means:?}");
    // The motor went 6 mm in the 60 ms that the states cover.
    assert!((means.feed_m_s - 0.006 / 0.1).abs() < 1e-9, "{means:?}");
}

#[test]
fn an_overtaken_state_is_left_out_and_time_set_back_begins_anew() {
    let mut history = DriveHistory::default();
    history.push(Seconds(100.0), drive(0.1, 0.0));
    for (stamp_s, newest_s) in [(99.5, 100.0), (100.0, 100.0), (99.0, 100.0), (98.9, 98.9), (99.0, 99.0)] {
        history.push(Seconds(stamp_s), drive(0.2, 0.0));
        let newest = history.newest().map(|(stamp, _)| stamp);
        assert_eq!(newest, Some(Seconds(newest_s)), "{stamp_s}");
    }
    assert!(
        history.means(Seconds(98.9), Seconds(99.0)).is_some_and(|means| (means.duty - 0.2).abs() < 1e-12)
    );
}

/// Fed until now, of states 20 ms apart at these positions.
fn fed_m(positions_m: &[f64]) -> f64 {
    let mut history = DriveHistory::default();
    for (number, position_m) in (0_u32..).zip(positions_m) {
        history.push(Seconds(0.02 * f64::from(number)), drive(0.0, *position_m));
    }
    history.fed_m(Seconds(1e3)).unwrap()
}

/// Pressure advance draws back at each corner what it then pushes: that warms nothing twice. A filament that was drawn out
/// whole and comes again is cold but for the last 15 mm.
#[test]
fn what_was_drawn_back_is_hot_already() {
    assert!((fed_m(&[0.0, 3e-3, 1e-3, 3.5e-3, 1.5e-3, 4e-3]) - 4e-3).abs() < 1e-12);
    // 80 mm at 10 mm/s.
    let again = (1..=400_u32).map(|step| -0.07 + 2e-4 * f64::from(step));
    let positions_m: Vec<f64> = [0.0, 0.01, -0.07].into_iter().chain(again).collect();
    assert!((fed_m(&positions_m) - (0.01 + 0.08 - STROKE_MAX_M)).abs() < 1e-9);
}

/// 400 mm out of a Bowden tube, 380 mm in again at 20 mm/s, the rest and as much more at 5 mm/s. What is pushed as fast
/// with nothing drawn out is on its way to the nozzle for a stroke.
#[test]
fn a_filament_that_is_loaded_takes_no_heat_before_it_is_there() {
    let mut history = DriveHistory::default();
    let (mut stamp_s, mut position_m) = (0.0, 0.0);
    let mut moved = |way_m: f64, speed_m_s: f64| {
        for _ in 0..100 {
            stamp_s += way_m.abs() / speed_m_s / 100.0;
            position_m += way_m / 100.0;
            history.push(Seconds(stamp_s), drive(0.5, position_m));
        }
        history.fed_m(Seconds(1e3)).unwrap()
    };
    let first_m = moved(0.015, 0.02);
    assert!(first_m > 0.0145, "{first_m}");
    assert!((moved(-0.4, 0.05) - first_m).abs() < 1e-12);
    assert!((moved(0.38, 0.02) - first_m).abs() < 1e-12);
    let more_m = moved(0.04, 5e-3) - first_m;
    assert!((0.024..0.0401).contains(&more_m), "{more_m}");
}

/// Drawn out by a stroke to the digit and in again at 50 mm/s, as a wipe does: a stroke yet, and warm.
#[test]
fn the_longest_stroke_is_a_stroke() {
    assert!(fed_m(&[0.0, -STROKE_MAX_M, -STROKE_MAX_M, 0.0]).abs() < 1e-12);
    // and what is laid after it counts
    assert!((fed_m(&[0.0, -STROKE_MAX_M, 0.0, 1e-4, 2e-4]) - 2e-4).abs() < 1e-12);
    // pushed by as much at once with nothing drawn out: all of it counts
    assert!((fed_m(&[0.0, 0.0, STROKE_MAX_M]) - STROKE_MAX_M).abs() < 1e-12);
}

/// Of an empty tube that nobody saw emptied, 400 mm at 25 mm/s: a stroke is counted, and then half of what a nozzle melts.
/// A rest begins anew.
#[test]
fn what_is_pushed_faster_than_it_melts_takes_half_of_that_heat() {
    let mut history = DriveHistory::default();
    let (mut stamp_s, mut position_m) = (0.0, 0.0);
    history.push(Seconds(stamp_s), drive(0.5, position_m));
    let mut rush = |way_m: f64, speed_m_s: f64| {
        for _ in 0..200 {
            stamp_s += way_m / speed_m_s / 200.0;
            position_m += way_m / 200.0;
            history.push(Seconds(stamp_s), drive(0.5, position_m));
        }
        history.fed_m(Seconds(1e3)).unwrap()
    };
    let expected_m = STROKE_MAX_M + LOAD_SHARE * LOAD_M_S * (0.4 - STROKE_MAX_M) / 0.025;
    let loaded_m = rush(0.4, 0.025);
    assert!((loaded_m - expected_m).abs() < 0.003, "{loaded_m} of {expected_m}");
    let slowly_m = rush(0.01, 0.005) - loaded_m;
    let again_m = rush(0.014, 0.025) - loaded_m - slowly_m;
    assert!((slowly_m - 0.01).abs() < 1e-9 && (again_m - 0.014).abs() < 1e-9, "{slowly_m} {again_m}");
}

/// A balance that was told of 1 km in 0.1 s would be lost for ever.
#[test]
fn what_the_drive_gear_loses_takes_no_heat() {
    let mut history = DriveHistory::default();
    for (stamp_s, motor_m, slip) in [(1.0, 0.0, 0.0), (2.0, 0.004, 0.3), (3.0, 0.008, 1.0)] {
        history.push(Seconds(stamp_s), Drive { slip, ..drive(0.5, motor_m) });
    }
    let fed = |from_s, to_s| history.means(Seconds(from_s), Seconds(to_s)).unwrap().feed_m_s;
    assert!((fed(1.0, 2.0) - 0.0028).abs() < 1e-12 && fed(2.0, 3.0).abs() < 1e-12);
}

#[test]
fn a_position_that_jumps_feeds_no_faster_than_an_extruder_can() {
    let loaded_m_s = LOAD_SHARE * LOAD_M_S;
    for (jump_m, feed_m_s) in [(0.014, FEED_MAX_M_S), (1e3, loaded_m_s), (-1e3, 0.0)] {
        let mut history = DriveHistory::default();
        history.push(Seconds(1.0), drive(0.0, 0.0));
        history.push(Seconds(1.1), drive(0.0, jump_m));
        let means = history.means(Seconds(1.0), Seconds(1.1)).unwrap();
        assert!((means.feed_m_s - feed_m_s).abs() < 1e-12, "{means:?}");
    }
}

#[test]
fn a_state_twice_or_late_changes_nothing_and_a_jump_back_starts_anew() {
    let mut history = DriveHistory::default();
    history.push(Seconds(5.0), drive(1.0, 0.0));
    history.push(Seconds(5.0), drive(0.0, 0.0));
    history.push(Seconds(4.9), drive(0.0, 0.0));
    assert_eq!(history.newest(), Some((Seconds(5.0), drive(1.0, 0.0))));
    history.push(Seconds(1.0), drive(0.5, 0.0));
    assert_eq!(history.entries().count(), 1);
}

#[test]
fn the_ring_keeps_the_newest() {
    let mut history = DriveHistory::default();
    for number in 0..1000_u32 {
        history.push(Seconds(f64::from(number)), drive(0.0, 0.01 * f64::from(number)));
    }
    assert_eq!(history.entries().count(), KEPT);
    assert!((history.fed_m(Seconds(998.5)).unwrap() - 9.985).abs() < 1e-9);
}
