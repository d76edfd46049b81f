//! Commands that set: temperatures, fan, limits, factors, advance.

use super::interpret::{Interpreter, LimitChange};
use super::modal::{MM, MM_MIN};
use super::oddity::Oddity;
use crate::motion::Action;
use crate::units::{Celsius, Seconds};

/// A longer dwell is told: milliseconds given as seconds, say `[s]`.
const LONG_DWELL_S: f64 = 3600.0;

impl Interpreter {
    pub(super) fn dwell(&mut self) {
        if self.lacks_value(b"PS") {
            return;
        }
        let seconds = self.words.get(b'S').or(self.words.get(b'P').map(|ms| ms * 1e-3));
        if let Some(value_s) = seconds.and_then(|value| self.at_least(b'S', value, 0.0, "s")) {
            if value_s > LONG_DWELL_S {
                self.odd.push(Oddity::LongDwell { time_s: value_s });
            }
            self.act(Action::Dwell(Seconds(value_s)));
        }
    }

    pub(super) fn temperature(&mut self, code: u32) {
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

    pub(super) fn fan(&mut self) {
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

    pub(super) fn axis_limits(&mut self, code: u32) {
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

    pub(super) fn path_accelerations(&mut self) {
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

    pub(super) fn firmware_retraction(&mut self, code: u32) {
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

    pub(super) fn factor(&mut self, code: u32) {
        if self.lacks_value(b"S") {
            return;
        }
        let Some(percent) = self.words.get(b'S') else { return };
        let Some(percent) = self.within(b'S', percent, (1.0, 999.0)) else { return };
        let factor = percent * 1e-2;
        self.act(if code == 220 { Action::SpeedFactor(factor) } else { Action::FlowFactor(factor) });
    }

    pub(super) fn advance(&mut self) {
        if self.lacks_value(b"KS") {
            return;
        }
        let letter = if self.words.has(b'K') { b'K' } else { b'S' };
        let Some(value) = self.words.get(letter) else {
            return self.note("pressure advance without a value: nothing changes");
        };
        // Marlin's K up to 10 s; larger ones are the unitless K of the first linear advance
        if let Some(value_s) = self.within(letter, value, (0.0, 10.0)) {
            self.act(Action::Advance(Seconds(value_s)));
        }
    }
}
