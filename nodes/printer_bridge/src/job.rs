//! Where the job stands, as far as Marlin tells.
//!
//! ```text
//! unknown, idle, done, failed -- SD printing byte --> printing -- action:pause --> paused
//! paused -- action:resume, or more bytes read --> printing -- Done printing file --> done
//! printing -- Not SD printing, action:cancel --> idle        paused -- action:cancel --> idle
//! printing, paused -- start --> failed                        any -- fatal error --> failed
//! ```
//! Done and failed stay until the next job begins. `Not SD printing` ends no pause: old Marlins say it in one.
//! Behind a fatal error bytes are those of the job that failed, said before the halt or by a firmware that reads on
//! without moving (Marlin's `stop()`), to the end of the file: the next job is told by bytes behind `Not SD printing` or a start,
//! or by fewer bytes than before.

use crate::line::{Action, Card};
use models::status::JobPhase;

/// The job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Job {
    phase: Option<JobPhase>,
    done: u64,
    total: u64,
    out_of_filament: bool,
    /// A fatal error, and no word since that the job it ended is off the card.
    halted: bool,
}

impl Job {
    /// Where it stands; `None` before anything was said of it.
    #[must_use]
    pub fn phase(&self) -> Option<JobPhase> {
        self.phase
    }

    /// It is known that nothing is printed.
    #[must_use]
    pub fn is_off(&self) -> bool {
        matches!(self.phase, Some(JobPhase::Idle | JobPhase::Done | JobPhase::Failed))
    }

    /// Bytes read and bytes of the file, in a print from the card.
    #[must_use]
    pub fn bytes(&self) -> Option<(u64, u64)> {
        (self.total > 0).then_some((self.done, self.total))
    }

    /// The run-out switch has seen no filament since the last resume.
    #[must_use]
    pub fn is_out_of_filament(&self) -> bool {
        self.out_of_filament
    }

    /// The firmware tells of the card.
    pub fn on_card(&mut self, card: Card) {
        let of_the_same = match card {
            Card::Printing { done, .. } => done >= self.done,
            Card::Done => true,
            Card::NotPrinting => false,
        };
        if self.halted && of_the_same {
            return;
        }
        self.halted = false;
        match (card, self.phase) {
            (Card::Printing { done, total }, phase) => {
                let stands = phase == Some(JobPhase::Paused) && done <= self.done;
                (self.done, self.total) = (done, total);
                if !stands {
                    self.phase = Some(JobPhase::Printing);
                }
            }
            (Card::NotPrinting, Some(JobPhase::Paused | JobPhase::Done | JobPhase::Failed))
            | (Card::Done, Some(JobPhase::Failed)) => {}
            (Card::NotPrinting, _) => self.phase = Some(JobPhase::Idle),
            (Card::Done, _) => self.phase = Some(JobPhase::Done),
        }
    }

    /// The firmware has no card to print from, and no other host has its port.
    pub fn on_no_card(&mut self) {
        self.on_card(Card::NotPrinting);
    }

    /// The firmware tells hosts.
    pub fn on_action(&mut self, action: Action) {
        match (action, self.phase) {
            (Action::Pause, None | Some(JobPhase::Printing)) => self.phase = Some(JobPhase::Paused),
            (Action::Resume, Some(JobPhase::Paused)) => self.phase = Some(JobPhase::Printing),
            (Action::Cancel, None | Some(JobPhase::Printing | JobPhase::Paused)) => {
                self.phase = Some(JobPhase::Idle);
            }
            _ => {}
        }
        match action {
            Action::OutOfFilament => self.out_of_filament = true,
            Action::Resume | Action::Cancel => self.out_of_filament = false,
            Action::Pause | Action::Other => {}
        }
    }

    /// The firmware has started: what it printed is lost.
    pub fn on_start(&mut self) {
        (self.out_of_filament, self.halted) = (false, false);
        self.phase = match self.phase {
            Some(JobPhase::Printing | JobPhase::Paused | JobPhase::Failed) => Some(JobPhase::Failed),
            _ => None,
        };
    }

