//! The files of `tests/data/gcode` and laws of reading.

use super::survey::{Survey, survey};
use super::{Header, Words, lex, oddity::Oddities};
use crate::motion::tests_support::shipped_params;
use crate::motion::{Action, Job, MotionParams, Step};
use proptest::prelude::*;

mod files;

fn survey_of(bytes: &[u8]) -> Survey {
    let params: MotionParams = shipped_params();
    survey(bytes, &Header::scan(bytes, bytes), &params)
}

#[test]
fn slicers_ways_of_writing_numbers_are_all_the_same_number() {
    let mut words = Words::default();
    let mut odd = Oddities::new(10);
    let body = "N7 G1 X10 Y-0.5";
    let numbered = format!("{body}*{}", body.bytes().fold(0, |sum, byte| sum ^ byte));
    for (line, expected) in [
        (&b"G1X10Y-.5"[..], [Some(10.0), Some(-0.5)]),
        (b"G01 X10. Y-0.5", [Some(10.0), Some(-0.5)]),
        (b"G1 X+10.000\tY-00.5 ; Y7", [Some(10.0), Some(-0.5)]),
        (numbered.as_bytes(), [Some(10.0), Some(-0.5)]),
        (b"G1 (to (here) X3) X10 (Z) Y-0.5", [Some(10.0), Some(-0.5)]),
        (b"G1 Y.1234567890123456789012", [None, Some(0.123_456_789_012_345_68)]),
    ] {
        lex(line, &mut words, &mut odd);
        assert_eq!([words.get(b'X'), words.get(b'Y')], expected, "{}", String::from_utf8_lossy(line));
    }
}

/// An absolute E continues across refused lines: nothing is lost, nothing counted twice.
#[test]
fn net_filament_in_absolute_mode_is_the_last_e_word() {
    let text = b"G90\nM82\nG1 X10 E1\nG1 X E2\nG1 X1 X2 E3\nG92 E0\nG1 X20 E4.5\n";
    let found = survey_of(text);
    assert!((found.filament_mm - 5.5).abs() < 1e-9, "{}", found.filament_mm);
    assert_eq!(found.warnings_total, 2);
}

/// A pressure advance that is negative, no number, missing or the unitless K of old firmware is told, and the one before
/// it stays.
#[test]
fn an_odd_pressure_advance_is_refused_and_told() {
    for (line, reason) in [
        ("M900 K-0.1", "K = -0.1: must be in [0, 10]: refused"),
        ("M900 K75", "K = 75: must be in [0, 10]: refused"),
        ("M900 K", "K has no value: refused"),
        ("M900", "pressure advance without a value: nothing changes"),
        ("M572 D0 S-1", "S = -1: must be in [0, 10]: refused"),
        ("SET_PRESSURE_ADVANCE ADVANCE=-0.1", "A = -0.1: must be in [0, 10]: refused"),
        ("SET_PRESSURE_ADVANCE ADVANCE=11", "A = 11: must be in [0, 10]: refused"),
        ("SET_PRESSURE_ADVANCE ADVANCE=nan", "A = nan: not a number: refused"),
        ("SET_PRESSURE_ADVANCE EXTRUDER=extruder", "pressure advance without a value: nothing changes"),
    ] {
        let text = format!("M900 K0.5\nG1 X10 E1\n{line}\nG1 X20 E2\n");
        let found = survey_of(text.as_bytes());
        let told: Vec<_> = found.warnings.iter().map(|odd| (odd.line, odd.reason.as_str())).collect();
        assert_eq!(told, [(3, reason)], "{line}");
        let params: MotionParams = shipped_params();
        let advances = Job::from_bytes(text.as_bytes(), &params)
            .filter(|step| matches!(step, Step::Action(Action::Advance(_), _)))
            .count();
        assert_eq!(advances, 1, "{line}");
    }
    let text = b"M900 KNaN\nG1 X10 E1\n";
    assert!(survey_of(text).warnings_total > 0);
}

