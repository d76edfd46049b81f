//! What held a print up, what ended it, and what came behind that.

use super::super::decode::short;
use crate::operate::stop;
use fdm_loop_msgs::{PrintEvent, PrinterState, SafetyState};

/// Longest cause.
const CAUSE_MAX: usize = 200;
/// Longest text of what to do.
const TODO_MAX: usize = 300;
/// The supervisor tells its cause so long after the job has failed, at the latest `[s]`: `fdm up` takes it so, too.
const LATEST_S: f64 = 2.0;
/// How a cause begins that is a person's wish.
const PERSON: &str = "P13";
/// How one begins that is the printer's own giving up.
const PRINTER: &str = "C14";

/// A pause or a stop.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HeldUp {
    pub(crate) at: f64,
    pub(crate) mode: u8,
    /// Code and words.
    pub(crate) cause: String,
    pub(crate) what_to_do: String,
}

impl HeldUp {
    /// By what the supervisor says.
    fn told(at: f64, state: &SafetyState) -> Self {
        let (cause, what_to_do) = (short(&state.cause, CAUSE_MAX), short(&state.what_to_do, TODO_MAX));
        Self { at, mode: state.mode, cause, what_to_do }
    }

    /// By a person, past a supervisor that does not answer: nothing is latched there, so nothing is to be acknowledged.
    fn past(at: f64, event: &PrintEvent) -> Self {
        const NEXT: &str =
            "see the safety_supervisor's log for why it did not answer, then start the next print";
        let (mode, what_to_do) = if stop::is_emergency(event) {
            (SafetyState::MODE_ESTOP, format!("make the printer safe; {NEXT}"))
        } else {
            (SafetyState::MODE_SAFE_OFF, NEXT.to_owned())
        };
        Self { at, mode, cause: short(&event.why, CAUSE_MAX), what_to_do }
    }

    /// The code of the cause.
    pub(crate) fn code(&self) -> &str {
        self.cause.split(':').next().unwrap_or_default()
    }

    /// Whether it was a person's wish.
    pub(crate) fn is_wished(&self) -> bool {
        self.cause.starts_with(PERSON)
    }

    /// Whether it ends a job.
    pub(crate) fn is_stop(&self) -> bool {
        self.mode >= SafetyState::MODE_SAFE_OFF
    }

    /// Headline of a print that it has ended.
    pub(crate) fn headline(&self) -> &'static str {
        match self.code() {
            PERSON => "Stopped by a person",
            PRINTER => "Failed",
            _ => "Stopped by the supervisor",
        }
    }
}

/// How a print came to its end.
#[derive(Debug, Default)]
pub(crate) struct Ending {
    /// The pause that was not resumed from.
    pause: Option<HeldUp>,
    /// The first stop that was not resumed from: it ended the job, where that was not over before.
    stop: Option<HeldUp>,
    /// The newest one behind them.
    later: Option<HeldUp>,
    /// Since when the job is over, and in which phase it was then.
    over: Option<(f64, u8)>,
}

impl Ending {
    /// Takes the phase of the job in.
    pub(super) fn phase(&mut self, at: f64, phase: u8) {
        if works(phase) {
            self.over = None;
        } else if matches!(phase, PrinterState::PHASE_DONE | PrinterState::PHASE_FAILED) {
            // Heaters that go off behind the last road make no failure of it.
            self.over.get_or_insert((at, phase));
            self.later.take_if(|later| !later.is_stop());
            // What has come to its end no pause has held up.
            if phase == PrinterState::PHASE_DONE {
                self.pause = None;
            }
        }
    }

    /// Takes the supervisor's state in; `goes_on`: the printer prints.
    pub(super) fn safety(&mut self, at: f64, state: &SafetyState, goes_on: bool) {
        if state.mode < SafetyState::MODE_PAUSED {
            if goes_on {
                (self.pause, self.stop, self.later) = (None, None, None);
            }
        } else if state.mode >= SafetyState::MODE_SAFE_OFF || !state.cause.is_empty() {
            self.hold(HeldUp::told(at, state));
        }
    }

    /// A person stops the print past a supervisor that does not answer: the printer gives the job up because of that.
    pub(super) fn past_the_supervisor(&mut self, at: f64, event: &PrintEvent) {
        self.stop.take_if(|stop| stop.code() == PRINTER);
        self.hold(HeldUp::past(at, event));
    }

    fn hold(&mut self, new: HeldUp) {
        const FAILED: u8 = PrinterState::PHASE_FAILED;
        let late = matches!(self.over, Some((since, FAILED)) if new.at - since > LATEST_S);
        let known = |held_up: &HeldUp| (held_up.mode, &held_up.cause) == (new.mode, &new.cause);
        if new.is_stop() && self.stop.is_none() && !late {
            // What a person does about a pause afterwards is not why the print was held up.
            self.pause.take_if(|pause| pause.is_wished() || !new.is_wished());
            (self.stop, self.later) = (Some(new), None);
        } else if new.is_stop() || self.over.is_none() {
            // A job that is over no pause holds up.
            let first = !new.is_stop() && self.stop.is_none() && self.pause.is_none();
            if first {
                self.pause = Some(new);
            } else if ![&self.pause, &self.stop].into_iter().flatten().any(known) {
                self.later = Some(new);
            }
        }
    }