    /// The firmware has stopped itself.
    pub fn on_fatal(&mut self) {
        (self.phase, self.halted) = (Some(JobPhase::Failed), true);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn printing(done: u64) -> Card {
        Card::Printing { done, total: 1000 }
    }

    fn job(cards: &[Card]) -> Job {
        let mut job = Job::default();
        cards.iter().for_each(|card| job.on_card(*card));
        job
    }

    #[test]
    fn a_print_from_the_card_from_begin_to_end() {
        let mut job = job(&[]);
        assert_eq!((job.phase(), job.is_off()), (None, false), "unknown is not idle");
        for (card, phase) in [
            (Card::NotPrinting, JobPhase::Idle),
            (printing(10), JobPhase::Printing),
            (printing(900), JobPhase::Printing),
            (Card::Done, JobPhase::Done),
            (Card::NotPrinting, JobPhase::Done),
            (printing(5), JobPhase::Printing),
            (Card::NotPrinting, JobPhase::Idle),
        ] {
            job.on_card(card);
            assert_eq!(job.phase(), Some(phase), "after {card:?}");
        }
    }

    #[test]
    fn a_pause_ends_with_a_resume_or_with_bytes_read_not_with_a_card_that_rests() {
        let mut job = job(&[printing(10)]);
        job.on_action(Action::Pause);
        for card in [printing(10), Card::NotPrinting] {
            job.on_card(card);
            assert_eq!(job.phase(), Some(JobPhase::Paused), "after {card:?}");
        }
        job.on_action(Action::Resume);
        assert_eq!(job.phase(), Some(JobPhase::Printing));
        job.on_action(Action::Pause);
        job.on_card(printing(11));
        assert_eq!(job.phase(), Some(JobPhase::Printing));
    }

    #[test]
    fn a_pause_without_a_job_is_none() {
        let mut job = job(&[Card::NotPrinting]);
        job.on_action(Action::Pause);
        job.on_action(Action::Resume);
        assert_eq!(job.phase(), Some(JobPhase::Idle));
    }

    /// C14: a restart or a halt in a job is its failure, until the next job.
    #[test]
    fn a_restart_fails_a_job_and_nothing_else() {
        let mut idle = job(&[Card::NotPrinting]);
        idle.on_start();
        assert_eq!(idle.phase(), None, "asked anew");
        let mut job = job(&[printing(10)]);
        job.on_start();
        job.on_card(Card::NotPrinting);
        job.on_start();
        assert_eq!(job.phase(), Some(JobPhase::Failed));
        job.on_card(printing(1));
        assert_eq!(job.phase(), Some(JobPhase::Printing));
        job.on_fatal();
        assert_eq!(job.phase(), Some(JobPhase::Failed));
    }

    /// A report on its way when the firmware halted is of the job that failed.
    #[test]
    fn bytes_of_a_job_that_failed_begin_none() {
        let failed = |next: &[Card]| {
            let mut job = job(&[printing(10)]);
            job.on_fatal();
            next.iter().for_each(|card| job.on_card(*card));
            job.phase()
        };
        assert_eq!(failed(&[printing(10), printing(12)]), Some(JobPhase::Failed));
        assert_eq!(failed(&[printing(12), Card::NotPrinting]), Some(JobPhase::Failed));
        assert_eq!(
            failed(&[printing(999), Card::Done, printing(999)]),
            Some(JobPhase::Failed),
            "read on to its end"
        );
        assert_eq!(failed(&[Card::NotPrinting, Card::Done]), Some(JobPhase::Failed));
        assert_eq!(failed(&[Card::NotPrinting, printing(1)]), Some(JobPhase::Printing));
        assert_eq!(failed(&[printing(12), printing(1)]), Some(JobPhase::Printing), "another file");
        let mut job = job(&[printing(10)]);
        job.on_fatal();
        job.on_start();
        job.on_card(printing(1));
        assert_eq!(job.phase(), Some(JobPhase::Printing), "a start tells that the halt is over");
    }
}
