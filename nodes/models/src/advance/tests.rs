//! Laws of pressure advance.

use super::published::Published;
use super::width::Tally;
use super::*;
use crate::units::{Celsius, Seconds};
use std::collections::BTreeMap;

fn block<T: serde::de::DeserializeOwned>(file: &str, name: &str) -> T {
    type Tree<T> = BTreeMap<String, BTreeMap<String, BTreeMap<String, T>>>;
    let path = format!("{}/../../config/advance/{file}", env!("CARGO_MANIFEST_DIR"));
    let mut tree: Tree<T> = serde_saphyr::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    tree.remove("/**").unwrap().remove("ros__parameters").unwrap().remove(name).unwrap()
}

fn shipped() -> Physics {
    block("physics.yaml", "advance_physics")
}

fn at(temperature_c: f64, height_mm: f64, width_mm: f64) -> Condition {
    Condition { temperature: Celsius(temperature_c), height_m: 1e-3 * height_mm, width_m: 1e-3 * width_mm }
}

fn best_s(shipped: &Physics, drive: DriveKind, polymer: &str, at: &Condition) -> f64 {
    shipped.best(drive, polymer, at, Seconds(1e-3)).unwrap().advance_s
}

/// A lag without compensation approaches a step as `1 - e^(-t/K)`; one whose compensation is its lag follows at once,
/// and one that is over-compensated overshoots by the surplus alone: stable, other than the printed (4).
#[test]
fn the_compensated_lag_is_stable_and_cancels() {
    let after = |advance_s: f64, time_s: f64| {
        let lag = Compensation { lag_s: 0.5, advance_s };
        let state = lag.steady(1.0);
        // v0 jumps from 1 to 2: outlet = z + (K_A/K) v0 at the new speed.
        lag.outlet(lag.step(state, (2.0, 2.0), Seconds(time_s)), 2.0)
    };
    assert!((after(0.0, 0.5) - (2.0 - (-1.0_f64).exp())).abs() < 1e-12);
    assert!((after(0.5, 1e-9) - 2.0).abs() < 1e-9);
    assert!((after(0.75, 0.0) - 2.5).abs() < 1e-12);
    assert!((after(0.75, 20.0) - 2.0).abs() < 1e-12);
}

/// Steps of any size give the same outlet: the propagation is exact for linear pieces.
#[test]
fn the_step_does_not_matter() {
    let lag = Compensation { lag_s: 0.55, advance_s: 0.3 };
    let whole = lag.step(0.01, (0.02, 0.08), Seconds(0.06));
    let half = lag.step(0.01, (0.02, 0.05), Seconds(0.03));
    assert!((lag.step(half, (0.05, 0.08), Seconds(0.03)) - whole).abs() < 1e-15);
}

/// Model book 2.2: 1.5, 1.56, 1.985, 2.045, 3.545 s, 100 mm.
#[test]
fn the_test_line_is_the_papers() {
    let line = shipped().test_line;
    for (got, expected) in line.ends_s().into_iter().zip([1.5, 1.56, 1.985, 2.045, 3.545]) {
        assert!((got - expected).abs() < 1e-12);
    }
    assert!((line.at(Seconds(3.545)).distance_m - 0.1).abs() < 1e-12);
    let middle = line.at(Seconds(1.53));
    assert!((middle.speed_m_s - 0.05).abs() < 1e-12 && (middle.acceleration_m_s2 - 1.0).abs() < 1e-12);
}

/// What was compressed at the start is compressed at the end, to what is not yet settled: filament laid and wanted agree.
#[test]
fn the_virtual_line_keeps_its_filament() {
    let shipped = shipped();
    let line = shipped.line(DriveKind::Direct, "PLA", &at(215.0, 0.2, 0.4), Seconds(1e-3)).unwrap();
    let (mut wanted_m, mut laid_m) = (0.0, 0.0);
    // 1.5 s after the last ramp a lag of 0.06 s has settled to e^-25.
    line.print(0.05, |_, wanted_m_s, laid_m_s, dt| {
        wanted_m += wanted_m_s * dt.0;
        laid_m += laid_m_s * dt.0;
    });
    assert!((laid_m / wanted_m - 1.0).abs() < 1e-9, "{laid_m} of {wanted_m}");
}

/// Model book 2.3 and 2.4: the seven printed values, 0.010 s for Bowden and 0.003 s for direct.
#[test]
fn the_printed_values_are_met() {
    let shipped = shipped();
    let published: Published = block("published.yaml", "advance_published");
    assert_eq!(published.points.len(), 7);
    for point in &published.points {
        let at = at(published.temperature_c, 1e3 * point.height_m, 1e3 * published.width_m);
        let got_s = best_s(&shipped, point.drive, &published.polymer, &at);
        let limit_s = if point.drive == DriveKind::Bowden { 0.0105 } else { 0.0035 };
        assert!((got_s - point.advance_s).abs() < limit_s, "{point:?}: {got_s}");
    }
}

