//! The five files.

use super::survey_of;
use std::path::PathBuf;

fn file(name: &str) -> Vec<u8> {
    let path: PathBuf = [env!("CARGO_MANIFEST_DIR"), "../../tests/data/gcode", name].iter().collect();
    std::fs::read(path).unwrap()
}

/// Sum over the E words by splitting text, sharing no code with the reader; exact for files without oddities.
fn independent_filament_mm(bytes: &[u8]) -> f64 {
    let text = String::from_utf8_lossy(bytes);
    let (mut sum, mut at, mut relative, mut relative_all) = (0.0, 0.0, false, false);
    for line in text.lines() {
        let code = line.split(';').next().unwrap_or("");
        let mut tokens = code.split_whitespace();
        let head = tokens.next().unwrap_or("");
        let e = tokens.find_map(|token| token.strip_prefix('E')).and_then(|text| text.parse::<f64>().ok());
        match (head, e) {
            ("M82", _) => relative = false,
            ("M83", _) => relative = true,
            ("G90", _) => relative_all = false,
            ("G91", _) => relative_all = true,
            ("G92", Some(e)) => at = e,
            ("G0" | "G1" | "G2" | "G3", Some(e)) if relative || relative_all => {
                sum += e;
                at += e;
            }
            ("G0" | "G1" | "G2" | "G3", Some(e)) => {
                sum += e - at;
                at = e;
            }
            _ => {}
        }
    }
    sum
}

const SLICED: [(&str, u32, u64); 4] = [
    ("prusa_cube_pla_marlin_relE.gcode", 100, 0),
    ("prusa_bracket_petg_klipper_fwretract_absE.gcode", 199, 0),
    ("prusa_ring_pla_marlin_arcfit_G2G3.gcode", 40, 1324),
    ("cura_cube_pla_marlin.gcode", 198, 0),
];

#[test]
fn layers_and_arcs_are_those_of_the_file() {
    for (name, layers, arcs) in SLICED {
        let found = survey_of(&file(name));
        assert_eq!((found.layers, found.arcs, found.errors.len()), (layers, arcs, 0), "{name}");
        assert_eq!(found.tools, 1, "{name}");
    }
}

/// Within 0.1 % of the words themselves (a firmware retraction left open at the end is 0.8 mm of 2789 mm), within
/// 2.5 % of the slicer's own count (it leaves out the line primed by the start code: 15 mm of 866 mm).
#[test]
fn filament_is_that_of_the_e_words_and_of_the_slicer() {
    for (name, _, _) in SLICED {
        let bytes = file(name);
        let found = survey_of(&bytes);
        let expected_mm = independent_filament_mm(&bytes);
        assert!(
            (found.filament_mm / expected_mm - 1.0).abs() < 1e-3,
            "{name}: {} {expected_mm}",
            found.filament_mm
        );
        if let Some(stated_mm) = found.stated_filament_mm {
            assert!(
                (found.filament_mm / stated_mm - 1.0).abs() < 0.025,
                "{name}: {} {stated_mm}",
                found.filament_mm
            );
        }
    }
}

/// PrusaSlicer's estimator plans the same trapezoids with the same limits; what is left are its rounding to seconds,
/// firmware retractions (which it takes as instant) and diagonal moves under M201 (it caps them at one axis' limit).
#[test]
fn planned_time_is_that_of_the_slicer() {
    for (name, _, _) in &SLICED[..3] {
        let found = survey_of(&file(name));
        let stated_s = found.stated_time_s.unwrap();
        println!("{name}: {} {stated_s} {}", found.print_time_s, found.print_time_s / stated_s - 1.0);
        assert!(
            (found.print_time_s / stated_s - 1.0).abs() < 0.10,
            "{name}: {} {stated_s}",
            found.print_time_s
        );
    }
}

#[test]
fn sliced_files_are_odd_only_where_they_are() {
    let odd = |name: &str| {
        let found = survey_of(&file(name));
        found.warnings.into_iter().map(|warning| (warning.line, warning.reason)).collect::<Vec<_>>()
    };
    assert_eq!(odd(SLICED[0].0), []);
    assert_eq!(odd(SLICED[2].0), []);
    assert_eq!(odd(SLICED[1].0).iter().map(|(line, _)| *line).collect::<Vec<_>>(), [18, 27_473]);
    assert_eq!(odd(SLICED[3].0), [(21_290, "Y = {machine_depth}: not a number: refused".to_owned())]);
}

/// Every line of the hand-made file that is odd, with what is odd about it; no other line is named.
#[test]
fn each_oddity_of_the_hand_made_file_is_named_by_line_and_reason() {
    let found = survey_of(&file("quirks_handmade.gcode"));
    let named = found.warnings.iter().map(|warning| (warning.line, warning.reason.as_str()));
    let expected = include_str!("quirks.txt").lines().filter_map(|line| line.split_once(": "));
    let expected: Vec<(u64, &str)> = expected.map(|(line, reason)| (line.parse().unwrap(), reason)).collect();
    assert_eq!(named.collect::<Vec<_>>(), expected);
}

/// By hand: 1.3 up to line 25, -0.8, +0.1, then from G92 at 0 to 1 mm on line 70; G10 and G11 cancel.
#[test]
fn the_hand_made_file_nets_the_filament_of_its_executed_lines() {
    let found = survey_of(&file("quirks_handmade.gcode"));
    assert!((found.filament_mm - 1.6).abs() < 1e-6, "{}", found.filament_mm);
    assert_eq!((found.arcs, found.tools, found.errors.len()), (4, 2, 0));
}

/// PrusaSlicer takes its flow from the same stadium: commanded width and stated width agree but for E and X, Y being
/// rounded (E to 1e-5 mm, X and Y to 1e-3 mm: 0.5 % on the millimetre, so roads from 1 mm on are compared).
#[test]
fn commanded_width_is_the_stated_one_where_the_slicer_states_it() {
    use crate::motion::tests_support::shipped_params;
    use crate::motion::{Job, Role, Step};
    let bytes = file(SLICED[0].0);
    let mut compared = 0;
    for step in Job::from_bytes(&bytes, &shipped_params()) {
        let Step::Move(segment) = step else { continue };
        if segment.role != Role::ExternalPerimeter || segment.length_m < 1e-3 {
            continue;
        }
        if let (Some(target_m), Some(stated_m)) = (segment.target_width_m, segment.stated_width_m) {
            compared += 1;
            assert!((target_m / stated_m - 1.0).abs() < 0.01, "line {}: {target_m} {stated_m}", segment.line);
        }
    }
    assert!(compared > 300, "{compared}");
}

/// Cura states no width: it follows from the E words, near the profile's line width of 0.4 mm.
#[test]
fn width_follows_from_filament_where_the_slicer_states_none() {
    use crate::motion::tests_support::shipped_params;
    use crate::motion::{Job, MoveKind, Step};
    let bytes = file(SLICED[3].0);
    let (mut volume, mut way) = (0.0, 0.0);
    for step in Job::from_bytes(&bytes, &shipped_params()) {
        let Step::Move(segment) = step else { continue };
        if segment.kind == MoveKind::Deposit && segment.layer > Some(0) {
            assert!((segment.layer_height_m.unwrap() - 1e-4).abs() < 1e-6, "line {}", segment.line);
            volume += segment.target_width_m.unwrap() * segment.length_m;
            way += segment.length_m;
        }
    }
    assert!((volume / way - 4e-4).abs() < 0.1e-3, "{}", volume / way);
}
