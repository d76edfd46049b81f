//! Klipper commands and the usual start and end macros.
//!
//! Assumption, named in the warnings: `START_PRINT` and its kin home all axes, heat bed and hot end to the given
//! temperatures and wait; `END_PRINT` and its kin switch heaters and fan off. What else a macro does is its owner's
//! secret.

use super::interpret::{Interpreter, LimitChange};
use super::lex::shown;
use super::modal::MM;
use super::number::number;
use super::oddity::Oddity;
use crate::motion::Action;
use crate::units::{Celsius, Seconds};

impl Interpreter {
    pub(super) fn run_macro(&mut self, name: &[u8], text: &[u8]) {
        match name.to_ascii_uppercase().as_slice() {
            b"START_PRINT" | b"PRINT_START" => self.start_print(text),
            b"END_PRINT" | b"PRINT_END" => {
                self.odd.push(Oddity::Note("end macro taken as heaters and fan off"));
                self.heaters_off();
                self.act(Action::Fan(0.0));
            }
            b"TURN_OFF_HEATERS" => self.heaters_off(),
            b"PAUSE" => self.act(Action::Pause),
            b"SET_PRESSURE_ADVANCE" => {
                if argument_text(text, b"ADVANCE").is_none() {
                    self.note("pressure advance without a value: nothing changes");
                }
                if let Some(value_s) = self.argument(text, b"ADVANCE", (0.0, 10.0)) {
                    self.act(Action::Advance(Seconds(value_s)));
                }
            }
            b"SET_RETRACTION" => self.set_retraction(text),
            b"SET_VELOCITY_LIMIT" => self.set_velocity_limit(text),
            b"SET_HEATER_TEMPERATURE" | b"TEMPERATURE_WAIT" => self.set_heater(name, text),
            b"EXCLUDE_OBJECT"
            | b"EXCLUDE_OBJECT_DEFINE"
            | b"EXCLUDE_OBJECT_START"
            | b"EXCLUDE_OBJECT_END"
            | b"SET_PRINT_STATS_INFO"
            | b"SET_DISPLAY_TEXT"
            | b"RESPOND"
            | b"STATUS_READY"
            | b"BED_MESH_PROFILE"
            | b"BED_MESH_CALIBRATE"
            | b"TIMELAPSE_TAKE_FRAME"
            | b"CLEAR_PAUSE" => {}
            _ => self.odd.push(Oddity::Unknown(format!("macro {}", shown(name)))),
        }
    }

    fn start_print(&mut self, text: &[u8]) {
        self.odd.push(Oddity::Note("start macro taken as: home, heat bed and hot end as stated, wait"));
        self.modal.machine_mm = [0.0; 3];
        self.modal.offset_mm = [0.0; 3];
        self.act(Action::Home([true; 3]));
        let range = (0.0, self.read.target_max_c);
        let bed = self.first_argument(text, &[b"BED_TEMP", b"BED", b"BED_TEMPERATURE"], range);
        let hotend = self.first_argument(
            text,
            &[b"EXTRUDER_TEMP", b"EXTRUDER", b"HOTEND_TEMP", b"HOTEND", b"NOZZLE_TEMP", b"TOOL_TEMP"],
            range,
        );
        if let Some(bed_c) = bed {
            self.act(Action::BedTarget { target: Celsius(bed_c), wait: true });
        }
        if let Some(hotend_c) = hotend {
            self.act(Action::HotendTarget { target: Celsius(hotend_c), wait: true });
        }
    }

    fn heaters_off(&mut self) {
        self.act(Action::HotendTarget { target: Celsius(0.0), wait: false });
        self.act(Action::BedTarget { target: Celsius(0.0), wait: false });
    }

    fn set_retraction(&mut self, text: &[u8]) {
        let range = (0.0, self.read.filament_move_noted_m / MM);
        if let Some(mm) = self.argument(text, b"RETRACT_LENGTH", range) {
            self.modal.retract_m = mm * MM;
        }
        if let Some(mm) = self.argument(text, b"UNRETRACT_EXTRA_LENGTH", range) {
            self.modal.unretract_extra_m = mm * MM;
        }
        if let Some(mm_s) = self.argument(text, b"RETRACT_SPEED", (1e-3, 1e6)) {
            self.modal.retract_m_s = mm_s * MM;
            self.modal.unretract_m_s = mm_s * MM;
        }
        if let Some(mm_s) = self.argument(text, b"UNRETRACT_SPEED", (1e-3, 1e6)) {
            self.modal.unretract_m_s = mm_s * MM;
        }
    }

    fn set_velocity_limit(&mut self, text: &[u8]) {
        let range = (1e-3, 1e6);
        if let Some(mm_s) = self.argument(text, b"VELOCITY", range) {
            self.limit(LimitChange::Feedrate(0, mm_s * MM));
            self.limit(LimitChange::Feedrate(1, mm_s * MM));
        }
        if let Some(mm_s2) = self.argument(text, b"ACCEL", range) {
            self.limit(LimitChange::Extruding(mm_s2 * MM));
            self.limit(LimitChange::Travel(mm_s2 * MM));
        }
        if let Some(mm_s) = self.argument(text, b"SQUARE_CORNER_VELOCITY", range) {
            self.limit(LimitChange::SquareCorner(mm_s * MM));
        }
    }

    fn set_heater(&mut self, name: &[u8], text: &[u8]) {
        let wait = name.eq_ignore_ascii_case(b"TEMPERATURE_WAIT");
        let range = (0.0, self.read.target_max_c);
        let key: &[u8] = if wait { b"MINIMUM" } else { b"TARGET" };
        let heater = argument_text(text, if wait { b"SENSOR" } else { b"HEATER" }).unwrap_or_default();
        let Some(target_c) = self.argument(text, key, range) else { return };
        let target = Celsius(target_c);
        if heater.eq_ignore_ascii_case(b"heater_bed") {
            self.act(Action::BedTarget { target, wait });
        } else if heater.eq_ignore_ascii_case(b"extruder") {
            self.act(Action::HotendTarget { target, wait });
        } else {
            self.odd.push(Oddity::Unknown(format!("heater {}", shown(heater))));
        }
    }

    fn first_argument(&mut self, text: &[u8], keys: &[&[u8]], range: (f64, f64)) -> Option<f64> {
        let key = keys.iter().find(|key| argument_text(text, key).is_some())?;
        self.argument(text, key, range)
    }

    /// Value of `KEY=number`; a value that is none or out of range is refused.
    fn argument(&mut self, text: &[u8], key: &[u8], range: (f64, f64)) -> Option<f64> {
        let value = argument_text(text, key)?;
        match number(value) {
            Some((number, length)) if length == value.len() => self.within(key[0], number, range),
            _ => {
                self.odd.push(Oddity::NotANumber { letter: char::from(key[0]), text: shown(value) });
                None
            }
        }
    }
}

/// Text of `KEY=text`, up to the next blank.
fn argument_text<'a>(text: &'a [u8], key: &[u8]) -> Option<&'a [u8]> {
    let code = text.split(|byte| *byte == b';').next()?;
    code.split(|byte| byte.is_ascii_whitespace()).find_map(|word| {
        let equals = word.iter().position(|byte| *byte == b'=')?;
        word[..equals].eq_ignore_ascii_case(key).then_some(&word[equals + 1..])
    })
}
