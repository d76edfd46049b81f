//! Laws of the calibration.

use super::super::tests::physics;
use super::valley::student;
use super::*;
use models::advance::{Condition, DriveKind};
use models::units::Celsius;

fn pattern(width_sigma_m: f64) -> Pattern {
    let raw = RawPattern {
        lines: 11,
        reach: 0.15,
        spacing_m: 5e-4,
        width_sigma_m,
        patterns_max: 8,
        repeats: 4,
        thin_max: 0.18,
        step_s: 1e-3,
    };
    Pattern::try_from(raw).unwrap()
}

fn printer() -> VirtualLine {
    let at = Condition { temperature: Celsius(215.0), height_m: 2e-4, width_m: 4e-4 };
    physics().line(DriveKind::Bowden, "PLA", &at, Seconds(1e-3)).unwrap()
}

/// t(0.975): 2.306 with 8 degrees of freedom, 2.776 with 4, 3.182 with 3.
#[test]
fn the_quantile_is_students() {
    for (freedom, quantile) in [(8.0, 2.306), (4.0, 2.776), (3.0, 3.182)] {
        assert!((student(freedom) / quantile - 1.0).abs() < 0.01, "{freedom}");
    }
}

/// 95 % of the intervals hold the truth: 40 seeds miss at most 6 (2 expected, P(> 6) < 1 %).
#[test]
fn the_interval_holds_the_best_line() {
    let (printer, pattern) = (printer(), pattern(1.2e-5));
    let best_s = printer.best().unwrap().advance_s;
    let missed = (0..40)
        .filter(|seed| {
            let found = calibrate(&printer, &pattern, (0.63, 4e-4), &mut Stream::new(*seed)).unwrap();
            assert!(found.half_width_s < 0.02, "{found:?}");
            (found.advance_s - best_s).abs() > found.half_width_s
        })
        .count();
    assert!(missed <= 6, "{missed} of 40");
}

/// Started at half and at twice the best, the pattern moves until it brackets it.
#[test]
fn a_bad_start_is_walked_away_from() {
    let printer = printer();
    let best_s = printer.best().unwrap().advance_s;
    for start_s in [0.5 * best_s, 2.0 * best_s] {
        let found = calibrate(&printer, &pattern(1.2e-5), (start_s, 4e-4), &mut Stream::new(1)).unwrap();
        assert!((found.advance_s - best_s).abs() < 0.02, "{found:?}");
    }
}

/// The best at two thirds of the reach, of the only pattern that may be printed, is at its edge: refused with the range.
#[test]
fn a_best_at_the_edge_is_refused() {
    let printer = printer();
    let start_s = printer.best().unwrap().advance_s / 1.1;
    let one = Pattern::try_from(RawPattern { patterns_max: 1, ..pattern(1.2e-5).0 }).unwrap();
    let refused = calibrate(&printer, &one, (start_s, 4e-4), &mut Stream::new(1)).unwrap_err();
    let expected = NoBest::Outside { low_s: 0.85 * start_s, high_s: 1.15 * start_s };
    assert_eq!(refused.to_string(), expected.to_string());
    assert!(calibrate(&printer, &pattern(1.2e-5), (start_s, 4e-4), &mut Stream::new(1)).is_ok());
}

/// Lines that differ from print to print by more than their widths' noise, all of a pattern by the same: the scatter
/// of the patterns tells, that of the lines about the curve does not.
#[test]
fn patterns_that_differ_widen_the_interval() {
    let (printer, pattern) = (printer(), pattern(1.2e-5));
    let best_s = printer.best().unwrap().advance_s;
    let widths = |shift: f64| {
        let (mut chance, mut shifts, mut printed) = (Stream::new(1), Stream::new(2), 0);
        let mut shift_s = 0.0;
        let mut line = |advance_s: f64| -> Result<Line, Infallible> {
            if printed % 11 == 0 {
                shift_s = shift * best_s * shifts.normal();
            }
            printed += 1;
            Ok(look(&printer, 5e-4, (advance_s - shift_s, 0.03), &mut chance))
        };
        calibrate_by(&mut line, &pattern, (best_s, 4e-4)).unwrap().unwrap().half_width_s
    };
    assert!(widths(0.03) > 3.0 * widths(0.0), "{} {}", widths(0.03), widths(0.0));
}

/// Lines that scatter by more than one pattern tells: more patterns of the same do, and the interval holds the best.
#[test]
fn lines_that_scatter_are_printed_again() {
    let (printer, pattern) = (printer(), pattern(1.2e-5));
    let best_s = printer.best().unwrap().advance_s;
    let answered = (0..20)
        .filter(|seed| {
            let (mut chance, mut spools) = (Stream::new(*seed), Stream::new(seed + 100));
            let mut line = |advance_s: f64| -> Result<Line, Infallible> {
                let needed_s = best_s * (1.0 + 0.06 * spools.normal());
                let as_if_s = best_s + advance_s - needed_s;
                Ok(look(&printer, 5e-4, (as_if_s, 0.03), &mut chance))
            };
            let found = calibrate_by(&mut line, &pattern, (best_s, 4e-4)).unwrap();
            found.is_ok_and(|found| (found.advance_s - best_s).abs() <= found.half_width_s)
        })
        .count();
    assert!(answered >= 17, "{answered} of 20");
}

#[test]
fn widths_that_are_all_noise_say_nothing() {
    let refused = calibrate(&printer(), &pattern(1e-3), (0.63, 4e-4), &mut Stream::new(1));
    assert!(matches!(refused, Err(NoBest::Flat | NoBest::Outside { .. })), "{refused:?}");
}

/// A drive that slips where it is fast: the best K is not told, since it makes up for the slip and no ramp.
#[test]
fn a_fast_stretch_that_stays_thin_is_refused() {
    let (printer, pattern) = (printer(), pattern(1.2e-5));
    let best_s = printer.best().unwrap().advance_s;
    let found = |slip: f64| {
        let mut chance = Stream::new(1);
        let mut line = |advance_s: f64| -> Result<Line, Infallible> {
            let seen = look(&printer, 5e-4, (advance_s, 0.03), &mut chance);
            Ok(Line { thin: seen.thin + slip, ..seen })
        };
        calibrate_by(&mut line, &pattern, (best_s, 4e-4)).unwrap()
    };
    let sound = found(0.0).unwrap();
    assert!((sound.advance_s - best_s).abs() < 0.02, "{sound:?}");
    let Err(NoBest::Thin { advance_s, thin, thin_max }) = found(0.3) else { panic!("{:?}", found(0.3)) };
    assert!((advance_s - best_s).abs() < 0.02 && (thin - 0.3).abs() < 0.02 && thin_max < thin);
}

/// Without any advance the fast stretch is thin and the slow one behind it wide; at the best K both are as wanted.
#[test]
fn the_best_advance_leaves_no_stretch_thin() {
    let printer = printer();
    let best_s = printer.best().unwrap().advance_s;
    let thin = |advance_s: f64| look(&printer, 5e-4, (advance_s, 0.0), &mut Stream::new(1)).thin;
    assert!(thin(best_s).abs() < 0.01 && thin(0.0) > 0.3, "{} {}", thin(best_s), thin(0.0));
}
