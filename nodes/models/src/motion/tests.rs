//! Laws of planning, over random jobs.

use super::tests_support::shipped_params;
use super::*;
use crate::units::Seconds;
use proptest::prelude::*;

/// Rounding of a few sums and roots in double precision, relative.
const ROUNDING: f64 = 1e-9;

fn waypoint(start_m: [f64; 3], end_m: [f64; 3], filament_m: f64, feed_m_s: f64) -> Waypoint {
    Waypoint {
        line: 1,
        layer: None,
        start_m,
        end_m,
        filament_m,
        feed_m_s,
        kind: MoveKind::Deposit,
        role: Role::Unknown,
        arc: false,
        target_width_m: None,
        stated_width_m: None,
        layer_height_m: None,
    }
}

fn drain(planner: &mut Planner, segments: &mut Vec<Segment>) {
    while let Some(step) = planner.pop() {
        if let Step::Move(segment) = step {
            segments.push(segment);
        }
    }
}

fn plan(limits: Limits, lookahead_moves: usize, moves: &[Waypoint]) -> Vec<Segment> {
    let mut planner = Planner::new(limits, lookahead_moves);
    let mut segments = Vec::new();
    for waypoint in moves {
        planner.push_move(*waypoint);
        drain(&mut planner, &mut segments);
    }
    planner.finish();
    drain(&mut planner, &mut segments);
    segments
}

fn direction(segment: &Segment) -> [f64; 4] {
    let path_m = segment.path_m();
    let share = |axis: usize| (segment.end_m[axis] - segment.start_m[axis]) / path_m;
    [share(0), share(1), share(2), segment.filament_per_path()]
}

/// A trapezoid by hand: 100 mm at 50 mm/s under 500 mm/s2 from rest to rest:
/// ramps of 0.1 s and 2.5 mm, a plateau of 95 mm in 1.9 s.
#[test]
fn a_long_move_has_ramps_and_a_plateau() {
    let profile = Trapezoid::new(0.1, (0.0, 0.0), 0.05, 0.5);
    assert!((profile.duration().0 - 2.1).abs() < 1e-12);
    let state = profile.at(Seconds(0.1));
    assert!((state.distance_m - 2.5e-3).abs() < 1e-15 && (state.speed_m_s - 0.05).abs() < 1e-15);
    let state = profile.at(Seconds(2.05));
    assert!((state.speed_m_s - 0.025).abs() < 1e-12 && (state.acceleration_m_s2 + 0.5).abs() < 1e-12);
    assert!((profile.at(Seconds(9.0)).distance_m - 0.1).abs() < 1e-12);
}

/// 10 mm under the same limits with a wish of 200 mm/s: the peak is sqrt(0.5 * 0.01) = 70.7 mm/s.
#[test]
fn a_short_move_turns_at_its_peak() {
    let profile = Trapezoid::new(0.01, (0.0, 0.0), 0.2, 0.5);
    assert!((profile.cruise_m_s - 0.005_f64.sqrt()).abs() < 1e-12);
    assert!(profile.cruise_s.abs() < 1e-12);
}

/// Model book 2.5: a 1 m/s2, d 0.08 mm.
#[test]
fn junction_speeds_are_those_of_the_model_book() {
    for (angle_deg, expected_mm_s) in [(90.0_f64, 13.9), (135.0, 31.2), (30.0, 5.29)] {
        let speed_m_s = junction_speed_m_s(angle_deg.to_radians(), 1.0, 8e-5);
        assert!((speed_m_s * 1e3 - expected_mm_s).abs() < 0.05, "{angle_deg}: {speed_m_s}");
    }
}

/// Straight on at one feed the machine never slows: 1000 moves of 0.1 mm take what one move of 100 mm takes.
#[test]
fn a_straight_line_in_pieces_takes_as_long_as_in_one() {
    let point = |index: u32| [f64::from(index) * 1e-4, 0.0, 0.0];
    let pieces: Vec<Waypoint> =
        (0..1000).map(|index| waypoint(point(index), point(index + 1), 0.0, 0.05)).collect();
    let whole = [waypoint(point(0), point(1000), 0.0, 0.05)];
    let params = shipped_params();
    let time_s = |moves: &[Waypoint]| -> f64 {
        plan(params.limits, params.lookahead_moves, moves).iter().map(|s| s.profile.duration().0).sum()
    };
    // the horizon of 64 moves is 6.4 mm, a stop from 50 mm/s needs 2.5 mm
    assert!((time_s(&pieces) - time_s(&whole)).abs() < 1e-9);
}

