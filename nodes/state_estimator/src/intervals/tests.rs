use super::*;
use crate::params::RawTrust;

const ENCODER: RawEncoder = RawEncoder {
    quantum_m: 1e-5,
    relative: 0.004,
    skew_s: 0.002,
    interval_min_s: 0.035,
    interval_max_s: 0.2,
    speed_min_rel: 0.3,
    strokes_s: 0.15,
    step_std: 0.06,
    stretch_least: 4,
    stretch_most: 20,
    stretch_threshold: 3.5,
    trust: RawTrust {
        age_limit_s: 0.3,
        gate: 25.0,
        gate_again: 25.0,
        step_fade: 0.0,
        step_samples: 4,
        step_threshold: 3.9,
    },
};
/// A slow road's feed: 3.4 counts in 50 ms.
const FEED_M_S: f64 = 0.68e-3;
const NONE: Slip = Slip { mean: 0.0, variance: 1e-4 };

/// Counts of filament that slips as `slip` says of a time: 20 intervals a second.
fn intervals(slip: impl Fn(f64) -> f64) -> impl Iterator<Item = Interval> {
    let mut passed_m = 0.0;
    (0..400).map(move |step| {
        let from_s = 0.05 * f64::from(step);
        let counted = |passed_m: f64| (passed_m / ENCODER.quantum_m).floor() * ENCODER.quantum_m;
        let before_m = counted(passed_m);
        passed_m += 0.05 * FEED_M_S * (1.0 - slip(from_s));
        Interval {
            from_s,
            to_s: 0.05 * f64::from(step + 1),
            passed_m: counted(passed_m) - before_m,
            forth_m: 0.05 * FEED_M_S,
            back_m: 0.0,
            off_m: (0.0, 0.0),
            speeds_m_s: (FEED_M_S, FEED_M_S),
        }
    })
}

/// When the first step is told and which mean speed, where the slip is believed to be as before.
fn told(slip: impl Fn(f64) -> f64) -> Option<(f64, Observation)> {
    let mut seen = Intervals::new();
    intervals(slip).find_map(|interval| {
        seen.push(interval, NONE);
        seen.step(&ENCODER).map(|observation| (interval.to_s, observation))
    })
}

/// 9 % of 0.68 mm/s are a count every 0.16 s: after 0.4 s they stand out of one count's error, where the speeds of four
/// intervals, each known to 12 %, tell nothing. What is told is the slip since then.
#[test]
fn a_step_in_a_slow_road_is_told_by_the_way_of_many_intervals() {
    for size in [0.09, -0.09] {
        let (at_s, observation) = told(|at_s| if at_s < 10.0 { 0.0 } else { size }).unwrap();
        assert!((10.2..10.55).contains(&at_s), "{at_s}");
        let slip = 1.0 - observation.measurement(25.0).value.x / FEED_M_S;
        assert!((slip - size).abs() < 0.03, "{slip}");
    }
    let (at_s, _) = told(|at_s| if at_s < 10.0 { 0.0 } else { 0.9 }).unwrap();
    assert!(at_s <= 10.2 + 1e-9, "four intervals at least: {at_s}");
}

/// Counts that beat against the intervals, at slips near the believed one.
#[test]
fn what_is_believed_of_the_slip_steps_nowhere() {
    for slip in [0.0, 0.003, 0.007, 0.013, -0.01] {
        assert_eq!(told(|_| slip), None, "{slip}");
    }
}

/// After a step only what comes behind it counts.
#[test]
fn what_told_of_a_step_is_forgotten() {
    let mut seen = Intervals::new();
    let mut steps = Vec::new();
    for interval in intervals(|at_s| if at_s < 10.0 { 0.0 } else { 0.09 }) {
        let believed = Slip { mean: if steps.is_empty() { 0.0 } else { 0.09 }, ..NONE };
        seen.push(interval, believed);
        steps.extend(seen.step(&ENCODER).map(|_| interval.to_s));
    }
    assert_eq!(steps.len(), 1, "{steps:?}");
}

/// Two intervals that touch share a count: their way is known as one's is. A gap between them adds two errors of a count.
#[test]
fn a_count_that_two_intervals_share_is_no_error_of_their_way() {
    let ends: Vec<Interval> = intervals(|_| 0.0).take(3).collect();
    let near = Stretch::of(ends[1]).behind(&ends[0]);
    let far = Stretch::of(ends[2]).behind(&ends[0]);
    let quantum_m = ENCODER.quantum_m / 6.0_f64.sqrt();
    let of_gauge_m = ENCODER.relative * 2.0 * ends[0].forth_m;
    assert!((near.deviation_m(&ENCODER) - quantum_m.hypot(of_gauge_m)).abs() < 1e-12);
    assert!((far.deviation_m(&ENCODER) - (quantum_m * 2.0_f64.sqrt()).hypot(of_gauge_m)).abs() < 1e-12);
    assert!((near.span_s - 0.1).abs() < 1e-12 && (far.span_s - 0.1).abs() < 1e-12);
    // so is the motor's position
    let unsure = |index: usize| Interval { off_m: (1e-6, 2e-6), ..ends[index] };
    assert_eq!(Stretch::of(unsure(1)).behind(&unsure(0)).whole.off_m, (1e-6, 2e-6));
    let (from_m, to_m) = Stretch::of(unsure(2)).behind(&unsure(0)).whole.off_m;
    assert!((from_m - 4e-6).abs() < 1e-15 && (to_m - 2e-6).abs() < 1e-15);
}

/// A stroke back is drawn back whole: only what goes forth slips.
#[test]
fn strokes_back_do_not_slip() {
    let stroke =
        Interval { passed_m: 0.7e-4, forth_m: 1e-4, back_m: 2e-5, ..intervals(|_| 0.0).next().unwrap() };
    let slip = |mean: f64| Slip { mean, variance: 0.0 };
    assert!(Stretch::of(stroke).misfit(&ENCODER, slip(0.1)) < 1e-9);
    assert!(Stretch::of(stroke).misfit(&ENCODER, slip(0.3)) > 4.0);
}

/// 9 % that was learned while nothing of the encoder was used steps nowhere: what was believed before is of long ago.
#[test]
fn a_belief_of_long_ago_judges_nothing() {
    for (gap_s, steps) in [(0.0, true), (100.0, false)] {
        let mut seen = Intervals::new();
        let mut stepped = false;
        for (index, interval) in intervals(|at_s| if at_s < 0.5 { 0.0 } else { 0.09 }).take(30).enumerate() {
            let (later_s, mean) = if index < 10 { (0.0, 0.0) } else { (gap_s, 0.09) };
            let (from_s, to_s) = (interval.from_s + later_s, interval.to_s + later_s);
            seen.push(Interval { from_s, to_s, ..interval }, Slip { mean, variance: 1e-6 });
            stepped |= seen.step(&ENCODER).is_some();
        }
        assert_eq!(stepped, steps, "{gap_s} s");
    }
}
