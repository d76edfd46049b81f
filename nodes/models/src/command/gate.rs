//! Which of the received commands or permits counts now.
//!
//! Deadlines run on the time of receipt on the receiver's clock; a sender's stamp is not asked. A queue that
//! hands out old messages after a stop is cut short by its depth of one, not here.

use super::{Command, Permit, Trims};
use crate::units::Seconds;

/// What a [`Gate`] needs to know of a message.
pub trait Dated: Copy {
    /// Random id of the publisher's run.
    fn session(&self) -> u64;
    /// Counter within the session.
    fn sequence(&self) -> u64;
    /// How long the message counts after receipt.
    fn validity(&self) -> Seconds;
    /// The corrections it carries.
    fn trims(&self) -> &Trims;
}

macro_rules! dated {
    ($($message:ty),*) => {$(
        impl Dated for $message {
            fn session(&self) -> u64 {
                self.session
            }
            fn sequence(&self) -> u64 {
                self.sequence
            }
            fn validity(&self) -> Seconds {
                self.validity
            }
            fn trims(&self) -> &Trims {
                &self.trims
            }
        }
    )*};
}
dated!(Command, Permit);

/// Why a message was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Refusal {
    /// Validity or a trim is NaN or infinite.
    NotFinite,
    /// Validity zero, negative or longer than allowed.
    Validity,
    /// Sequence not above the last one of the session: late or twice.
    Sequence,
    /// Another session is still in force.
    OtherSession,
}

impl Refusal {
    /// Name in counters and diagnostics.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "not_finite",
            Self::Validity => "validity",
            Self::Sequence => "sequence",
            Self::OtherSession => "other_session",
        }
    }

    /// What is wrong, for a person.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::NotFinite => "its validity or a correction is not a number",
            Self::Validity => "its validity is not above 0 s, or longer than allowed",
            Self::Sequence => "late or twice: its sequence is not above the last one",
            Self::OtherSession => {
                "another publisher was in force a moment ago: it has ended, or two of them run"
            }
        }
    }
}

/// Refused messages by reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Refusals {
    /// See [`Refusal::NotFinite`].
    pub not_finite: u64,
    /// See [`Refusal::Validity`].
    pub validity: u64,
    /// See [`Refusal::Sequence`].
    pub sequence: u64,
    /// See [`Refusal::OtherSession`].
    pub other_session: u64,
}

impl Refusals {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.not_finite + self.validity + self.sequence + self.other_session
    }

    pub(super) fn count(&mut self, refusal: Refusal) {
        let counter = match refusal {
            Refusal::NotFinite => &mut self.not_finite,
            Refusal::Validity => &mut self.validity,
            Refusal::Sequence => &mut self.sequence,
            Refusal::OtherSession => &mut self.other_session,
        };
        *counter = counter.saturating_add(1);
    }
}

/// The newest accepted message and the moment it came.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Held<M> {
    message: M,
    received: Seconds,
}

/// Accepts one publisher's messages in order; holds the newest until it lapses.
#[derive(Debug, Clone)]
pub struct Gate<M> {
    validity_max: Seconds,
    held: Option<Held<M>>,
    refusals: Refusals,
}

impl<M: Dated> Gate<M> {
    /// An empty gate that accepts validities up to `validity_max`.
    #[must_use]
    pub fn new(validity_max: Seconds) -> Self {
        Self { validity_max, held: None, refusals: Refusals::default() }
    }

    /// Takes a message received at `now`, or refuses and counts it. A refused one prolongs nothing.
    ///
    /// # Errors
    /// The [`Refusal`].
    pub fn offer(&mut self, now: Seconds, message: M) -> Result<(), Refusal> {
        if let Some(refusal) = self.objection(now, &message) {
            self.refusals.count(refusal);
            return Err(refusal);
        }
        self.held = Some(Held { message, received: now });
        Ok(())
    }

    /// The message in force, `None` once it has lapsed.
    #[must_use]
    pub fn in_force(&self, now: Seconds) -> Option<&M> {
        let held = self.held.as_ref()?;
        let age_s = now.0 - held.received.0;
        // A negative age is a clock that was set back: its deadline means nothing any more.
        (0.0..=held.message.validity().0).contains(&age_s).then_some(&held.message)
    }

    /// Moment at which the newest message lapses or lapsed; `None` before the first.
    #[must_use]
    pub fn lapse(&self) -> Option<Seconds> {
        self.held.as_ref().map(|held| held.received + held.message.validity())
    }

    /// Newest accepted message, lapsed or not.
    #[must_use]
    pub fn newest(&self) -> Option<&M> {
        self.held.as_ref().map(|held| &held.message)
    }

    /// Age of the newest accepted message.
    #[must_use]
    pub fn age(&self, now: Seconds) -> Option<Seconds> {
        self.held.as_ref().map(|held| now - held.received)
    }

    /// What was refused so far.
    #[must_use]
    pub fn refusals(&self) -> Refusals {
        self.refusals
    }

