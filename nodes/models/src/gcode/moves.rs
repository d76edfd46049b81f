//! Commands that move: lines, arcs, splines, firmware retraction, homing, and setting the position.

use super::arc::{bezier, centre_of_radius, chords};
use super::interpret::Interpreter;
use super::modal::{MM, MM_MIN};
use super::oddity::Oddity;
use crate::motion::Action;

/// Where a move ends.
struct Target {
    end_mm: [f64; 3],
    filament_m: f64,
}

impl Interpreter {
    pub(super) fn straight(&mut self) {
        if let Some(target) = self.target() {
            self.go(target.end_mm, target.filament_m, false);
        }
    }

    /// Reads X, Y, Z, E and F; `None` where the line is refused.
    fn target(&mut self) -> Option<Target> {
        if self.lacks_value(b"XYZEF") {
            return None;
        }
        let unit_mm = self.modal.unit_mm;
        let mut end_mm = self.modal.machine_mm;
        let limit_mm = self.read.coordinate_max_m / MM;
        for (axis, letter) in (*b"XYZ").into_iter().enumerate() {
            let Some(value) = self.words.get(letter) else { continue };
            let from_mm = if self.modal.relative { end_mm[axis] } else { self.modal.offset_mm[axis] };
            end_mm[axis] = self.within(letter, from_mm + value * unit_mm, (-limit_mm, limit_mm))?;
        }
        let (filament_mm, e_mm) = self.filament(unit_mm)?;
        if let Some(value) = self.words.get(b'F') {
            let feed_m_s = value * unit_mm * MM_MIN;
            // the upper end is the printer's own limit: the planner's business
            let unit = if unit_mm > 1.0 { "in/min" } else { "mm/min" };
            self.at_least(b'F', value, self.read.feed_min_m_s / (unit_mm * MM_MIN), unit)?;
            self.modal.feed_m_s = feed_m_s;
        }
        self.modal.e_mm = e_mm;
        Some(Target { end_mm, filament_m: filament_mm * MM })
    }

    fn filament(&mut self, unit_mm: f64) -> Option<(f64, f64)> {
        let Some(value) = self.words.get(b'E') else { return Some((0.0, self.modal.e_mm)) };
        let value_mm = value * unit_mm;
        let limit_mm = self.read.filament_max_m / MM;
        self.within(b'E', value_mm, (-limit_mm, limit_mm))?;
        if value_mm.abs() * MM > self.read.filament_noted_m {
            self.note("E is so large that firmware with 32-bit numbers loses resolution");
        }
        let moved_mm =
            if self.modal.relative || self.modal.relative_e { value_mm } else { value_mm - self.modal.e_mm };
        if moved_mm.abs() * MM > self.read.filament_move_noted_m {
            self.note("one move of implausibly much filament: executed as written");
        }
        Some((moved_mm, self.modal.e_mm + moved_mm))
    }

    pub(super) fn arc(&mut self, clockwise: bool) {
        if self.lacks_value(b"IJR") {
            return;
        }
        let [x, y, z] = self.modal.machine_mm;
        let feed_m_s = self.modal.feed_m_s;
        let e_mm = self.modal.e_mm;
        let Some(target) = self.target() else { return };
        let end = [target.end_mm[0], target.end_mm[1]];
        let unit_mm = self.modal.unit_mm;
        let (i, j, radius) = (self.words.get(b'I'), self.words.get(b'J'), self.words.get(b'R'));
        let centre = match radius {
            Some(radius) => centre_of_radius([x, y], end, radius * unit_mm, clockwise),
            None if i.is_some() || j.is_some() => {
                Some([x + i.unwrap_or(0.0) * unit_mm, y + j.unwrap_or(0.0) * unit_mm])
            }
            None => None,
        };
        let limit_mm = self.read.coordinate_max_m / MM;
        let centre = centre.filter(|centre| {
            let radius_mm = (centre[0] - x).hypot(centre[1] - y);
            radius_mm > 0.0 && radius_mm <= limit_mm
        });
        let Some(centre) = centre else {
            self.modal.feed_m_s = feed_m_s;
            self.modal.e_mm = e_mm;
            self.odd.push(Oddity::Arc("no circle goes through both ends, or its radius is out of range"));
            return;
        };
        if self.words.has(b'P') {
            self.note("further turns of an arc (P) are not modelled: skipped");
        }
        let tolerance_mm = self.read.chord_tolerance_m / MM;
        let mut done = 0.0;
        for (share, point) in chords([x, y], end, centre, clockwise, tolerance_mm) {
            let height = z + (target.end_mm[2] - z) * share;
            let height = if share >= 1.0 { target.end_mm[2] } else { height };
            self.go([point[0], point[1], height], target.filament_m * (share - done), true);
            done = share;
        }
    }

