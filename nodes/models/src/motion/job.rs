//! A file as an iterator of timed steps.

use super::params::MotionParams;
use super::planner::Planner;
use super::segment::{Action, MoveKind, Segment, Step};
use crate::gcode::{Header, Instruction, Interpreter, LineReader, Oddities, Warning};
use crate::units::Seconds;
use std::io::BufRead;

/// Sums over the steps yielded so far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Totals {
    /// Lines read.
    pub lines: u64,
    /// Moves.
    pub moves: u64,
    /// Arcs and splines.
    pub arcs: u64,
    /// Layers begun.
    pub layers: u32,
    /// Net filament `[m]`.
    pub filament_m: f64,
    /// Moves and dwells.
    pub time: Seconds,
    /// Tool way without filament `[m]`.
    pub travel_m: f64,
    /// Tool way of laid roads `[m]`.
    pub deposit_m: f64,
}

/// A print job: reads, interprets and plans lazily; memory is bounded by look-ahead and line length.
///
/// Ends with [`Action::End`], once.
pub struct Job<R> {
    reader: LineReader<R>,
    interpreter: Interpreter,
    planner: Planner,
    totals: Totals,
    arc_line: u64,
    ended: bool,
    failure: Option<Warning>,
}

impl<'a> Job<&'a [u8]> {
    /// A job over a whole file in memory.
    #[must_use]
    pub fn from_bytes(bytes: &'a [u8], params: &MotionParams) -> Self {
        let end_bytes = params.read.header_bytes.min(bytes.len());
        let header = Header::scan(&bytes[..end_bytes], &bytes[bytes.len() - end_bytes..]);
        Self::new(bytes, &header, params)
    }
}

impl<R: BufRead> Job<R> {
    /// A job over a stream whose comments were scanned before.
    pub fn new(source: R, header: &Header, params: &MotionParams) -> Self {
        Self {
            reader: LineReader::new(source, params.read.line_bytes_max),
            interpreter: Interpreter::new(params.read, header),
            planner: planner(header, params),
            totals: Totals::default(),
            arc_line: 0,
            ended: false,
            failure: None,
        }
    }

    /// Sums over the steps yielded so far.
    #[must_use]
    pub fn totals(&self) -> &Totals {
        &self.totals
    }

    /// What was odd so far, by line.
    #[must_use]
    pub fn oddities(&self) -> &Oddities {
        self.interpreter.oddities()
    }

    /// Why reading stopped before the end of the file.
    #[must_use]
    pub fn failure(&self) -> Option<&Warning> {
        self.failure.as_ref()
    }

    /// Reads one line into the planner; false at the end.
    fn feed(&mut self) -> bool {
        match self.reader.next_line() {
            Ok(Some(raw)) => {
                self.totals.lines = raw.line;
                self.interpreter.line(raw);
                for instruction in self.interpreter.take() {
                    match instruction {
                        Instruction::Move(waypoint) => self.planner.push_move(waypoint),
                        Instruction::Action(action, line) => self.planner.push_action(action, line),
                        Instruction::Limit(change) => change.apply(self.planner.limits_mut()),
                    }
                }
                true
            }
            Ok(None) => false,
            Err(error) => {
                self.failure = Some(Warning { line: self.totals.lines, reason: error.to_string() });
                false
            }
        }
    }

    fn count(&mut self, step: &Step) {
        match step {
            Step::Move(segment) => self.count_move(segment),
            Step::Action(Action::Dwell(pause), _) => self.totals.time = self.totals.time + *pause,
            Step::Action(Action::LayerChange { .. }, _) => self.totals.layers += 1,
            Step::Action(..) => {}
        }
    }

    fn count_move(&mut self, segment: &Segment) {
        let totals = &mut self.totals;
        totals.moves += 1;
        if segment.arc && segment.line != self.arc_line {
            self.arc_line = segment.line;
            totals.arcs += 1;
        }
        totals.filament_m += segment.filament_m;
        totals.time = totals.time + segment.profile.duration();
        match segment.kind {
            MoveKind::Deposit => totals.deposit_m += segment.length_m,
            MoveKind::Travel => totals.travel_m += segment.length_m,
            MoveKind::Retract | MoveKind::Prime | MoveKind::Wipe => {}
        }
    }
}

impl<R: BufRead> Iterator for Job<R> {
    type Item = Step;

    fn next(&mut self) -> Option<Step> {
        loop {
            if let Some(step) = self.planner.pop() {
                self.count(&step);
                return Some(step);
            }
            if self.ended {
                return None;
            }
            if !self.feed() {
                self.ended = true;
                self.planner.push_action(Action::End, self.totals.lines);
            }
        }
    }
}

fn planner(header: &Header, params: &MotionParams) -> Planner {
    let planner = Planner::new(header.limits(params.limits), params.lookahead_moves);
    if params.starved { planner.starved() } else { planner }
}