/// Model book 2.4: at 230 degC PETG needs most, then ABS, then PLA; hotter, higher and wider lines need less.
#[test]
fn trends_are_the_papers() {
    let shipped = shipped();
    let best = |polymer: &str, at: &Condition| best_s(&shipped, DriveKind::Bowden, polymer, at);
    for height_mm in [0.1, 0.2, 0.4] {
        let here = at(230.0, height_mm, 0.4);
        let (petg, abs, pla) = (best("PETG", &here), best("ABS", &here), best("PLA", &here));
        assert!(petg > abs && abs > pla, "{petg} {abs} {pla}");
        assert!(best("PLA", &at(200.0, height_mm, 0.4)) > pla);
        assert!(best("PLA", &at(230.0, height_mm, 0.5)) < pla);
    }
    assert!(best("PLA", &at(215.0, 0.1, 0.4)) > best("PLA", &at(215.0, 0.2, 0.4)));
}

/// The secant needs no simulation and is within 2 % of the best, over the corners of Table 1.
#[test]
fn the_secant_is_close_to_the_best() {
    let shipped = shipped();
    for kind in DriveKind::ALL {
        for (name, polymer) in &shipped.polymers {
            for temperature_c in polymer.range_c {
                for (height_mm, width_mm) in [(0.1, 0.4), (0.2, 0.4), (0.4, 0.4), (0.4, 0.6)] {
                    let at = at(temperature_c, height_mm, width_mm);
                    let secant_s = shipped.secant_s(kind, name, &at).unwrap();
                    let best_s = best_s(&shipped, kind, name, &at);
                    let off = secant_s / best_s - 1.0;
                    assert!(off.abs() < 0.02, "{kind:?} {name} {at:?}: {secant_s} of {best_s}");
                }
            }
        }
    }
}

#[test]
fn width_errors_are_weighted_by_the_way() {
    let mut tally = Tally::default();
    assert!(tally.errors().is_none());
    tally.add(0.1, 3.0);
    tally.add(-0.3, 1.0);
    let errors = tally.errors().unwrap();
    // (3*0.01 + 0.09)/4 = 0.03
    assert!((errors.rms - 0.03_f64.sqrt()).abs() < 1e-15);
    assert!((errors.mean_abs - 0.15).abs() < 1e-15);
    assert!((errors.under_max - 0.3).abs() < 1e-15 && (errors.over_max - 0.1).abs() < 1e-15);
}

/// A ramp that does not fit into its stretch would print another line than the one asked for.
#[test]
fn a_line_shorter_than_its_ramps_is_refused() {
    let raw =
        RawTestLine { low_m_s: 0.02, high_m_s: 0.08, acceleration_m_s2: 1.0, low_m: 0.03, high_m: 0.005 };
    assert_eq!(
        TestLine::try_from(raw).unwrap_err().to_string(),
        "ramps = 0.006: must be below test_line.high_m = 0.005"
    );
}

/// Straight on, left by 90 degrees, back: and a point twice in the same place changes nothing.
#[test]
fn turns_are_measured_against_the_direction_before() {
    let path = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 0.0]];
    let degrees: Vec<f64> = turn::turn_angles_rad(&path).into_iter().map(f64::to_degrees).collect();
    assert_eq!(degrees.len(), 4);
    for (got, expected) in degrees.iter().zip([0.0, 0.0, 90.0, 180.0]) {
        assert!((got - expected).abs() < 1e-9, "{degrees:?}");
    }
    // Left is positive, right negative; 30 degrees sharp is no turn of more than 30 degrees.
    for (degrees, turns) in [(29.9, false), (-29.9, false), (30.1, true), (-30.1, true)] {
        let after = [f64::to_radians(degrees).cos(), f64::to_radians(degrees).sin()];
        assert!((turn::turn_rad([2.0, 0.0], after).to_degrees() - degrees).abs() < 1e-9);
        let corner = [[0.0, 0.0], [1.0, 0.0], [1.0 + after[0], after[1]]];
        let expected = if turns { Some(1.0) } else { None };
        assert_eq!(turn::ways_to_turn_m(&corner, 30.0_f64.to_radians()), [expected, None], "{degrees}");
    }
    let ways = turn::ways_to_turn_m(&path, 30.0_f64.to_radians());
    assert_eq!(ways, [Some(2.0), Some(1.0), Some(1.0), Some(1.0), None]);
}

/// A millisecond for a second, a millimetre for a metre, the larger one first: the field is named with its range.
#[test]
fn slips_of_units_and_reversed_ranges_are_refused() {
    let shipped = shipped();
    let drive = *shipped.drive(DriveKind::Bowden);
    let refused = |raw: RawDrive| Drive::try_from(raw).unwrap_err().to_string();
    let error = refused(RawDrive { scale_s: 132.0, ..*drive });
    assert_eq!(error, "scale_s = 132 s: must be in [0.0001, 5]");
    let error = refused(RawDrive { gap_m: 0.11, ..*drive });
    assert_eq!(error, "gap_m = 0.11 m: must be in [0.000001, 0.001]");
    let error = refused(RawDrive { advance_range_s: [1.5, 0.3], ..*drive });
    assert_eq!(error, "advance_range_s[0] = 1.5: must be below advance_range_s[1] = 0.3");
    let polymer = shipped.polymers["PLA"];
    let error =
        Polymer::try_from(RawPolymer { range_c: [230.0, 200.0], ..*polymer }).unwrap_err().to_string();
    assert_eq!(error, "range_c[0] = 230: must be below range_c[1] = 200");
    let published: Published = block("published.yaml", "advance_published");
    let mut raw = (*published).clone();
    raw.points[0].height_m = 0.4;
    let error = Published::try_from(raw).unwrap_err().to_string();
    assert_eq!(error, "height_m = 0.4 m: must be in [0.00001, 0.005]");
}
