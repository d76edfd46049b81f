//! The first road of a file that is laid below any set-point at which plastic is laid: a file that was cut, or a start macro that nobody knows here.

use models::motion::{Action, MoveKind, Step};
use std::fmt;

/// Below this no material of `config/materials` is laid, nor does firmware push filament: 170 degC is its usual limit `[degC]`.
const LEAST_C: f64 = 150.0;

/// Whether the hot end is set to heat, and the first road that is laid while it is not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Cold {
    heated: bool,
    line: Option<u64>,
}

impl Cold {
    pub(super) fn note(&mut self, step: &Step) {
        match step {
            Step::Action(Action::HotendTarget { target, .. }, _) => self.heated = target.0 >= LEAST_C,
            Step::Move(segment) if segment.kind == MoveKind::Deposit && !self.heated => {
                self.line.get_or_insert(segment.line);
            }
            _ => {}
        }
    }

    pub(super) fn lays(&self) -> bool {
        self.line.is_some()
    }
}

impl fmt::Display for Cold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = self.line.unwrap_or(0);
        write!(
            f,
            "line {line} lays a road while the hot end is off or below {LEAST_C} degC: give M104 or M109 before it; printed as written"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::ConfigDir;
    use models::gcode::Header;
    use models::motion::Job;
    use std::path::Path;

    fn cold_of(text: &str) -> Cold {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../config"));
        let motion = ConfigDir::find(Some(folder)).unwrap().motion().unwrap();
        let mut cold = Cold::default();
        Job::new(text.as_bytes(), &Header::default(), &motion).for_each(|step| cold.note(&step));
        cold
    }

    #[test]
    fn the_first_road_without_heat_is_told() {
        let road = "M83\nG1 X10 E1 F1200\n";
        let cold = cold_of(road);
        assert!(cold.to_string().starts_with("line 2 lays a road while the hot end is off"), "{cold}");
        assert!(cold_of(&format!("M104 S210\nM104 S0\n{road}")).lays());
        assert!(cold_of(&format!("M104 S30\n{road}")).lays());
        assert!(cold_of(&format!("{road}M104 S210\n")).lays(), "too late");
        assert!(!cold_of(&format!("M104 S210\n{road}M104 S0\n")).lays());
        assert!(!cold_of(&format!("START_PRINT BED_TEMP=60 EXTRUDER_TEMP=210\n{road}")).lays());
        assert!(!cold_of("M83\nG1 X10 F1200\nG1 E5 F300\nM104 S210\nG1 X20 E1\n").lays(), "no road");
    }
}
