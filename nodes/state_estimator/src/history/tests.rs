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

/// From 50 to 30 mm/s within one report: 42 mm/s where it is looked at, and a spread of two fifths.
#[test]
fn a_road_that_is_not_steady_is_known_between_close_reports_alone() {
    let ring = |period_s: f64| {
        let mut ring = Ring::new(8);
        for step in 0..8 {
            let mut sample = sample(f64::from(step) * period_s, 0.0);
            sample.path_speed_m_s = if step < 5 { 0.05 } else { 0.03 };
            sample.depositing = step < 7;
            ring.push(sample);
        }
        ring
    };
    let ((speed_m_s, height_m), spread) = ring(0.02).unsteady_road((0.03, 0.088), 0.75).unwrap();
    assert!((speed_m_s - 0.042).abs() < 1e-12 && (spread - 0.4).abs() < 1e-12, "{speed_m_s} {spread}");
    assert!((height_m - 2e-4).abs() < 1e-15);
    assert_eq!(ring(0.02).unsteady_road((0.03, 0.088), 0.35), None, "too large a spread");
    assert_eq!(ring(0.02).unsteady_road((0.03, 0.13), 0.75), None, "the road ends");
    assert_eq!(ring(0.25).unsteady_road((0.375, 1.1), 0.75), None, "a slow host's reports");
}

/// Reports of a tool on a path at 50 mm/s, which is given by the place at a way along it.
fn along(period_s: f64, path: impl Fn(f64) -> [f64; 2]) -> Ring<Sample> {
    let mut ring = Ring::new(8);
    for step in 0..8 {
        let stamp_s = f64::from(step) * period_s;
        ring.push(Sample { tool_m: path(0.05 * stamp_s), ..sample(stamp_s, 0.0) });
    }
    ring
}

/// A square corner 45 mm along the way, turned the other way and about: 0.15 s after the report at 0.75 s.
#[test]
fn a_corner_between_reports_that_are_far_apart_is_seen_by_the_way() {
    let steady = Some((0.05, 2e-4));
    for turned in [|[x, y]: [f64; 2]| [x, y], |[x, y]: [f64; 2]| [y, x], |[x, y]: [f64; 2]| [-x, -y]] {
        let square = |way_m: f64| turned([way_m.min(0.045), (way_m - 0.045).max(0.0)]);
        let ring = along(0.25, square);
        let windows = [(0.3, 0.5), (0.6, 0.8), (0.8, 0.95), (0.95, 1.1), (1.05, 1.25)];
        assert_eq!(windows.map(|window| ring.steady_road(window, 0.05)), [steady, None, None, None, steady]);
        // 60 ms hide nothing that matters, 80 ms do; at 50 Hz the speeds themselves tell
        assert_eq!(along(0.06, |way_m| square(way_m + 0.0375)).steady_road((0.13, 0.17), 0.05), steady);
        assert_eq!(along(0.08, |way_m| square(way_m + 0.0375)).steady_road((0.13, 0.17), 0.05), None);
        assert_eq!(along(0.02, |way_m| square(way_m + 0.041)).steady_road((0.07, 0.09), 0.05), steady);
    }
}

/// 4 and 6 % of 12.5 mm, short and long.
#[test]
fn a_way_may_differ_from_what_the_speeds_tell_by_the_spread() {
    let told = |off_m: f64| {
        along(0.25, |way_m| [way_m + if way_m < 0.049 { 0.0 } else { off_m }, 0.0])
            .steady_road((0.8, 0.95), 0.05)
    };
    let steady = Some((0.05, 2e-4));
    assert_eq!([-0.5e-3, 0.5e-3].map(told), [steady, steady]);
    assert_eq!([-0.75e-3, 0.75e-3].map(told), [None, None]);
}

/// Rings of 8 to 40 mm radius: of 12 mm a chord is short by 4.5 % of 12.5 mm, by 17 % of 25 mm. The corner of a
/// square of 20 mm is none.
#[test]
fn a_ring_is_a_steady_road_between_reports_that_are_far_apart() {
    let ring = |period_s: f64, radius_m: f64| {
        along(period_s, |way_m| {
            let (sin, cos) = (way_m / radius_m).sin_cos();
            [radius_m * cos, radius_m * sin]
        })
    };
    for radius_m in [0.008, 0.012, 0.02, 0.04] {
        for (period_s, window) in [(0.25, (0.8, 0.95)), (0.25, (1.55, 1.75)), (0.5, (1.6, 1.9))] {
            let told = ring(period_s, radius_m).steady_road(window, 0.05);
            // 25 mm are 3.1 rad of the smallest: not told from a corner
            assert_eq!(told.is_some(), radius_m > 0.01 || period_s < 0.5, "{radius_m} {period_s}");
        }
    }
    let square = |way_m: f64| {
        let along_m = way_m.rem_euclid(0.02);
        match way_m.rem_euclid(0.08) {
            side if side < 0.02 => [along_m, 0.0],
            side if side < 0.04 => [0.02, along_m],
            side if side < 0.06 => [0.02 - along_m, 0.02],
            _ => [0.0, 0.02 - along_m],
        }
    };
    assert_eq!(along(0.25, square).steady_road((0.3, 0.45), 0.05), None);
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
