//! Modal interpreter: one line in, instructions in SI out.

use super::lex::{Head, lex};
use super::modal::{MM, Modal};
use super::oddity::{Oddities, Oddity};
use super::read::RawLine;
use super::words::Words;
use super::{Header, comment};
use crate::motion::{Action, Cornering, Limits, MoveKind, ReadParams, Waypoint};
use std::f64::consts::PI;

/// Change of one limit in force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LimitChange {
    /// `M203`: speed of an axis `[m/s]`.
    Feedrate(usize, f64),
    /// `M201`: acceleration of an axis `[m/s2]`.
    Acceleration(usize, f64),
    /// `M205`: jerk of an axis `[m/s]`; classic jerk from then on.
    Jerk(usize, f64),
    /// `M204 P` `[m/s2]`.
    Extruding(f64),
    /// `M204 T` `[m/s2]`.
    Travel(f64),
    /// `M204 R` `[m/s2]`.
    Retract(f64),
    /// `M205 J` `[m]`; junction deviation from then on.
    JunctionDeviation(f64),
    /// `SET_VELOCITY_LIMIT SQUARE_CORNER_VELOCITY` `[m/s]`: `d = v^2 (sqrt(2) - 1)/a`, the speed through 90 degrees.
    SquareCorner(f64),
}

impl LimitChange {
    /// Puts the change into force.
    pub fn apply(self, limits: &mut Limits) {
        match self {
            Self::Feedrate(axis, value) => limits.feedrate_m_s[axis] = value,
            Self::Acceleration(axis, value) => limits.acceleration_m_s2[axis] = value,
            Self::Jerk(axis, value) => {
                limits.jerk_m_s[axis] = value;
                limits.cornering = Cornering::ClassicJerk;
            }
            Self::Extruding(value) => limits.extruding_m_s2 = value,
            Self::Travel(value) => limits.travel_m_s2 = value,
            Self::Retract(value) => limits.retract_m_s2 = value,
            Self::JunctionDeviation(value) => {
                limits.junction_deviation_m = value;
                limits.cornering = Cornering::JunctionDeviation;
            }
            Self::SquareCorner(speed) => {
                limits.junction_deviation_m = speed * speed * (2.0_f64.sqrt() - 1.0) / limits.extruding_m_s2;
                limits.cornering = Cornering::JunctionDeviation;
            }
        }
    }
}

/// What a line makes the machine do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Instruction {
    /// A straight move (arcs and splines come as chords).
    Move(Waypoint),
    /// An action and its line.
    Action(Action, u64),
    /// A limit for the moves that follow.
    Limit(LimitChange),
}

/// Interpreter of one file.
pub struct Interpreter {
    pub(super) read: ReadParams,
    pub(super) modal: Modal,
    pub(super) odd: Oddities,
    pub(super) words: Words,
    pub(super) line: u64,
    pub(super) out: Vec<Instruction>,
}

impl Interpreter {
    /// Starts at home, absolute, in millimetres.
    #[must_use]
    pub fn new(read: ReadParams, header: &Header) -> Self {
        let mut modal = Modal::new(&read);
        modal.marked = header.marks_layers;
        if let Some(diameter_m) = header.filament_diameter_m {
            modal.filament_diameter_m = diameter_m;
        }
        let odd = Oddities::new(read.warnings_max);
        Self { read, modal, odd, words: Words::default(), line: 0, out: Vec::new() }
    }

    /// What was odd so far.
    #[must_use]
    pub fn oddities(&self) -> &Oddities {
        &self.odd
    }