/// What has no upper end is refused without one; a wait that nobody meant is told.
#[test]
fn feeds_and_waits_without_a_sense_are_told_by_line() {
    for (line, reason) in [
        ("G1 X20 F0", "F = 0: must be at least 0.06 mm/min: refused"),
        ("G4 S-1", "S = -1: must be at least 0 s: refused"),
        ("G4 S100000000", "the print waits 100000000 s, longer than an hour: executed as written"),
        ("G4 P3600001", "the print waits 3600.001 s, longer than an hour: executed as written"),
    ] {
        let found = survey_of(format!("G1 X10 E1\n{line}\nG4 S3600\n").as_bytes());
        let told: Vec<_> = found.warnings.iter().map(|odd| (odd.line, odd.reason.as_str())).collect();
        assert_eq!(told, [(2, reason)], "{line}");
    }
}

/// Micrometres where millimetres are meant: told by line, value and range, not used. A width of the next comment is.
#[test]
fn a_width_or_a_height_that_no_road_has_is_told_and_not_used() {
    for (comment, reason) in [
        ("WIDTH:450", "WIDTH = 450 mm: must be in [0.05, 5] mm: not used"),
        ("WIDTH:0.049", "WIDTH = 0.049 mm: must be in [0.05, 5] mm: not used"),
        ("LINE_WIDTH: 0", "LINE_WIDTH = 0 mm: must be in [0.05, 5] mm: not used"),
        ("HEIGHT:200", "HEIGHT = 200 mm: must be in [0.001, 5] mm: not used"),
        ("LAYER_HEIGHT: -0.2", "LAYER_HEIGHT = -0.2 mm: must be in [0.001, 5] mm: not used"),
    ] {
        let text = format!(
            ";WIDTH:0.45\n;HEIGHT:0.25\nG1 X10 Z.2 E.4\n;{comment}\nG1 X20 E.8\n;WIDTH:5\n;HEIGHT:0.1\nG1 X30 E1.2\n"
        );
        let found = survey_of(text.as_bytes());
        let told: Vec<_> = found.warnings.iter().map(|odd| (odd.line, odd.reason.as_str())).collect();
        assert_eq!(told, [(4, reason)]);
        let roads: Vec<_> = Job::from_bytes(text.as_bytes(), &shipped_params())
            .filter_map(|step| if let Step::Move(road) = step { Some(road) } else { None })
            .map(|road| (road.stated_width_m, road.layer_height_m))
            .collect();
        let mm = |value: f64| Some(value * 1e-3);
        // Without a stated height that of the level counts.
        let odd = if comment.contains("WIDTH") { (None, mm(0.25)) } else { (mm(0.45), mm(0.2)) };
        assert_eq!(roads, [(mm(0.45), mm(0.25)), odd, (mm(5.0), mm(0.1))], "{comment}");
    }
}

/// 1 inch = 25.4 mm, for coordinates, filament and feed alike.
#[test]
fn inches_scale_ways_filament_and_feed() {
    let mm = survey_of(b"G21\nG1 F1270\nG1 X25.4 E2.54\n");
    let inch = survey_of(b"G20\nG1 F50\nG1 X1 E.1\n");
    assert!((mm.filament_mm - inch.filament_mm).abs() < 1e-9);
    assert!((mm.print_time_s - inch.print_time_s).abs() < 1e-9);
}

/// A full circle of radius r is 2 pi r long, less what chords cut: relative (tolerance/r)/3 at most.
#[test]
fn a_full_circle_is_as_long_as_its_circumference() {
    for text in [&b"G1 X10 Y0 F600\nG2 I-10 J0 E1\n"[..], b"G1 X10 Y0 F600\nG3 X10 Y0 I-10 E1\n"] {
        let found = survey_of(text);
        let circumference_m = std::f64::consts::TAU * 0.01;
        let tolerance = shipped_params().read.chord_tolerance_m / 0.01;
        assert_eq!(found.arcs, 1);
        assert!(
            (found.deposit_m / circumference_m - 1.0).abs() < tolerance / 3.0 * 1.01,
            "{}",
            found.deposit_m
        );
        assert!((found.filament_mm - 1.0).abs() < 1e-9);
    }
}

/// `R` names the same half circle as `I`, and a negative one the long way.
#[test]
fn an_arc_by_radius_takes_the_short_way_and_by_negative_radius_the_long_way() {
    let way = |text: &[u8]| survey_of(text).deposit_m;
    let quarter_m = 0.01 * std::f64::consts::FRAC_PI_2;
    assert!((way(b"G2 X10 Y10 R10 E1\n") / quarter_m - 1.0).abs() < 1e-3);
    assert!((way(b"G3 X10 Y10 R-10 E1\n") / (3.0 * quarter_m) - 1.0).abs() < 1e-3);
    assert_eq!(survey_of(b"G2 X10 Y10 R1 E1\n").warnings_total, 1);
}