    fn objection(&self, now: Seconds, message: &M) -> Option<Refusal> {
        // Who it is comes first: what a second publisher sends wrongly makes it none less.
        if self.in_force(now).is_some_and(|held| held.session() != message.session()) {
            return Some(Refusal::OtherSession);
        }
        let validity_s = message.validity().0;
        if !(now.0.is_finite() && validity_s.is_finite() && message.trims().is_finite()) {
            return Some(Refusal::NotFinite);
        }
        if !(validity_s > 0.0 && validity_s <= self.validity_max.0) {
            return Some(Refusal::Validity);
        }
        let newest = self.newest()?;
        let late = newest.session() == message.session() && message.sequence() <= newest.sequence();
        late.then_some(Refusal::Sequence)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn command(session: u64, sequence: u64) -> Command {
        Command { session, sequence, validity: Seconds(1.0), trims: Trims::NEUTRAL }
    }

    fn gate() -> Gate<Command> {
        Gate::new(Seconds(1.5))
    }

    #[test]
    fn a_command_counts_from_receipt_until_its_validity_ends() {
        let mut gate = gate();
        assert_eq!(gate.in_force(Seconds(0.0)), None);
        gate.offer(Seconds(10.0), command(1, 1)).unwrap();
        assert!(gate.in_force(Seconds(11.0)).is_some());
        assert!(gate.in_force(Seconds(11.001)).is_none());
        assert!(gate.in_force(Seconds(9.9)).is_none(), "the clock was set back");
        assert_eq!(gate.lapse(), Some(Seconds(11.0)));
    }

    #[test]
    fn a_second_live_publisher_is_refused_and_may_follow_once_the_first_is_gone() {
        let mut gate = gate();
        gate.offer(Seconds(0.0), command(1, 100)).unwrap();
        assert_eq!(gate.offer(Seconds(0.5), command(2, 1)), Err(Refusal::OtherSession));
        assert_eq!(gate.offer(Seconds(1.01), command(2, 2)), Ok(()));
        assert_eq!(gate.offer(Seconds(1.02), command(1, 101)), Err(Refusal::OtherSession));
        assert_eq!(gate.refusals(), Refusals { other_session: 2, ..Refusals::default() });
    }

    /// What a second publisher sends is its own, however it is wrong.
    #[test]
    fn a_second_publisher_is_known_by_its_session_whatever_else_is_wrong() {
        let mut gate = gate();
        gate.offer(Seconds(0.0), command(1, 100)).unwrap();
        let nan = Trims { flow: f64::NAN, ..Trims::NEUTRAL };
        for message in [
            Command { validity: Seconds(60.0), ..command(2, 1) },
            Command { validity: Seconds(f64::NAN), ..command(2, 1) },
            Command { trims: nan, ..command(2, 1) },
        ] {
            assert_eq!(gate.offer(Seconds(0.5), message), Err(Refusal::OtherSession));
        }
        let late = Command { validity: Seconds(60.0), ..command(2, 1) };
        assert_eq!(gate.offer(Seconds(1.1), late), Err(Refusal::Validity), "nobody is in force any more");
    }

    #[test]
    fn bad_messages_are_refused_counted_and_prolong_nothing() {
        let mut gate = gate();
        gate.offer(Seconds(0.0), command(1, 5)).unwrap();
        let nan = Trims { flow: f64::NAN, ..Trims::NEUTRAL };
        for (message, refusal) in [
            (command(1, 5), Refusal::Sequence),
            (command(1, 4), Refusal::Sequence),
            (Command { validity: Seconds(0.0), ..command(1, 6) }, Refusal::Validity),
            (Command { validity: Seconds(1.6), ..command(1, 6) }, Refusal::Validity),
            (Command { validity: Seconds(f64::NAN), ..command(1, 6) }, Refusal::NotFinite),
            (Command { trims: nan, ..command(1, 6) }, Refusal::NotFinite),
        ] {
            assert_eq!(gate.offer(Seconds(0.9), message), Err(refusal));
        }
        assert_eq!(gate.refusals().total(), 6);
        assert!(gate.in_force(Seconds(1.01)).is_none());
    }

    proptest! {
        /// Whatever arrives, what is in force came in no longer ago than its validity, from one publisher at a time,
        /// in rising order.
        #[test]
        fn only_one_publisher_counts_at_a_time(
            arrivals in proptest::collection::vec((0.0..0.4f64, 0u64..3, 0u64..50, 0.0..2.0f64), 1..200)
        ) {
            let (mut gate, mut now_s) = (gate(), 0.0);
            let mut bound: Option<(u64, u64, f64)> = None;
            for (step_s, session, sequence, validity_s) in arrivals {
                now_s += step_s;
                let message = Command { validity: Seconds(validity_s), ..command(session, sequence) };
                if gate.offer(Seconds(now_s), message).is_ok() {
                    if let Some((owner, last, until_s)) = bound {
                        let allowed = if owner == session { sequence > last } else { now_s > until_s };
                        prop_assert!(allowed);
                    }
                    bound = Some((session, sequence, now_s + validity_s));
                }
                if let (Some(newest), Some((owner, last, until_s))) = (gate.in_force(Seconds(now_s)), bound) {
                    prop_assert_eq!((newest.session, newest.sequence), (owner, last));
                    prop_assert!(now_s <= until_s + 1e-12);
                }
            }
        }
    }
}
