//! The brain: lines of Marlin and the time in; temperatures, state, questions and notes out.

mod seen;
#[cfg(test)]
mod tests;

use crate::asking::{Asking, Question};
use crate::event::{Event, Link, Output, Refusals, Report};
use crate::firmware::Firmware;
use crate::job::Job;
use crate::line::{Action, Line, LineError, Says, Temperatures, parse};
use crate::note::{Note, Sensor};
use crate::params::MarlinParams;
use models::units::Seconds;
use seen::Seen;

/// Reads one Marlin, over all its connections.
#[derive(Debug, Clone)]
pub struct Marlin {
    params: MarlinParams,
    link: Link,
    /// Last line, or the connection.
    heard: Seconds,
    /// The loss or silence that lasts has been told.
    told: bool,
    asking: Asking,
    firmware: Firmware,
    firmware_told: bool,
    sensors_told: bool,
    job: Job,
    seen: Seen,
    refusals: Refusals,
    state_sent: Option<Seconds>,
    error_noted: Option<Seconds>,
    resend_noted: Option<Seconds>,
}

impl Marlin {
    /// Not connected.
    #[must_use]
    pub fn new(params: MarlinParams) -> Self {
        Self {
            params,
            link: Link::Down,
            heard: Seconds(0.0),
            told: false,
            asking: Asking::new(Seconds(0.0), 0),
            firmware: Firmware::default(),
            firmware_told: false,
            sensors_told: false,
            job: Job::default(),
            seen: Seen::default(),
            refusals: Refusals::default(),
            state_sent: None,
            error_noted: None,
            resend_noted: None,
        }
    }

    /// How the line is.
    #[must_use]
    pub fn link(&self) -> Link {
        self.link
    }

    /// The firmware, as far as it has told.
    #[must_use]
    pub fn firmware(&self) -> &Firmware {
        &self.firmware
    }

    /// The job, as far as it is told.
    #[must_use]
    pub fn job(&self) -> &Job {
        &self.job
    }

    /// What was refused.
    #[must_use]
    pub fn refusals(&self) -> Refusals {
        self.refusals
    }

    /// Questions that were given up.
    #[must_use]
    pub fn unanswered(&self) -> u64 {
        self.asking.unanswered
    }

    /// Age of the position `[s]`; `None` before it was told.
    #[must_use]
    pub fn position_age_s(&self, now: Seconds) -> Option<f64> {
        self.seen.position.map(|(told, _)| (now - told).0)
    }

    /// Takes one event in.
    pub fn on_event(&mut self, now: Seconds, event: Event<'_>) -> Vec<Output> {
        let mut outputs = Vec::new();
        let before = self.job.phase();
        match event {
            Event::Connected => {
                self.begin(now, now + Seconds(self.params.greeting_s));
                // The job stays: where opening the line has restarted the board, `start` tells that it is lost.
                self.seen = Seen::default();
                (self.link, self.told) = (Link::Silent, false);
                outputs.push(Output::Note(Note::Connected));
            }
            Event::Lost(reason) => {
                // The log has the first of the tries that fail; the shell has all.
                if self.link != Link::Down || !self.told {
                    outputs.push(Output::Note(Note::Lost { reason: reason.to_owned() }));
                }
                (self.link, self.told) = (Link::Down, true);
            }
            Event::Line(bytes) => match parse(bytes) {
                Ok(line) => self.on_line(now, line, &mut outputs),
                Err(LineError::NotText | LineError::NotNumber) => self.refusals.malformed += 1,
            },
            Event::Overlong => self.refusals.overlong += 1,
            Event::Tick => {}
        }
        self.on_time(now, &mut outputs);
        let after = self.job.phase();
        if before != after {
            outputs.push(Output::Note(Note::Job { before, after }));
        }
        outputs
    }

    /// A connection or a start of the firmware: what was found does not count any more.
    fn begin(&mut self, now: Seconds, quiet_until: Seconds) {
        self.heard = now;
        self.asking = Asking::new(quiet_until, self.asking.unanswered);
        self.firmware = Firmware::default();
        (self.firmware_told, self.sensors_told) = (false, false);
    }