    /// When the file came to its end, where it did.
    pub(crate) fn done(&self) -> Option<f64> {
        self.over.filter(|(_, phase)| *phase == PrinterState::PHASE_DONE).map(|(at, _)| at)
    }

    /// What ended the job.
    pub(crate) fn stop(&self) -> Option<&HeldUp> {
        self.stop.as_ref()
    }

    /// All that is told, in its order.
    pub(crate) fn told(&self) -> Vec<&HeldUp> {
        let all = [&self.pause, &self.stop, &self.later].into_iter().flatten();
        all.filter(|held_up| !held_up.cause.is_empty()).collect()
    }
}

/// Whether a job is under way in this phase.
pub(crate) fn works(phase: u8) -> bool {
    matches!(phase, PrinterState::PHASE_PREPARING | PrinterState::PHASE_PRINTING | PrinterState::PHASE_PAUSED)
}

#[cfg(test)]
mod tests {
    use super::*;
    use models::command::Request;
    use models::units::Seconds;

    const DONE: u8 = PrinterState::PHASE_DONE;
    const FAILED: u8 = PrinterState::PHASE_FAILED;
    const PAUSED: u8 = SafetyState::MODE_PAUSED;
    const SAFE_OFF: u8 = SafetyState::MODE_SAFE_OFF;
    const ESTOP: u8 = SafetyState::MODE_ESTOP;

    impl Ending {
        fn says(&mut self, at: f64, mode: u8, cause: &str) {
            self.safety(at, &SafetyState { mode, cause: cause.to_owned(), ..SafetyState::default() }, false);
        }

        fn codes(&self) -> Vec<(&str, u8)> {
            self.told().iter().map(|held_up| (held_up.code(), held_up.mode)).collect()
        }
    }

    #[test]
    fn a_stop_past_the_supervisor_is_why_the_print_ended() {
        for (request, mode, cause) in [
            (Request::HeatersOff, SAFE_OFF, "P13: a person stops"),
            (Request::EmergencyStop, ESTOP, "P13: emergency stop by a person"),
        ] {
            let mut ending = Ending::default();
            ending.says(8.0, PAUSED, "P13: paused by a person");
            let event = stop::told(Seconds(12.0), request);
            ending.past_the_supervisor(12.0, &event);
            ending.says(12.01, PAUSED, "P13: paused by a person");
            ending.phase(12.1, FAILED);
            ending.past_the_supervisor(12.1, &event);
            ending.says(12.5, PAUSED, "P13: paused by a person");
            let stop = ending.stop().cloned().unwrap();
            assert_eq!((stop.mode, stop.at, stop.headline()), (mode, 12.0, "Stopped by a person"));
            assert!(stop.cause.starts_with(cause) && stop.what_to_do.contains("next print"), "{stop:?}");
            assert_eq!(ending.codes(), [("P13", mode)]);
        }
    }

    /// A supervisor that sees the job given up before it hears why.
    #[test]
    fn a_printer_that_was_told_to_give_up_has_not_failed() {
        let mut ending = Ending::default();
        ending.phase(12.1, FAILED);
        ending.says(12.2, SAFE_OFF, "C14: the printer gave the job up");
        assert_eq!(ending.stop().map(HeldUp::headline), Some("Failed"));
        ending.past_the_supervisor(12.3, &stop::told(Seconds(12.3), Request::HeatersOff));
        assert_eq!(ending.stop().map(HeldUp::headline), Some("Stopped by a person"));
    }

    #[test]
    fn the_first_stop_ended_the_job_whatever_is_worse_later() {
        let mut ending = Ending::default();
        for (at, mode, cause) in [
            (5.0, PAUSED, "P6: the filament does not follow"),
            (9.0, SAFE_OFF, "P2: too little power"),
            (9.5, SAFE_OFF, "P2: too little power"),
            (17.0, ESTOP, "P1: no reading shows whether they are off"),
        ] {
            ending.says(at, mode, cause);
        }
        assert_eq!(ending.codes(), [("P2", SAFE_OFF), ("P1", ESTOP)], "the pause has escalated");
        ending.says(20.0, SafetyState::MODE_ACT, "");
        assert_eq!(ending.codes().len(), 2, "acknowledged, not resumed from");
    }

    #[test]
    fn what_comes_behind_the_end_has_not_ended_it() {
        let mut done = Ending::default();
        done.phase(100.0, DONE);
        done.says(100.5, SAFE_OFF, "P13: stopped by a person");
        done.phase(100.6, FAILED);
        assert_eq!(done.done(), Some(100.0));
        done.phase(120.0, PrinterState::PHASE_PREPARING);
        assert_eq!(done.done(), None, "the next job");
        let mut failed = Ending::default();
        failed.phase(10.0, FAILED);
        failed.says(20.0, SAFE_OFF, "P13: stopped by a person");
        assert_eq!((failed.stop(), failed.codes()), (None, vec![("P13", SAFE_OFF)]));
    }
}
