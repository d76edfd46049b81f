//! Rings of what was reported.

use super::*;

fn sample(stamp_s: f64, motor_m: f64) -> Sample {
    Sample {
        stamp_s,
        motor_m,
        wanted_m: motor_m,
        slip: 0.0,
        path_speed_m_s: 0.05,
        tool_m: [0.05 * stamp_s, 0.0],
        height_m: Some(2e-4),
        depositing: true,
    }
}

#[test]
fn position_is_exact_at_constant_speed_and_bounded_at_a_change() {
    let mut ring = Ring::new(8);
    for (stamp, motor) in [(0.0, 0.0), (0.02, 0.04), (0.04, 0.08), (0.06, 0.2)] {
        ring.push(sample(stamp, motor));
    }
    let steady = ring.motor_at(0.01).unwrap();
    assert!((steady.motor_m - 0.02).abs() < 1e-12 && steady.error_m < 1e-12);
    // next interval is 4 m/s faster, 5 ms from the nearer report
    let near_change = ring.motor_at(0.035).unwrap();
    assert!((near_change.motor_m - 0.07).abs() < 1e-12);
    assert!((near_change.error_m - 4.0 * 0.005).abs() < 1e-12);
    assert!(ring.motor_at(0.07).is_none() && ring.motor_at(-0.01).is_none());
}

/// 1 mm forth, of which 10 % more for the slip, and 0.4 mm back: the motor tells of 0.7 mm.
#[test]
fn what_is_made_up_for_tells_of_strokes_back() {
    let (forth_m, back_m) = (1e-3 / 0.9, 0.4e-3);
    let since = sample(0.0, 0.0).position();
    let made_up = Sample { wanted_m: 1e-3 - back_m, slip: 0.1, ..sample(0.02, forth_m - back_m) };
    assert!((made_up.back_m(&since) - back_m).abs() < 1e-12);
    let back_alone = Sample { wanted_m: -back_m, slip: 0.1, ..sample(0.02, -back_m) };
    assert!((back_alone.back_m(&since) - back_m).abs() < 1e-12);
    // a host that makes up for nothing, or for it elsewhere, tells of none
    for (wanted_m, slip) in [(0.6e-3, 0.0), (0.6e-3, 0.002), (forth_m - back_m, 0.1), (0.8e-3, 0.1)] {
        let silent = Sample { wanted_m, slip, ..sample(0.02, forth_m - back_m) };
        assert!(silent.back_m(&since).abs() < 1e-15, "{wanted_m} {slip}");
    }
}

#[test]
fn a_road_is_steady_only_while_speed_and_height_are() {
    let mut ring = Ring::new(8);
    for step in 0..8 {
        let mut sample = sample(f64::from(step) * 0.02, 0.0);
        sample.path_speed_m_s = if step < 5 { 0.05 } else { 0.03 };
        ring.push(sample);
    }
    assert_eq!(ring.steady_road((0.01, 0.07), 0.05), Some((0.05, 2e-4)));
    assert_eq!(ring.steady_road((0.03, 0.09), 0.05), None);
    assert_eq!(ring.steady_road((0.03, 0.2), 0.05), None);
}

/// Four reports a second at 50 mm/s, one corner behind which the tool is 10 mm short: what is exposed around it is no steady
/// road; at 50 Hz the speeds themselves tell.
#[test]
fn a_corner_between_reports_that_are_far_apart_is_seen_by_the_way() {
    let road = |period_s: f64, short_m: f64| {
        let mut ring = Ring::new(8);
        for step in 0..8 {
            let mut sample = sample(f64::from(step) * period_s, 0.0);
            sample.tool_m[0] -= if step < 4 { 0.0 } else { short_m };
            ring.push(sample);
        }
        ring
    };
    let turned = road(0.25, 0.01);
    let steady = Some((0.05, 2e-4));
    let windows = [(0.3, 0.5), (0.6, 0.8), (0.8, 0.95), (0.95, 1.1), (1.05, 1.25)];
    assert_eq!(windows.map(|window| turned.steady_road(window, 0.05)), [steady, None, None, None, steady]);
    // 4 and 6 % of 12.5 mm
    assert_eq!(road(0.25, 0.5e-3).steady_road((0.8, 0.95), 0.05), steady);
    assert_eq!(road(0.25, 0.75e-3).steady_road((0.8, 0.95), 0.05), None);
    assert_eq!(road(0.25, -0.75e-3).steady_road((0.8, 0.95), 0.05), None);
    assert_eq!(road(0.02, 0.5e-3).steady_road((0.05, 0.09), 0.05), steady);
}

#[test]
fn the_oldest_makes_room() {
    let mut ring = Ring::new(2);
    for stamp in 0..3 {
        ring.push((f64::from(stamp), 10.0 * f64::from(stamp)));
    }
    assert_eq!(ring.value_at(0.5), None);
    assert_eq!(ring.value_at(1.5), Some(15.0));
    assert_eq!(ring.newest_until(1.9), Some((1.0, 10.0)));
}
