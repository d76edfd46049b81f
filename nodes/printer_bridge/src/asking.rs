//! When to ask what: one question at a time, none that changes a print.

use crate::firmware::Firmware;
use crate::job::Job;
use crate::params::MarlinParams;
use models::units::Seconds;

/// Periods that a report may be late before temperatures are asked for.
const MISSING_REPORTS: f64 = 1.5;

/// All that the bridge ever sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Question {
    /// M115: who are you.
    Firmware,
    /// M155: report temperatures by yourself, with this period `[s]`.
    Reports(u8),
    /// M105: temperatures once.
    Temperatures,
    /// M27: what does the card do.
    Card,
    /// M114: where is the tool.
    Position,
}

impl Question {
    /// The line without its end.
    #[must_use]
    pub fn line(self) -> String {
        match self {
            Self::Firmware => "M115".to_owned(),
            Self::Reports(period_s) => format!("M155 S{period_s}"),
            Self::Temperatures => "M105".to_owned(),
            Self::Card => "M27".to_owned(),
            Self::Position => "M114".to_owned(),
        }
    }
}

/// Times of one connection. A line that is open to questions has none that waits for its `ok`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asking {
    /// Nothing is asked before.
    quiet_until: Seconds,
    /// When the question was put that waits for an `ok`, or the last sign that it still does.
    waiting_since: Option<Seconds>,
    firmware_asked: Option<Seconds>,
    reports_asked: bool,
    newest_temperatures: Seconds,
    card_asked: Option<Seconds>,
    position_asked: Option<Seconds>,
    /// The firmware has said that it does not know M27.
    pub card_unknown: bool,
    /// Questions that were given up.
    pub unanswered: u64,
}

impl Asking {
    /// For a line that was opened, or a firmware that has started, with quiet until a time.
    #[must_use]
    pub fn new(quiet_until: Seconds, unanswered: u64) -> Self {
        Self {
            quiet_until,
            waiting_since: None,
            firmware_asked: None,
            reports_asked: false,
            newest_temperatures: quiet_until,
            card_asked: None,
            position_asked: None,
            card_unknown: false,
            unanswered,
        }
    }

    /// The firmware takes the next line.
    pub fn on_ok(&mut self) {
        self.waiting_since = None;
    }

    /// The firmware works on what it was asked.
    pub fn on_busy(&mut self, now: Seconds) {
        if let Some(since) = &mut self.waiting_since {
            *since = now;
        }
    }

    /// Temperatures came, whoever asked for them.
    pub fn on_temperatures(&mut self, now: Seconds) {
        self.newest_temperatures = now;
    }

    /// The question to put now.
    pub fn next(
        &mut self,
        now: Seconds,
        params: &MarlinParams,
        firmware: &Firmware,
        job: &Job,
    ) -> Option<Question> {
        if now < self.quiet_until {
            return None;
        }
        if let Some(since) = self.waiting_since {
            if (now - since).0 < params.answer_limit_s {
                return None;
            }
            self.unanswered += 1;
            self.waiting_since = None;
        }
        let question = self.due(now, params, firmware, job)?;
        match question {
            Question::Firmware => self.firmware_asked = Some(now),
            Question::Reports(_) => self.reports_asked = true,
            Question::Temperatures => self.newest_temperatures = now,
            Question::Card => self.card_asked = Some(now),
            Question::Position => self.position_asked = Some(now),
        }
        self.waiting_since = Some(now);
        Some(question)
    }

    fn due(&self, now: Seconds, params: &MarlinParams, firmware: &Firmware, job: &Job) -> Option<Question> {
        let passed =
            |since: Option<Seconds>, period_s: f64| since.is_none_or(|since| (now - since).0 >= period_s);
        let period_s = f64::from(params.temperature_period_s);
        let silence_s = if self.reports_asked { MISSING_REPORTS * period_s } else { period_s };
        let has_card = !self.card_unknown && firmware.can("SDCARD") != Some(false);
        let position_allowed = job.is_off() || params.position_while_printing;
        if firmware.name().is_none() && passed(self.firmware_asked, params.answer_limit_s) {
            Some(Question::Firmware)
        } else if firmware.reports_temperatures() && !self.reports_asked {
            Some(Question::Reports(params.temperature_period_s))
        } else if passed(Some(self.newest_temperatures), silence_s) {
            Some(Question::Temperatures)
        } else if has_card && passed(self.card_asked, params.question_period_s) {
            Some(Question::Card)
        } else if position_allowed && passed(self.position_asked, params.question_period_s) {
            Some(Question::Position)
        } else {
            None
        }
    }
}
