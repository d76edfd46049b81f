//! G, M and T commands.

use super::interpret::Interpreter;
use super::oddity::Oddity;
use crate::motion::Action;
use crate::units::Seconds;

impl Interpreter {
    pub(super) fn execute(&mut self, (letter, code, sub): (u8, u32, u32), text: &[u8]) {
        match letter {
            b'G' if sub != 0 => self.odd.push(Oddity::Unknown(format!("G{code}.{sub}"))),
            b'G' => self.execute_g(code, text),
            b'M' => self.execute_m(code),
            _ => self.act(Action::Tool(code)),
        }
    }

    fn execute_g(&mut self, code: u32, text: &[u8]) {
        match code {
            0 | 1 => self.straight(),
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
            20 => {
                self.note("inches from here on");
                self.modal.inches(true);
            }
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

    pub(super) fn note(&mut self, text: &'static str) {
        self.odd.push(Oddity::Note(text));
    }

    /// Whether one of the letters lacks its value; then the line is refused.
    pub(super) fn lacks_value(&mut self, letters: &[u8]) -> bool {
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
        self.out_of_range(field, value, format!("in [{low}, {high}]"))
    }

    /// A value of at least `low`, without an upper end, or nothing and a refusal; both in `unit`.
    pub(super) fn at_least(&mut self, field: u8, value: f64, low: f64, unit: &str) -> Option<f64> {
        if value.is_finite() && value >= low {
            return Some(value);
        }
        // Without the last bits that a change of unit leaves.
        self.out_of_range(field, value, format!("at least {} {unit}", (low * 1e9).round() / 1e9))
    }

    fn out_of_range(&mut self, field: u8, value: f64, rule: String) -> Option<f64> {
        self.odd.push(Oddity::OutOfRange { field: char::from(field), value, rule });
        None
    }
}