    fn on_line(&mut self, now: Seconds, line: Line, outputs: &mut Vec<Output>) {
        self.heard = now;
        if self.link == Link::Silent {
            self.link = Link::Alive;
            outputs.push(Output::Note(Note::Fresh));
        }
        match line.says {
            Says::Temperatures(report) => self.on_temperatures(now, &report, outputs),
            Says::Position(position_m) => {
                let limit_m = self.params.position_max_m;
                self.seen.on_position((now, position_m), limit_m, &mut self.refusals);
            }
            Says::Busy => self.asking.on_busy(now),
            Says::Wait => self.asking.on_ok(),
            Says::Start => {
                self.begin(now, now);
                self.link = Link::Alive;
                self.seen = Seen::default();
                self.job.on_start();
                outputs.push(Output::Note(Note::Started));
            }
            Says::Error { fatal, text } => self.on_error(now, fatal, text, outputs),
            Says::Action(action) => {
                let had_filament = !self.job.is_out_of_filament();
                self.job.on_action(action);
                if action == Action::OutOfFilament && had_filament {
                    outputs.push(Output::Note(Note::OutOfFilament));
                }
            }
            Says::Firmware(name) => self.firmware.named(name),
            Says::Capability { name, on } => {
                let without_card = name == "SDCARD" && !on;
                self.refusals.out_of_range += u64::from(!self.firmware.has(name, on));
                if without_card {
                    self.job.on_no_card();
                }
            }
            Says::Resend => {
                if self.spaced(now, self.resend_noted) {
                    self.resend_noted = Some(now);
                    outputs.push(Output::Note(Note::Resend));
                }
            }
            Says::Card(card) => self.job.on_card(card),
            Says::UnknownCommand(sent) => {
                if sent.starts_with(&Question::Card.line()) {
                    self.asking.card_unknown = true;
                    self.job.on_no_card();
                }
            }
            Says::Nothing | Says::Other => {}
        }
        if line.ok {
            self.on_ok(outputs);
        }
    }

    fn on_ok(&mut self, outputs: &mut Vec<Output>) {
        self.asking.on_ok();
        // Capabilities follow the name, and an `ok` follows them.
        if self.firmware.name().is_some() && !self.firmware_told {
            self.firmware_told = true;
            outputs.push(Output::Note(Note::Found(self.firmware.clone())));
        }
    }

    fn on_temperatures(&mut self, now: Seconds, report: &Temperatures, outputs: &mut Vec<Output>) {
        self.asking.on_temperatures(now);
        self.seen.on_temperatures(report, &self.params, &mut self.refusals);
        if !self.sensors_told {
            self.sensors_told = true;
            let missing = [(report.hotend, Sensor::Hotend), (report.bed, Sensor::Bed)];
            let missing = missing.into_iter().filter(|(temp, _)| temp.is_none());
            outputs.extend(missing.map(|(_, sensor)| Output::Note(Note::SensorMissing(sensor))));
        }
        outputs.push(Output::Temperatures(Report { stamp: now, hotend: report.hotend, bed: report.bed }));
    }

    fn on_error(&mut self, now: Seconds, fatal: bool, text: String, outputs: &mut Vec<Output>) {
        if fatal {
            self.job.on_fatal();
            if self.link != Link::Halted {
                self.link = Link::Halted;
                outputs.push(Output::Note(Note::Halted { text }));
            }
        } else if self.spaced(now, self.error_noted) {
            self.error_noted = Some(now);
            outputs.push(Output::Note(Note::FirmwareError { text }));
        }
    }

    /// A firmware that repeats itself without end does not fill the log.
    fn spaced(&self, now: Seconds, noted: Option<Seconds>) -> bool {
        noted.is_none_or(|noted| (now - noted).0 >= self.params.stale_after_s)
    }

    fn on_time(&mut self, now: Seconds, outputs: &mut Vec<Output>) {
        let age_s = (now - self.heard).0;
        let silent = age_s >= self.params.stale_after_s;
        // A board that starts has more time for its first word.
        let first_word =
            self.link == Link::Silent && age_s >= self.params.stale_after_s + self.params.greeting_s;
        if (self.link == Link::Alive && silent) || (first_word && !self.told) {
            (self.link, self.told) = (Link::Silent, true);
            outputs.push(Output::Note(Note::Stale { age_s }));
        }
        if matches!(self.link, Link::Alive | Link::Silent) || (self.link == Link::Halted && !silent) {
            let question = self.asking.next(now, &self.params, &self.firmware, &self.job);
            outputs.extend(question.map(Output::Ask));
        }
        let due = self.state_sent.is_none_or(|sent| (now - sent).0 >= self.params.state_period_s);
        // The last word of a firmware that has stopped itself is that the job has failed.
        let speaks = matches!(self.link, Link::Alive | Link::Halted) && !silent;
        if let Some(state) = self.seen.status(now, &self.job).filter(|_| due && speaks) {
            self.state_sent = Some(now);
            outputs.push(Output::State(Box::new(state)));
        }
    }
}
