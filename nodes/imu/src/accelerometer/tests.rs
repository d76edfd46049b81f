use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;
use crate::params::Params;
use crate::window::GRAVITY_M_S2;

#[derive(serde::Deserialize)]
struct File {
    #[serde(rename = "ros__parameters")]
    parameters: Params,
}

fn unit() -> Accelerometer {
    let text = include_str!("../../../../config/imu.param.yaml");
    let file: BTreeMap<String, File> = serde_saphyr::from_str(text).unwrap();
    Accelerometer::new(file.into_values().next().unwrap().parameters.unit)
}

const PERIOD_S: f64 = 1e-3;
const BATCH: u32 = 50;
const REST: [f64; 3] = [0.0, 0.0, GRAVITY_M_S2];

/// Batch `index` of a stream of 1 kHz in batches of 50.
fn batch(index: u32, sample: [f64; 3]) -> Report {
    Report {
        frame: "imu".into(),
        first: Seconds(10.0 + f64::from(index * BATCH) * PERIOD_S),
        first_sequence: u64::from(index * BATCH),
        period: Seconds(PERIOD_S),
        range_m_s2: 156.9064,
        samples: vec![sample; BATCH as usize],
    }
}

/// When a batch arrives: with its last sample.
fn arrival(report: &Report) -> Seconds {
    report.first + Seconds(PERIOD_S * f64::from(BATCH))
}

fn take(unit: &mut Accelerometer, report: Report) -> Result<Checked, Refusal> {
    let now = arrival(&report);
    unit.on_report(now, report)
}

/// A unit that has proven itself; the next batch is number 21.
fn proven() -> Accelerometer {
    let mut unit = unit();
    for index in 0..=20 {
        let _ = take(&mut unit, batch(index, REST));
    }
    assert_eq!((unit.verdict(), unit.refusals().total()), (Verdict::Sound, 20));
    unit
}

/// S11: a unit is rejected before it is used.
#[test]
fn nothing_passes_before_a_window_has_shown_gravity() {
    let mut unit = unit();
    for index in 0..20 {
        assert_eq!(take(&mut unit, batch(index, REST)), Err(Refusal::Unproven));
    }
    // The 21st batch begins 20 * 50 ms = 1 s after the first.
    assert!(take(&mut unit, batch(20, REST)).is_ok());
}

/// S11: wrong unit, swapped axis and wrong rate are named within a second, with what to do.
#[test]
fn a_wrong_unit_or_axis_is_refused_with_what_to_do() {
    let g = GRAVITY_M_S2;
    for (sample, advice) in [
        ([0.0, 0.0, 1.0], "looks like g: multiply by 9.80665"),
        ([0.0, 0.0, 1e3], "thousandths of g"),
        ([0.0, 0.0, 1e3 * g], "looks like mm/s2: divide by 1000"),
        ([0.0, 0.0, 0.0], "no axis is dead"),
        ([g, 0.0, 0.0], "gravity lies on x, 90 deg from z"),
        ([0.0, 0.0, -g], "gravity lies on -z, 180 deg from z"),
    ] {
        let mut unit = unit();
        for index in 0..=20 {
            let refusal = take(&mut unit, batch(index, sample)).unwrap_err();
            let beyond = sample[2].abs() > 156.9;
            assert_eq!(refusal == Refusal::OutOfRange, beyond);
            assert!(index < 20 || beyond || refusal == Refusal::Untrue);
        }
        assert!(unit.verdict().to_string().contains(advice), "{} is not {advice}", unit.verdict());
    }
}

/// A second of 0.5 m/s forth and back: (v(T) - v(0))/T = 1 m/s2 beside gravity is motion, not a fault.
#[test]
fn the_fastest_motion_leaves_the_verdict_sound() {
    let mut unit = unit();
    for index in 0..=20 {
        // 20 m/s2 for 50 ms is 1 m/s: from -0.5 to +0.5 m/s, once in the window.
        let sample = if index == 7 { [20.0, 0.0, GRAVITY_M_S2] } else { REST };
        let _ = take(&mut unit, batch(index, sample));
    }
    assert_eq!(unit.verdict(), Verdict::Sound);
    // atan(1/9.81) = 5.8 deg; sqrt(1 + 9.81^2) = 9.86
    let figures = unit.figures().unwrap();
    assert!((figures.tilt_deg - 5.82).abs() < 0.01 && (figures.mean_m_s2 - 9.857).abs() < 1e-3);
}

#[test]
fn a_sensor_at_another_pace_is_refused_and_its_rate_is_measured() {
    let mut unit = unit();
    for index in 0..=25 {
        let mut report = batch(index, REST);
        // Batches of 1 ms samples that come every 62.5 ms: 800 Hz.
        report.first = Seconds(10.0 + f64::from(index) * 0.0625);
        let _ = take(&mut unit, report);
    }
    let Verdict::Rate { measured_hz, wanted_hz } = unit.verdict() else { panic!("{}", unit.verdict()) };
    assert!((measured_hz - 800.0).abs() < 1e-6 && (wanted_hz - 1000.0).abs() < 1e-9);
}