    /// Instructions since the last call.
    pub fn take(&mut self) -> std::vec::Drain<'_, Instruction> {
        self.out.drain(..)
    }

    /// Interprets one line of the file.
    pub fn line(&mut self, raw: RawLine<'_>) {
        self.line = raw.line;
        self.odd.at_line(raw.line);
        let mut bytes = raw.bytes;
        if !raw.ended {
            self.odd.push(Oddity::NoLineEnd);
        }
        if raw.line == 1
            && let Some(rest) = bytes.strip_prefix(b"\xef\xbb\xbf")
        {
            self.odd.push(Oddity::ByteOrderMark);
            bytes = rest;
        }
        if raw.cut {
            self.odd.push(Oddity::LongLine { limit: self.read.line_bytes_max });
            if !bytes.trim_ascii_start().starts_with(b";") {
                return;
            }
        }
        if bytes.contains(&b'\r') {
            self.odd.push(Oddity::LoneCarriageReturn);
            for part in bytes.split(|byte| *byte == b'\r') {
                self.part(part);
            }
        } else {
            self.part(bytes);
        }
    }

    fn part(&mut self, bytes: &[u8]) {
        let lexed = lex(bytes, &mut self.words, &mut self.odd);
        match lexed.head {
            Head::None => {}
            Head::Code(letter, code, sub) => {
                let comment_bytes = lexed.comment.map_or(0, |text| text.len() + 1);
                if bytes.len() - comment_bytes > self.read.command_bytes_noted {
                    self.odd.push(Oddity::LongCommand { limit: self.read.command_bytes_noted });
                }
                self.execute((letter, code, sub), lexed.text);
            }
            Head::Macro(name) => self.run_macro(name, lexed.text),
        }
        if let Some(text) = lexed.comment {
            if !text.is_ascii() && std::str::from_utf8(text).is_err() {
                self.odd.push(Oddity::CommentNotUtf8);
            }
            comment::read(text, &mut self.modal, &mut self.odd);
        }
    }

    pub(super) fn act(&mut self, action: Action) {
        self.out.push(Instruction::Action(action, self.line));
    }

    pub(super) fn limit(&mut self, change: LimitChange) {
        self.out.push(Instruction::Limit(change));
    }

    /// Emits a straight move to a machine position and advances the state.
    pub(super) fn go(&mut self, end_mm: [f64; 3], filament_m: f64, arc: bool) {
        let start_mm = std::mem::replace(&mut self.modal.machine_mm, end_mm);
        let in_layer = (0..2).any(|axis| (end_mm[axis] - start_mm[axis]).abs() > 0.0);
        let tool_moves = in_layer || (end_mm[2] - start_mm[2]).abs() > 0.0;
        if !tool_moves && filament_m.abs() <= 0.0 {
            return;
        }
        let kind = match (tool_moves, filament_m) {
            (_, e) if e > 0.0 => {
                if in_layer {
                    MoveKind::Deposit
                } else {
                    MoveKind::Prime
                }
            }
            (true, e) if e < 0.0 => MoveKind::Wipe,
            (false, _) => MoveKind::Retract,
            (true, _) => MoveKind::Travel,
        };
        let length_mm = (0..3).map(|axis| (end_mm[axis] - start_mm[axis]).powi(2)).sum::<f64>().sqrt();
        let deposits = kind == MoveKind::Deposit;
        let level = (end_mm[2] - start_mm[2]).abs() <= 0.0;
        self.begin_layer(deposits && level, end_mm[2] * MM);
        let layer_height_m =
            if deposits { self.modal.height_m.or(self.modal.levels.height_m()) } else { None };
        self.out.push(Instruction::Move(Waypoint {
            line: self.line,
            layer: self.modal.layer,
            start_m: start_mm.map(|mm| mm * MM),
            end_m: end_mm.map(|mm| mm * MM),
            filament_m,
            feed_m_s: self.modal.feed_m_s,
            kind,
            role: self.modal.role,
            arc,
            target_width_m: layer_height_m.map(|height_m| {
                stadium_width_m(filament_m / (length_mm * MM), self.modal.filament_diameter_m, height_m)
            }),
            stated_width_m: if deposits { self.modal.width_m } else { None },
            layer_height_m,
        }));
    }

    fn begin_layer(&mut self, deposits: bool, z_m: f64) {
        let new_level = deposits && self.modal.levels.extrude_at(z_m);
        if new_level && !self.modal.marked {
            self.modal.layer = Some(self.modal.layer.map_or(0, |layer| layer.saturating_add(1)));
            self.modal.layer_z_m = Some(z_m);
            self.modal.layer_pending = true;
        }
        if self.modal.layer_pending
            && let Some(layer) = self.modal.layer
        {
            self.modal.layer_pending = false;
            self.act(Action::LayerChange { layer, z_m: self.modal.layer_z_m });
        }
    }
}

/// Width of the stadium `A = h(w - h) + pi h^2/4` that holds the commanded volume per length `[m]`.
fn stadium_width_m(filament_per_path: f64, filament_diameter_m: f64, height_m: f64) -> f64 {
    let section_m2 = filament_per_path * 0.25 * PI * filament_diameter_m * filament_diameter_m;
    section_m2 / height_m + height_m * (1.0 - 0.25 * PI)
}
