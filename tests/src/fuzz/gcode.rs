//! G-code: read, interpreted and planned as the printer, the estimator and `fdm gcode` do.

use super::laws::is_finite;
use super::shipped;
use models::gcode::survey::survey;
use models::gcode::{Header, LineReader, Oddities, Words, lex};
use models::motion::{Job, MotionParams, Segment, Step};
use models::units::Seconds;
use std::sync::LazyLock;

static PARAMS: LazyLock<MotionParams> =
    LazyLock::new(|| shipped::block("printers/ender3_motion.yaml", "printer_motion"));

/// A file; whether the planner knows all moves ahead or four of them, the number of bytes says.
pub fn gcode(bytes: &[u8]) {
    let params = if bytes.len().is_multiple_of(2) { *PARAMS } else { PARAMS.with_buffer(4) };
    let (mut steps, mut time_s) = (0_u64, 0.0);
    let mut job = Job::from_bytes(bytes, &params);
    for step in &mut job {
        steps += 1;
        match step {
            Step::Move(segment) => {
                is_sound(&segment);
                time_s += segment.profile.duration().0;
            }
            Step::Action(action, line) => {
                is_finite(&action);
                assert!(line <= job_lines(bytes), "line {line}");
            }
        }
    }
    let totals = *job.totals();
    is_finite(&totals);
    assert!(totals.time.0 >= time_s * (1.0 - 1e-9), "{totals:?}: {time_s} s of moves");
    assert!(totals.moves <= steps);
    let found = survey(bytes, &Header::scan(bytes, bytes), &params);
    is_finite(&found.print_time_s);
    assert!(found.warnings.len() <= params.read.warnings_max);
    lines(bytes, params.read.line_bytes_max);
}

fn job_lines(bytes: &[u8]) -> u64 {
    bytes.iter().filter(|byte| **byte == b'\n').count() as u64 + 1
}

/// A move is one: finite, inside the coordinates that are believed, its time no less than nothing.
fn is_sound(segment: &Segment) {
    let coordinates = segment.start_m.iter().chain(&segment.end_m);
    let reach_m = PARAMS.read.coordinate_max_m;
    assert!(coordinates.into_iter().all(|value| value.abs() <= 4.0 * reach_m), "{segment:?}");
    let profile = &segment.profile;
    let speeds = [profile.entry_m_s, profile.cruise_m_s, profile.exit_m_s];
    assert!(speeds.iter().all(|speed_m_s| (0.0..=1e3).contains(speed_m_s)), "{segment:?}");
    let times = [profile.accel_s, profile.cruise_s, profile.decel_s, profile.duration().0];
    assert!(times.iter().all(|time_s| time_s.is_finite() && *time_s >= 0.0), "{segment:?}");
    assert!(
        segment.length_m.is_finite() && segment.length_m >= 0.0 && segment.filament_m.is_finite(),
        "{segment:?}"
    );
    let path_m = segment.path_m();
    assert!((profile.path_m() - path_m).abs() <= 1e-6 + 1e-6 * path_m, "{segment:?}");
    let (middle, _) = segment.at(Seconds(0.5 * profile.duration().0));
    is_finite(&middle);
}

/// Line by line, as an editor would: the same number of lines, each no longer than allowed, its words finite.
fn lines(bytes: &[u8], longest: usize) {
    let (mut reader, mut words, mut odd) =
        (LineReader::new(bytes, longest), Words::default(), Oddities::new(10));
    let mut last = 0;
    while let Ok(Some(line)) = reader.next_line() {
        assert!(line.bytes.len() <= longest && line.line == last + 1);
        last = line.line;
        lex(line.bytes, &mut words, &mut odd);
        for letter in b'A'..=b'Z' {
            assert!(words.get(letter).is_none_or(f64::is_finite), "{:?}", line.bytes);
        }
    }
}

pub(super) fn seeds() -> Vec<Vec<u8>> {
    // The heads of sliced files and what somebody wrote to be odd: a whole print would take its second each time.
    let heads = shipped::data("gcode").into_iter().map(|mut file| {
        file.truncate(6000);
        file
    });
    let arcs = b"G90\nM83\nM204 P1000\nG1 X10 Y10 F3000\nG2 X20 Y10 I5 J0 E.5\nG3 X10 Y10 R5 E.5\nG5 I2 J3 P-2 Q-3 X15 Y15 E.2\nM900 K.05\nG28 W\nM109 S210\nG4 P100\nG10\nG11\nM600\nG92 E0\n";
    heads.chain([arcs.to_vec()]).collect()
}