#[test]
fn a_firmware_retraction_goes_back_and_forth_by_the_same_length() {
    let found = survey_of(b"SET_RETRACTION RETRACT_LENGTH=0.8 RETRACT_SPEED=35\nG10\nG1 X10\nG11\n");
    assert!(found.filament_mm.abs() < 1e-12);
    assert_eq!(found.moves, 3);
}

#[test]
fn a_macro_that_starts_a_print_homes_and_heats() {
    use crate::motion::{Action, Job, Step};
    use crate::units::Celsius;
    let text: &[u8] = b"START_PRINT BED_TEMP=85 EXTRUDER_TEMP=245\nEND_PRINT\n";
    let actions: Vec<Action> = Job::from_bytes(text, &shipped_params())
        .filter_map(|step| if let Step::Action(action, _) = step { Some(action) } else { None })
        .collect();
    assert_eq!(
        actions,
        [
            Action::Home([true; 3]),
            Action::BedTarget { target: Celsius(85.0), wait: true },
            Action::HotendTarget { target: Celsius(245.0), wait: true },
            Action::HotendTarget { target: Celsius(0.0), wait: false },
            Action::BedTarget { target: Celsius(0.0), wait: false },
            Action::Fan(0.0),
            Action::End,
        ]
    );
}

/// Without marks a layer begins where an extrusion lies at another height; a spiral has none.
#[test]
fn layers_without_marks_follow_the_height_of_extrusions() {
    let found = survey_of(b"G1 Z.2\nG1 X1 E1\nG1 Z.6\nG1 X2\nG1 Z.2\nG1 X3 E2\nG1 Z.4\nG1 X4 E3\n");
    assert_eq!(found.layers, 2);
    assert_eq!(survey_of(b"G1 X1 Z.2 E1\nG1 X2 Z.3 E2\nG1 X3 Z.4 E3\n").layers, 0);
}

#[test]
fn warnings_are_bounded_and_all_are_counted() {
    let text = b"G1 Xnan\n".repeat(5000);
    let found = survey_of(&text);
    assert_eq!(found.warnings.len(), shipped_params().read.warnings_max);
    assert_eq!(found.warnings_total, 5000);
}

#[test]
fn a_dialect_a_limit_and_the_slicers_own_figures_are_read_from_the_end_of_the_file() {
    let tail = b"; machine_max_feedrate_x = 300,200\n; machine_max_jerk_y = 7,5\n; gcode_flavor = marlin2\n\
        ; estimated printing time (normal mode) = 1d 2h 3m 4s\n; filament used [mm] = 12.5\n";
    let header = Header::scan(b"; generated by PrusaSlicer 2.5.0 on 2026-11-21\n", tail);
    let limits = header.limits(shipped_params().limits);
    assert_eq!(header.dialect(), "PrusaSlicer 2.5.0, marlin2");
    assert!((limits.feedrate_m_s[0] - 0.3).abs() < 1e-12 && (limits.jerk_m_s[1] - 0.007).abs() < 1e-12);
    assert_eq!(header.stated_time.map(|time| time.0), Some(93_784.0));
    assert!((header.stated_filament_m.unwrap() - 0.0125).abs() < 1e-12);
}

proptest! {
    /// Whatever stands in a file, reading ends with finite figures.
    #[test]
    fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let found = survey_of(&bytes);
        prop_assert!(found.print_time_s.is_finite() && found.filament_mm.is_finite());
    }

    /// As above with the letters that commands are made of, so that most lines get past the lexer.
    #[test]
    fn no_words_make_it_panic(text in "([GMTN][0-9]{1,3}[.]?[0-9]?( ?[XYZEFIJPQRSTK][-+]?[0-9.]{0,9}[*;( ]?){0,6}[\r\n]){0,12}") {
        let found = survey_of(text.as_bytes());
        prop_assert!(found.print_time_s.is_finite() && found.filament_mm.is_finite());
    }
}
