//! G, M and T commands.

use super::arc::{bezier, centre_of_radius, chords};
use super::interpret::{Interpreter, LimitChange};
use super::modal::{MM, MM_MIN};
use super::oddity::Oddity;
use crate::motion::Action;
use crate::units::{Celsius, Seconds};

/// Where a move ends.
struct Target {
    end_mm: [f64; 3],
    filament_m: f64,
}

impl Interpreter {
    pub(super) fn execute(&mut self, letter: u8, code: u32, text: &[u8]) {
        match letter {
            b'G' => self.execute_g(code, text),
            b'M' => self.execute_m(code),
            _ => self.act(Action::Tool(code)),
        }
    }

    fn execute_g(&mut self, code: u32, text: &[u8]) {
        match code {
            0 | 1 => {
                if let Some(target) = self.target() {
                    self.go(target.end_mm, target.filament_m, false);
                }
            }
            2 | 3 => self.arc(code == 2),
            4 => self.dwell(),
            5 => self.spline(),
            10 if self.words.has(b'P') || self.words.has(b'L') || self.words.has(b'R') => {
                self.note("G10 with P, L or R sets tool offsets: skipped");
            }
            10 => self.firmware_retract(true),
            11 => self.firmware_retract(false),
            17 | 29 | 80 => {}
            18 | 19 => self.note("arcs outside of the XY plane are not modelled: skipped"),
            20 => self.modal.inches(true),
            21 => self.modal.inches(false),
            28 => self.home(),
            90 => self.modal.relative = false,
            91 => self.modal.relative = true,
            92 => self.set_position(text),
            _ => self.odd.push(Oddity::Unknown(format!("G{code}"))),
        }
    }

    fn execute_m(&mut self, code: u32) {
        match code {
            0 | 1 | 25 | 226 | 600 | 601 => self.act(Action::Pause),
            82 => self.modal.relative_e = false,
            83 => self.modal.relative_e = true,
            104 | 109 | 140 | 190 => self.temperature(code),
            106 => self.fan(),
            107 => self.act(Action::Fan(0.0)),
            112 => self.act(Action::Stop),
            201 | 203 | 205 => self.axis_limits(code),
            204 => self.path_accelerations(),
            207 | 208 => self.firmware_retraction(code),
            220 | 221 => self.factor(code),
            400 => self.act(Action::Dwell(Seconds(0.0))),
            572 | 900 => self.advance(),
            // reports, motors, displays, probes, meshes, stored settings: no motion of their own
            17
            | 18
            | 20
            | 21
            | 23
            | 27
            | 31
            | 73
            | 75..=78
            | 84
            | 85
            | 105
            | 108
            | 110
            | 111
            | 113..=119
            | 141
            | 155
            | 191
            | 211
            | 300
            | 301..=304
            | 355
            | 412
            | 413
            | 420
            | 486
            | 500..=504
            | 555
            | 569
            | 593
            | 603
            | 862
            | 906
            | 907
            | 913..=915 => {}
            _ => self.odd.push(Oddity::Unknown(format!("M{code}"))),
        }
    }

    fn note(&mut self, text: &'static str) {
        self.odd.push(Oddity::Note(text));
    }

    /// Whether one of the letters lacks its value; then the line is refused.
    fn lacks_value(&mut self, letters: &[u8]) -> bool {
        let bare = self.words.bare_of(letters);
        if let Some(letter) = bare {
            self.odd.push(Oddity::NoValue { letter: char::from(letter) });
        }
        bare.is_some()
    }

