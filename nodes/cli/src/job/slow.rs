//! The line of a file at which a print stands longest: a slip of the pen there looks like a printer that hangs.

use models::motion::{Action, Step};
use std::fmt;

/// From here on it is told `[s]`.
const LONG_S: f64 = 300.0;

/// A print that waits longer is taken for a slip of the pen `[s]`.
const ENDLESS_S: f64 = 86_400.0;

/// A line at which the print waits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wait {
    line: u64,
    time_s: f64,
}

impl Wait {
    pub(super) fn is_endless(&self) -> bool {
        self.time_s > ENDLESS_S
    }

    /// Keeps the longest.
    pub(super) fn note(longest: &mut Option<Self>, step: &Step) {
        let Step::Action(Action::Dwell(time), line) = step else { return };
        if longest.is_none_or(|longest| time.0 > longest.time_s) {
            *longest = Some(Self { line: *line, time_s: time.0 });
        }
    }
}

impl fmt::Display for Wait {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {} waits {} s, longer than a day: not printed", self.line, self.time_s)
    }
}

/// What one line moves, all chords of an arc together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    line: u64,
    time_s: f64,
    way_m: f64,
    filament_m: f64,
}

impl Line {
    pub(super) fn is_long(&self) -> bool {
        self.time_s > LONG_S
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line, time_s, way_m, filament_m } = self;
        write!(
            f,
            "line {line} alone takes {:.0} min at the printer's limits ({:.1} mm of filament, {:.1} mm of way): progress \
             stands still for as long",
            time_s / 60.0,
            filament_m * 1e3,
            way_m * 1e3
        )
    }
}

/// The line that takes longest; `None` where nothing moves.
pub(super) fn slowest(steps: impl Iterator<Item = Step>) -> Option<Line> {
    let (mut slowest, mut newest): (Option<Line>, Option<Line>) = (None, None);
    for step in steps {
        let Step::Move(segment) = step else { continue };
        let before = newest.filter(|before| before.line == segment.line);
        let line = Line {
            line: segment.line,
            time_s: segment.profile.duration().0 + before.map_or(0.0, |before| before.time_s),
            way_m: segment.length_m + before.map_or(0.0, |before| before.way_m),
            filament_m: segment.filament_m + before.map_or(0.0, |before| before.filament_m),
        };
        newest = Some(line);
        if slowest.is_none_or(|slowest| line.time_s > slowest.time_s) {
            slowest = newest;
        }
    }
    slowest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::ConfigDir;
    use models::gcode::Header;
    use models::motion::Job;
    use std::path::Path;

    fn slowest_of(text: &str) -> Line {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config"));
        let motion = ConfigDir::find(Some(folder)).unwrap().motion().unwrap();
        slowest(Job::new(text.as_bytes(), &Header::default(), &motion)).unwrap()
    }

    /// 6 m of filament at 10 mm/s are 600 s, of which starting and stopping take less than a second.
    #[test]
    fn a_move_of_metres_of_filament_is_told_with_its_line_and_time() {
        let line = slowest_of("M83\nG1 X10 E1 F1200\nG1 E6000 F600\nG1 X20 E1 F1200\n");
        assert!(line.is_long() && (line.time_s - 600.0).abs() < 1.0, "{line:?}");
        assert_eq!(
            line.to_string(),
            "line 3 alone takes 10 min at the printer's limits (6000.0 mm of filament, 0.0 mm of way): progress stands \
             still for as long"
        );
        assert!(!slowest_of("M83\nG1 X10 E1 F1200\n").is_long());
    }

    /// An arc is many chords, and one line: half a circle of 10 mm.
    #[test]
    fn the_chords_of_an_arc_are_one_line() {
        let line = slowest_of("M83\nG1 X10 Y10 F6000\nG2 X30 Y10 I10 J0 E1 F60\n");
        let way_m = std::f64::consts::PI * 0.01;
        assert!(line.line == 3 && (line.way_m / way_m - 1.0).abs() < 0.01, "{line:?}");
        // 31.4 mm at 1 mm/s.
        assert!((line.time_s - 31.4).abs() < 1.0, "{line:?}");
    }
}