/// Classic jerk at a right angle: each axis starts or stops alone, so the corner is taken at the jerk itself.
#[test]
fn a_right_angle_is_taken_at_the_jerk_of_its_axes() {
    let limits = shipped_params().limits;
    let moves = [
        waypoint([0.0; 3], [0.05, 0.0, 0.0], 0.0, 0.05),
        waypoint([0.05, 0.0, 0.0], [0.05, 0.05, 0.0], 0.0, 0.05),
    ];
    let segments = plan(limits, 8, &moves);
    assert!((segments[1].profile.entry_m_s - limits.jerk_m_s[axis::X]).abs() < 1e-12);
}

/// A circle in chords under junction deviation stays below its centripetal speed v^2 = a r.
#[test]
fn chords_of_a_circle_keep_the_centripetal_limit() {
    let mut limits = shipped_params().limits;
    limits.cornering = Cornering::JunctionDeviation;
    limits.acceleration_m_s2 = [10.0; 4];
    let radius_m = 0.005;
    let point = |index: u32| {
        let angle = f64::from(index) * 0.05;
        [radius_m * angle.cos(), radius_m * angle.sin(), 0.0]
    };
    let moves: Vec<Waypoint> =
        (0..200).map(|index| waypoint(point(index), point(index + 1), 0.0, 0.2)).collect();
    let centripetal_m_s = (limits.travel_m_s2 * radius_m).sqrt();
    for segment in plan(limits, 32, &moves) {
        assert!(segment.profile.entry_m_s <= centripetal_m_s * (1.0 + ROUNDING));
    }
}

/// Moves that come in one burst, as the chords of an arc do, are planned as those that come one by one.
#[test]
fn a_burst_is_planned_within_the_same_horizon() {
    let params = shipped_params();
    let point = |index: u32| [f64::from(index) * 1e-4, f64::from(index % 7) * 1e-5, 0.0];
    let moves: Vec<Waypoint> =
        (0..2000).map(|index| waypoint(point(index), point(index + 1), 1e-6, 0.05)).collect();
    let mut planner = Planner::new(params.limits, params.lookahead_moves);
    let mut burst = Vec::new();
    moves.iter().for_each(|waypoint| planner.push_move(*waypoint));
    planner.finish();
    drain(&mut planner, &mut burst);
    assert_eq!(burst, plan(params.limits, params.lookahead_moves, &moves));
}

/// A firmware that knows 4 moves of 0.1 mm beyond the current one must be able to stop within them: no junction is
/// faster than `v^2 = v_rest^2 + 2 a 4 s`; with 64 of them the wished 50 mm/s are reached.
#[test]
fn a_starved_buffer_can_always_stop() {
    let limits = shipped_params().limits;
    let point = |index: u32| [f64::from(index) * 1e-4, 0.0, 0.0];
    let moves: Vec<Waypoint> =
        (0..600).map(|index| waypoint(point(index), point(index + 1), 4e-6, 0.05)).collect();
    let fastest = |moves_ahead: usize| {
        let mut planner = Planner::new(limits, moves_ahead).starved();
        let mut segments = Vec::new();
        for waypoint in &moves {
            planner.push_move(*waypoint);
            drain(&mut planner, &mut segments);
        }
        planner.finish();
        drain(&mut planner, &mut segments);
        assert_eq!(segments.len(), moves.len());
        let rest_m_s = segments[0].profile.entry_m_s;
        let most = segments.iter().map(|s| s.profile.cruise_m_s).fold(0.0, f64::max);
        (rest_m_s, most, segments[0].profile.acceleration_m_s2)
    };
    let (rest_m_s, most_m_s, acceleration_m_s2) = fastest(4);
    // The peak lies within the current move: half of its way more.
    let bound = (rest_m_s * rest_m_s + 2.0 * acceleration_m_s2 * 5e-4).sqrt();
    assert!(most_m_s <= bound * (1.0 + ROUNDING) && most_m_s > 0.8 * bound, "{most_m_s} {bound}");
    assert!((fastest(64).1 - 0.05).abs() < 1e-9);
}

