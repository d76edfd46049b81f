//! What goes into the brain and what comes out.

use crate::asking::Question;
use crate::note::Note;
use models::status::PrinterStatus;
use models::units::{Celsius, Seconds};

/// What happens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event<'a> {
    /// The line is open.
    Connected,
    /// The line was lost, or cannot be opened.
    Lost(&'a str),
    /// A line without its end.
    Line(&'a [u8]),
    /// A line that is too long for one.
    Overlong,
    /// Time passes.
    Tick,
}

/// What comes of it.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// To be sent.
    Ask(Question),
    /// A temperature report.
    Temperatures(Report),
    /// State of printer and job.
    State(Box<PrinterStatus>),
    /// For the log.
    Note(Note),
}

/// Temperatures as the firmware reports them, whatever they are; `None` for a sensor that it does not name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// When the line was complete.
    pub stamp: Seconds,
    /// Hot end.
    pub hotend: Option<Celsius>,
    /// Bed.
    pub bed: Option<Celsius>,
}

/// The serial line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Link {
    /// Not open.
    #[default]
    Down,
    /// Open, and nothing has been heard for longer than allowed, or yet.
    Silent,
    /// Lines come.
    Alive,
    /// The firmware has stopped itself; it has to be started anew.
    Halted,
}

/// Lines that were refused and values that were not taken, since the bridge's start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Refusals {
    /// No text, or a number that is none.
    pub malformed: u64,
    /// Too long.
    pub overlong: u64,
    /// A set-point, duty or coordinate that is not finite.
    pub not_finite: u64,
    /// A set-point, duty or coordinate out of its range; a capability too many.
    pub out_of_range: u64,
}