#[test]
fn a_unit_that_turns_wrong_is_refused_and_taken_again() {
    let mut unit = proven();
    for index in 21..=42 {
        let _ = take(&mut unit, batch(index, [GRAVITY_M_S2, 0.0, 0.0]));
    }
    assert!(matches!(unit.verdict(), Verdict::Axes { .. }));
    for index in 43..=84 {
        let _ = take(&mut unit, batch(index, REST));
    }
    assert_eq!(unit.verdict(), Verdict::Sound);
}

#[test]
fn each_kind_of_bad_batch_is_refused_and_counted() {
    type Poison = fn(&mut Report);
    let poisons: [(Refusal, Poison); 11] = [
        (Refusal::NotFinite, |report| report.samples[7][1] = f64::NAN),
        (Refusal::NotFinite, |report| report.first = Seconds(f64::INFINITY)),
        (Refusal::NotFinite, |report| report.period = Seconds(f64::NAN)),
        (Refusal::Empty, |report| report.samples.clear()),
        (Refusal::Frame, |report| report.frame = "bed".into()),
        (Refusal::OutOfRange, |report| report.samples[7][1] = 157.0),
        (Refusal::OutOfRange, |report| report.range_m_s2 = 78.4),
        (Refusal::Period, |report| report.period = Seconds(1.2e-3)),
        (Refusal::Order, |report| report.first = report.first - Seconds(0.05)),
        (Refusal::Future, |report| report.first = report.first + Seconds(3600.0)),
        (Refusal::Stale, |report| report.first = Seconds(1.0)),
    ];
    for (refusal, poison) in poisons {
        let mut unit = proven();
        let mut report = batch(21, REST);
        let now = arrival(&report);
        poison(&mut report);
        assert_eq!(unit.on_report(now, report), Err(refusal));
        assert_eq!(unit.refusals().total(), 21);
        // What is refused for itself leaves no trace.
        assert!(take(&mut unit, batch(22, REST)).is_ok(), "after {refusal:?}");
    }
}

#[test]
fn saturated_samples_pass_and_are_counted() {
    let mut unit = proven();
    let mut report = batch(21, REST);
    report.samples[3][0] = -156.9064;
    report.samples[4] = [156.9064, 156.9064, GRAVITY_M_S2];
    assert_eq!(take(&mut unit, report).unwrap().saturated, 2);
    assert_eq!(unit.totals().saturated, 2);
}

#[test]
fn a_gap_and_a_new_start_are_told_apart() {
    let mut unit = proven();
    // Batches 21 and 22 are missing: 100 samples.
    let after = take(&mut unit, batch(23, REST)).unwrap();
    assert_eq!((after.lost, after.restarted), (100, false));
    let mut report = batch(24, REST);
    report.first_sequence = 0;
    let anew = take(&mut unit, report).unwrap();
    assert_eq!((anew.lost, anew.restarted), (0, true));
    assert_eq!(unit.totals(), Totals { saturated: 0, lost: 100, restarts: 1 });
}

/// REP 145: the stream for tools is thinned to 100 Hz, its stamps evenly spaced across batches.
#[test]
fn a_thousand_samples_a_second_become_twenty_five() {
    let mut unit = proven();
    let thinned: Vec<_> =
        (21..41).flat_map(|index| take(&mut unit, batch(index, REST)).unwrap().thinned).collect();
    assert_eq!(thinned.len(), 25);
    for pair in thinned.windows(2) {
        assert!((pair[1].stamp.0 - pair[0].stamp.0 - 0.04).abs() < 1e-9);
    }
    // 0.3^2/40
    assert!((thinned[0].variance_m2_s4 - 0.00225).abs() < 1e-12);
}

proptest! {
    /// S5: whatever the bits, what passes is finite and in range, and the rest is counted.
    #[test]
    fn any_bits_give_a_checked_batch_or_a_counted_refusal(
        reports in proptest::collection::vec((any::<[u64; 3]>(), any::<u64>(), any::<u64>(), 0u8..8), 1..60)
    ) {
        let mut unit = proven();
        let mut refused = unit.refusals().total();
        for (index, (sample, stamp, sequence, kind)) in reports.into_iter().enumerate() {
            let mut report = batch(21 + u32::try_from(index).unwrap(), REST);
            let now = arrival(&report);
            match kind {
                0 => report.samples[0] = sample.map(f64::from_bits),
                1 => report.first = Seconds(f64::from_bits(stamp)),
                2 => report.first_sequence = sequence,
                3 => report.period = Seconds(f64::from_bits(stamp)),
                4 => report.range_m_s2 = f64::from_bits(stamp),
                _ => {}
            }
            match unit.on_report(now, report) {
                Ok(checked) => {
                    prop_assert!(checked.report.samples.iter().flatten().all(|value| value.abs() <= 156.9064));
                    prop_assert!(checked.thinned.iter().all(|thin| thin.mean_m_s2.iter().all(|v| v.is_finite())));
                }
                Err(_) => refused += 1,
            }
        }
        prop_assert_eq!(unit.refusals().total(), refused);
    }
}