fn jobs() -> impl Strategy<Value = Vec<Waypoint>> {
    let coordinate = || prop_oneof![Just(0.0), -0.05..0.05_f64, -1e-5..1e-5_f64];
    let filament = prop_oneof![Just(0.0), -1e-3..1e-3_f64, 0.0..0.02_f64];
    let one = (coordinate(), coordinate(), prop_oneof![Just(0.0), coordinate()], filament, 1e-4..0.6_f64);
    proptest::collection::vec(one, 1..120).prop_map(|steps| {
        let mut at = [0.0; 3];
        let mut moves = Vec::new();
        for (dx, dy, dz, filament_m, feed_m_s) in steps {
            let end = [at[0] + dx, at[1] + dy, at[2] + dz];
            moves.push(waypoint(at, end, filament_m, feed_m_s));
            at = end;
        }
        moves
    })
}

proptest! {
    /// Way, filament and order are those of the moves; speeds and accelerations are within every limit; the speed
    /// at the end of a move is the speed at the start of the next one.
    #[test]
    fn a_plan_keeps_moves_limits_and_continuity(moves in jobs(), lookahead in 2_usize..20, deviation: bool) {
        let mut limits = shipped_params().limits;
        if deviation {
            limits.cornering = Cornering::JunctionDeviation;
        }
        let segments = plan(limits, lookahead, &moves);
        let moved = |m: &Waypoint| m.start_m.iter().zip(m.end_m).any(|(start, end)| (end - start).abs() > 0.0);
        let kept = moves.iter().filter(|m| moved(m) || m.filament_m.abs() > 0.0);
        prop_assert!(segments.iter().map(|s| (s.start_m, s.end_m, s.filament_m)).eq(
            kept.map(|m| (m.start_m, m.end_m, m.filament_m))
        ));
        for segment in &segments {
            let profile = &segment.profile;
            // the plateau is the difference of way and ramps: rounding grows with the ramps
            prop_assert!((profile.path_m() - segment.path_m()).abs() <= ROUNDING * segment.path_m() + 1e-15);
            for (axis, share) in direction(segment).into_iter().enumerate() {
                let share = share.abs();
                prop_assert!(profile.cruise_m_s * share <= limits.feedrate_m_s[axis] * (1.0 + ROUNDING));
                prop_assert!(profile.acceleration_m_s2 * share <= limits.acceleration_m_s2[axis] * (1.0 + ROUNDING));
            }
            prop_assert!(profile.accel_s >= 0.0 && profile.cruise_s >= 0.0 && profile.decel_s >= 0.0);
        }
        for pair in segments.windows(2) {
            let speed_m_s = pair[0].profile.exit_m_s;
            prop_assert_eq!(speed_m_s.to_bits(), pair[1].profile.entry_m_s.to_bits());
            let (before, after) = (direction(&pair[0]), direction(&pair[1]));
            if deviation && pair[0].length_m > 0.0 && pair[1].length_m > 0.0 {
                let straight: f64 = (0..3).map(|axis| before[axis] * after[axis]).sum();
                let acceleration_m_s2 = pair[0].profile.acceleration_m_s2.min(pair[1].profile.acceleration_m_s2);
                let interior_rad = (-straight.clamp(-1.0, 1.0)).acos();
                let corner_m_s =
                    junction_speed_m_s(interior_rad, acceleration_m_s2, limits.junction_deviation_m);
                prop_assert!(speed_m_s <= corner_m_s * (1.0 + ROUNDING));
            }
        }
    }

    /// No axis jumps by more than its jerk: while it keeps its direction the difference, where it turns each side,
    /// from rest and to rest the speed itself.
    #[test]
    fn corners_keep_the_jerk_of_each_axis(moves in jobs(), lookahead in 2_usize..20) {
        let limits = shipped_params().limits;
        let segments = plan(limits, lookahead, &moves);
        let rest = [0.0; 4];
        let mut before = rest;
        for segment in &segments {
            let entry = direction(segment).map(|share| share * segment.profile.entry_m_s);
            for axis in 0..4 {
                let jump = if before[axis] * entry[axis] > 0.0 {
                    (before[axis] - entry[axis]).abs()
                } else {
                    before[axis].abs().max(entry[axis].abs())
                };
                prop_assert!(jump <= limits.jerk_m_s[axis] * (1.0 + ROUNDING), "axis {} jumps {}", axis, jump);
            }
            before = direction(segment).map(|share| share * segment.profile.exit_m_s);
        }
        for (speed, jerk) in before.iter().zip(limits.jerk_m_s) {
            prop_assert!(speed.abs() <= jerk * (1.0 + ROUNDING));
        }
    }
}