    pub(super) fn spline(&mut self) {
        if self.lacks_value(b"IJPQ") {
            return;
        }
        let [Some(i), Some(j), Some(p), Some(q)] =
            [b'I', b'J', b'P', b'Q'].map(|letter| self.words.get(letter))
        else {
            self.odd.push(Oddity::Arc("a spline needs I, J, P and Q"));
            return;
        };
        let [x, y, z] = self.modal.machine_mm;
        let Some(target) = self.target() else { return };
        let unit_mm = self.modal.unit_mm;
        let limit_mm = self.read.coordinate_max_m / MM;
        for (letter, value) in [(b'I', i), (b'J', j), (b'P', p), (b'Q', q)] {
            if self.within(letter, value * unit_mm, (-limit_mm, limit_mm)).is_none() {
                return;
            }
        }
        let [end_x, end_y, end_z] = target.end_mm;
        let control = [
            [x, y],
            [x + i * unit_mm, y + j * unit_mm],
            [end_x + p * unit_mm, end_y + q * unit_mm],
            [end_x, end_y],
        ];
        let tolerance_mm = self.read.chord_tolerance_m / MM;
        let way = |from: [f64; 2], to: [f64; 2]| (to[0] - from[0]).hypot(to[1] - from[1]);
        let (_, total_mm) =
            bezier(control, tolerance_mm).fold(([x, y], 0.0), |(from, sum), to| (to, sum + way(from, to)));
        let mut from = [x, y];
        let mut done_mm = 0.0;
        for point in bezier(control, tolerance_mm) {
            let step_mm = way(from, point);
            let share = if total_mm > 0.0 { step_mm / total_mm } else { 1.0 };
            done_mm += step_mm;
            let height = if total_mm > 0.0 { z + (end_z - z) * done_mm / total_mm } else { end_z };
            self.go([point[0], point[1], height], target.filament_m * share, true);
            from = point;
        }
    }

    pub(super) fn firmware_retract(&mut self, back: bool) {
        if back == self.modal.retracted {
            self.note("firmware retraction twice in a row: skipped");
            return;
        }
        self.modal.retracted = back;
        let (filament_m, speed_m_s) = if back {
            (-self.modal.retract_m, self.modal.retract_m_s)
        } else {
            (self.modal.retract_m + self.modal.unretract_extra_m, self.modal.unretract_m_s)
        };
        let feed_m_s = std::mem::replace(&mut self.modal.feed_m_s, speed_m_s);
        self.go(self.modal.machine_mm, filament_m, false);
        self.modal.feed_m_s = feed_m_s;
    }

    pub(super) fn home(&mut self) {
        let named = (*b"XYZ").map(|letter| self.words.has(letter));
        let axes = if named.contains(&true) { named } else { [true; 3] };
        for (axis, homed) in axes.into_iter().enumerate() {
            if homed {
                self.modal.machine_mm[axis] = 0.0;
                self.modal.offset_mm[axis] = 0.0;
            }
        }
        self.act(Action::Home(axes));
    }

    pub(super) fn set_position(&mut self, text: &[u8]) {
        if self.lacks_value(b"XYZE") {
            return;
        }
        let bare = text.trim_ascii().is_empty() || text.trim_ascii().starts_with(b";");
        if bare {
            self.note("G92 without axes: all axes read zero here");
        }
        let value = |words: &super::Words, letter| words.get(letter).or(bare.then_some(0.0));
        let limit_mm = self.read.coordinate_max_m / MM;
        for (axis, letter) in (*b"XYZ").into_iter().enumerate() {
            let Some(here) = value(&self.words, letter) else { continue };
            let Some(here_mm) = self.within(letter, here * self.modal.unit_mm, (-limit_mm, limit_mm)) else {
                return;
            };
            self.modal.offset_mm[axis] = self.modal.machine_mm[axis] - here_mm;
        }
        if let Some(e) = value(&self.words, b'E') {
            let limit_mm = self.read.filament_max_m / MM;
            let e_mm = self.within(b'E', e * self.modal.unit_mm, (-limit_mm, limit_mm));
            self.modal.e_mm = e_mm.unwrap_or(self.modal.e_mm);
            if self.modal.e_mm.abs() * MM > self.read.filament_noted_m {
                self.note("E is so large that firmware with 32-bit numbers loses resolution");
            }
        }
    }
}