    /// A value inside `[low, high]` or nothing and a refusal.
    pub(super) fn within(&mut self, field: u8, value: f64, (low, high): (f64, f64)) -> Option<f64> {
        if value.is_finite() && (low..=high).contains(&value) {
            return Some(value);
        }
        let rule = format!("in [{low}, {high}]");
        self.odd.push(Oddity::OutOfRange { field: char::from(field), value, rule });
        None
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
            self.within(b'F', value, (self.read.feed_min_m_s / (unit_mm * MM_MIN), f64::MAX))?;
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

    fn arc(&mut self, clockwise: bool) {
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

    fn spline(&mut self) {
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

    fn firmware_retract(&mut self, back: bool) {
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

    fn home(&mut self) {
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

    fn set_position(&mut self, text: &[u8]) {
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

    fn dwell(&mut self) {
        if self.lacks_value(b"PS") {
            return;
        }
        let seconds = self.words.get(b'S').or(self.words.get(b'P').map(|ms| ms * 1e-3));
        if let Some(value_s) = seconds.and_then(|value| self.within(b'S', value, (0.0, f64::MAX))) {
            self.act(Action::Dwell(Seconds(value_s)));
        }
    }

    fn temperature(&mut self, code: u32) {
        if self.lacks_value(b"SR") {
            return;
        }
        let Some(value) = self.words.get(b'S').or(self.words.get(b'R')) else { return };
        let Some(target_c) = self.within(b'S', value, (0.0, self.read.target_max_c)) else { return };
        let (target, wait) = (Celsius(target_c), matches!(code, 109 | 190));
        self.act(if matches!(code, 104 | 109) {
            Action::HotendTarget { target, wait }
        } else {
            Action::BedTarget { target, wait }
        });
    }

    fn fan(&mut self) {
        if self.lacks_value(b"SP") {
            return;
        }
        if self.words.get(b'P').is_some_and(|index| index > 0.0) {
            self.note("a second fan is not modelled: skipped");
            return;
        }
        let full = 255.0; // M106 S counts in eight bits
        if let Some(value) = self.within(b'S', self.words.get(b'S').unwrap_or(full), (0.0, full)) {
            self.act(Action::Fan(value / full));
        }
    }

    fn axis_limits(&mut self, code: u32) {
        if self.lacks_value(b"XYZEJ") {
            return;
        }
        for (axis, letter) in (*b"XYZE").into_iter().enumerate() {
            let Some(value) = self.words.get(letter) else { continue };
            let Some(value) = self.limit_value(letter, value) else { continue };
            self.limit(match code {
                201 => LimitChange::Acceleration(axis, value),
                203 => LimitChange::Feedrate(axis, value),
                _ => LimitChange::Jerk(axis, value),
            });
        }
        if code == 205
            && let Some(value) = self.words.get(b'J')
            && let Some(value) = self.limit_value(b'J', value)
        {
            self.limit(LimitChange::JunctionDeviation(value));
        }
    }

    fn path_accelerations(&mut self) {
        if self.lacks_value(b"SPRT") {
            return;
        }
        for letter in *b"SPTR" {
            let Some(value) = self.words.get(letter) else { continue };
            let Some(value) = self.limit_value(letter, value) else { continue };
            match letter {
                b'S' => {
                    self.limit(LimitChange::Extruding(value));
                    self.limit(LimitChange::Travel(value));
                }
                b'P' => self.limit(LimitChange::Extruding(value)),
                b'T' => self.limit(LimitChange::Travel(value)),
                _ => self.limit(LimitChange::Retract(value)),
            }
        }
    }

    /// A limit in millimetres, in metres; zero and less is refused.
    fn limit_value(&mut self, letter: u8, value: f64) -> Option<f64> {
        // a nanometre stands for "above zero"
        self.within(letter, value, (1e-6, 1e9)).map(|value| value * MM)
    }

    fn firmware_retraction(&mut self, code: u32) {
        if self.lacks_value(b"SF") {
            return;
        }
        let limit_mm = self.read.filament_move_noted_m / MM;
        let length = self.words.get(b'S').and_then(|value| self.within(b'S', value, (0.0, limit_mm)));
        let speed = self.words.get(b'F').and_then(|value| self.within(b'F', value, (1e-3, 1e9)));
        let (length_m, speed_m_s) = (length.map(|mm| mm * MM), speed.map(|mm_min| mm_min * MM_MIN));
        if code == 207 {
            self.modal.retract_m = length_m.unwrap_or(self.modal.retract_m);
            self.modal.retract_m_s = speed_m_s.unwrap_or(self.modal.retract_m_s);
        } else {
            self.modal.unretract_extra_m = length_m.unwrap_or(self.modal.unretract_extra_m);
            self.modal.unretract_m_s = speed_m_s.unwrap_or(self.modal.unretract_m_s);
        }
    }

    fn factor(&mut self, code: u32) {
        if self.lacks_value(b"S") {
            return;
        }
        let Some(percent) = self.words.get(b'S') else { return };
        let Some(percent) = self.within(b'S', percent, (1.0, 999.0)) else { return };
        let factor = percent * 1e-2;
        self.act(if code == 220 { Action::SpeedFactor(factor) } else { Action::FlowFactor(factor) });
    }

    fn advance(&mut self) {
        if self.lacks_value(b"KS") {
            return;
        }
        let Some(value) = self.words.get(b'K').or(self.words.get(b'S')) else { return };
        // Marlin's K up to 10 s; larger ones are the unitless K of the first linear advance
        if let Some(value_s) = self.within(b'K', value, (0.0, 10.0)) {
            self.act(Action::Advance(Seconds(value_s)));
        }
    }
}
