//! Why a job was given up: what was in force then, whatever is told, done or acknowledged later.

use fdm_loop_msgs::SafetyState;
use models::units::Seconds;

/// The supervisor tells its cause so long after the job has failed, at the latest `[s]`: four of its states.
const LATEST_S: f64 = 2.0;
/// How a cause begins that is a person's wish.
const PERSON: &str = "P13";

/// The end of a job that was given up.
#[derive(Debug, Default)]
pub(super) struct Failure {
    since: Option<Seconds>,
    cause: Option<String>,
}

impl Failure {
    /// Looks at the job at `now`, at what the supervisor says, and at what a person told the printer itself.
    pub(super) fn look(
        &mut self,
        now: Seconds,
        failed: bool,
        safety: Option<&SafetyState>,
        past: Option<&str>,
    ) {
        if !failed {
            *self = Self::default();
            return;
        }
        let since = *self.since.get_or_insert(now);
        if self.cause.is_some() {
            return;
        }
        // A pause that was there before is no reason.
        let ends =
            |safety: &&SafetyState| safety.mode >= SafetyState::MODE_SAFE_OFF && !safety.cause.is_empty();
        let told = safety.filter(ends).filter(|_| (now - since).0 <= LATEST_S);
        self.cause = past.or(told.map(|safety| safety.cause.as_str())).map(str::to_owned);
    }

    /// Why, where anybody said so.
    pub(super) fn cause(&self) -> Option<&str> {
        self.cause.as_deref()
    }

    /// Whether it was a person's wish.
    pub(super) fn is_wished(&self) -> bool {
        self.cause().is_some_and(|cause| cause.starts_with(PERSON))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn says(mode: u8, cause: &str) -> SafetyState {
        SafetyState { mode, cause: cause.to_owned(), ..SafetyState::default() }
    }

    #[test]
    fn what_a_person_does_behind_a_failure_does_not_make_it_a_wish() {
        let mut failure = Failure::default();
        failure.look(Seconds(9.0), false, Some(&says(SafetyState::MODE_ACT, "")), None);
        failure.look(Seconds(10.0), true, Some(&says(SafetyState::MODE_SAFE_OFF, "S1: open")), None);
        failure.look(Seconds(20.0), true, Some(&says(SafetyState::MODE_OBSERVE, "")), None);
        failure.look(Seconds(21.0), true, Some(&says(SafetyState::MODE_SAFE_OFF, "P13: stopped")), None);
        assert_eq!((failure.cause(), failure.is_wished()), (Some("S1: open"), false));
    }

    #[test]
    fn a_wish_stays_one_behind_its_acknowledgement() {
        let mut failure = Failure::default();
        failure.look(Seconds(10.0), true, Some(&says(SafetyState::MODE_PAUSED, "P6: slip")), None);
        assert_eq!(failure.cause(), None, "a pause fails no job");
        failure.look(Seconds(10.3), true, Some(&says(SafetyState::MODE_SAFE_OFF, "P13: stopped")), None);
        failure.look(Seconds(20.0), true, Some(&says(SafetyState::MODE_ACT, "")), None);
        assert_eq!((failure.cause(), failure.is_wished()), (Some("P13: stopped"), true));
        failure.look(Seconds(30.0), false, None, None);
        assert_eq!(failure.cause(), None, "the next job");
    }

    #[test]
    fn past_a_silent_supervisor_it_is_what_the_person_told_the_printer() {
        let mut failure = Failure::default();
        failure.look(Seconds(10.0), true, Some(&says(SafetyState::MODE_ACT, "")), None);
        assert!(!failure.is_wished());
        failure.look(Seconds(13.0), true, Some(&says(SafetyState::MODE_SAFE_OFF, "C14: lost")), None);
        assert_eq!(failure.cause(), None, "too late to be the reason");
        failure.look(Seconds(14.0), true, None, Some("P13: past the supervisor"));
        assert!(failure.is_wished());
    }
}
