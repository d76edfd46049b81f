//! A subscription that refuses: reads each message, checks the age of its stamp, and counts what it refuses.
//!
//! Counters in `/diagnostics`: `refused_<topic>` for all of a topic, slashes as underscores, and
//! `refused_<topic>_<reason>` for each [`Reason`].

use crate::clock::{Clock, monotonic};
use crate::diagnostics::Diagnostics;
use crate::error::RuntimeError;
use crate::node::Node;
use crate::owner::Owner;
use crate::subscription::{Gid, Received, Subscription};
use crate::topics::Topic;
use crate::wire::WireError;
use fdm_loop_msgs::RosType;
use models::units::Seconds;

/// Real time of silence after which another process may go on with a stream: several periods, and about what a node takes
/// that is started again.
pub const HANDOVER: Seconds = Seconds(0.5);
/// The same of what is seen in frames.
pub const FRAMES_HANDOVER: Seconds = Seconds(2.0);

/// Why a message was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reason {
    /// A value is NaN or infinite.
    NotFinite,
    /// A value outside of its range, or a stamp too far ahead of the clock.
    OutOfRange,
    /// A stamp too far behind the clock.
    Stale,
    /// Not later than the message before.
    Order,
    /// Parts are missing, or are not of the lengths that belong together.
    Malformed,
    /// From a second publisher, or with a sequence or a validity that does not count.
    Gate,
}

impl Reason {
    /// Every reason.
    pub const ALL: [Self; 6] =
        [Self::NotFinite, Self::OutOfRange, Self::Stale, Self::Order, Self::Malformed, Self::Gate];

    /// The ending of its counter.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "not_finite",
            Self::OutOfRange => "out_of_range",
            Self::Stale => "stale",
            Self::Order => "order",
            Self::Malformed => "malformed",
            Self::Gate => "gate",
        }
    }
}

impl From<&WireError> for Reason {
    fn from(error: &WireError) -> Self {
        match error {
            WireError::NotFinite { .. } => Self::NotFinite,
            WireError::OutOfRange { .. } | WireError::Stamp { .. } => Self::OutOfRange,
            WireError::Missing { .. } => Self::Malformed,
        }
    }
}

/// Counts what is refused of one topic.
#[derive(Debug, Clone)]
pub struct Refused {
    diagnostics: Diagnostics,
    counter: String,
    /// Totals of a brain that were seen last.
    followed: [u64; Reason::ALL.len()],
    totals: [u64; Reason::ALL.len()],
}

impl Refused {
    /// Counters at zero, shown from the start.
    #[must_use]
    pub fn new(diagnostics: Diagnostics, topic: &str) -> Self {
        let counter = format!("refused_{}", topic.trim_start_matches('/').replace('/', "_"));
        diagnostics.add(&counter, 0);
        Self { diagnostics, counter, followed: Default::default(), totals: Default::default() }
    }

    /// One message was refused.
    pub fn count(&mut self, reason: Reason) {
        self.add(reason, 1);
    }

    /// A brain counts for itself: takes over by how much its total has grown. One below the last tells a new brain.
    pub fn follow(&mut self, reason: Reason, total: u64) {
        let before = std::mem::replace(&mut self.followed[reason as usize], total);
        let grown = if total < before { total } else { total - before };
        if grown > 0 {
            self.add(reason, grown);
        }
    }

    /// Messages refused for this reason.
    #[must_use]
    pub fn total(&self, reason: Reason) -> u64 {
        self.totals[reason as usize]
    }

    fn add(&mut self, reason: Reason, amount: u64) {
        self.totals[reason as usize] = self.totals[reason as usize].saturating_add(amount);
        self.diagnostics.add(&self.counter, amount);
        self.diagnostics.add(&format!("{}_{}", self.counter, reason.name()), amount);
    }
}

/// A topic that a node listens to, with the oldest stamp it accepts.
#[derive(Debug)]
pub struct Inlet<T: RosType> {
    subscription: Subscription<T>,
    clock: Clock,
    limit: Seconds,
    owner: Option<Owner>,
    /// What was refused; a shell adds what its brain refuses.
    pub refused: Refused,
}

impl<T: RosType> Inlet<T> {
    /// Takes stamps that differ from the clock by `limit`, whatever silence shows in `/diagnostics`.
    #[must_use]
    pub fn with_stamps_within(mut self, limit: Seconds) -> Self {
        self.limit = limit;
        self
    }

    /// Takes messages of one process alone, until it has been silent for `handover` of real time in which another one spoke
    /// on: longer than its period. What others send meanwhile is refused and counted, and told where both go on.
    #[must_use]
    pub fn from_one_source(mut self, handover: Seconds) -> Self {
        self.owner = Some(Owner::handing_over_after(handover));
        self
    }

    /// Waits for a message, reads it with `read` (which yields its stamp too) and checks the stamp's age at its
    /// arrival. Cancelling loses no message.
    ///
    /// # Errors
    /// The [`Reason`] of a refusal, which is counted.
    pub async fn next<V>(
        &mut self,
        read: impl Fn(&T) -> Result<(Seconds, V), WireError>,
    ) -> Result<V, Reason> {
        self.next_of(|message, _| read(message)).await
    }

    /// The same where it matters who has sent it.
    ///
    /// # Errors
    /// As [`Inlet::next`].
    pub async fn next_of<V>(
        &mut self,
        read: impl Fn(&T, Gid) -> Result<(Seconds, V), WireError>,
    ) -> Result<V, Reason> {
        loop {
            let received = self.subscription.recv().await;
            let taken = read(&received.message, received.publisher)
                .map_err(|error| Reason::from(&error))
                .and_then(|(stamp, value)| self.check_age(&received, stamp).map(|()| value));
            let taken = taken.and_then(|value| self.check_source(received.publisher).map(|()| value));
            if let Err(reason) = taken {
                self.refused.count(reason);
            }
            // A successor that is not believed yet is no reason to tell anybody of.
            if !matches!(taken, Err(Reason::Gate)) || self.has_rival() {
                return taken;
            }
        }
    }

    fn check_source(&mut self, publisher: Gid) -> Result<(), Reason> {
        let takes = self.owner.as_mut().is_none_or(|owner| owner.takes(publisher, monotonic()));
        if takes { Ok(()) } else { Err(Reason::Gate) }
    }

    fn has_rival(&self) -> bool {
        self.owner.as_ref().is_none_or(|owner| owner.has_rival(monotonic()))
    }

    /// Age of a stamp when its message arrived: what waited in a queue of this process is not older for it.
    fn check_age(&self, received: &Received<T>, stamp: Seconds) -> Result<(), Reason> {
        check_age(age_s(stamp, received.received, self.clock.now()), self.limit)
    }
}

/// Refuses a message by the age of its stamp `[s]`: as old as `limit` at most, and no further ahead of the clock.
///
/// # Errors
/// [`Reason::Stale`] or [`Reason::OutOfRange`].
pub fn check_age(age_s: f64, limit: Seconds) -> Result<(), Reason> {
    if age_s > limit.0 {
        Err(Reason::Stale)
    } else if age_s < -limit.0 {
        Err(Reason::OutOfRange)
    } else {
        Ok(())
    }
}

/// Age of a stamp `[s]`; negative only where it is ahead of the clock itself, since an arrival under `/clock` is
/// dated to the last reading before it.
fn age_s(stamp: Seconds, received: Seconds, now: Seconds) -> f64 {
    if stamp <= received { received.0 - stamp.0 } else { (now.0 - stamp.0).min(0.0) }
}

impl Node {
    /// Listens to a topic whose stamps may differ from the clock by `limit`; a longer silence shows in
    /// `/diagnostics`.
    ///
    /// # Errors
    /// As [`Node::subscribe`].
    pub fn inlet<T: RosType>(&mut self, topic: &Topic<T>, limit: Seconds) -> Result<Inlet<T>, RuntimeError> {
        let subscription = self.subscribe(topic)?;
        subscription.expect_every(limit);
        let refused = Refused::new(self.diagnostics(), topic.name());
        Ok(Inlet { subscription, clock: self.clock(), limit, owner: None, refused })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_reason_has_a_counter_of_its_own_and_adds_to_the_topics() {
        let diagnostics = Diagnostics::default();
        let mut refused = Refused::new(diagnostics.clone(), "sensors/hotend/temperature");
        for reason in Reason::ALL {
            assert_eq!(Reason::ALL[reason as usize], reason);
            refused.count(reason);
            assert_eq!(
                diagnostics.counter(&format!("refused_sensors_hotend_temperature_{}", reason.name())),
                1
            );
        }
        assert_eq!(diagnostics.counter("refused_sensors_hotend_temperature"), 6);
    }

    #[test]
    fn the_growth_of_a_brains_total_is_taken_over_once_also_from_a_new_brain() {
        let diagnostics = Diagnostics::default();
        let mut refused = Refused::new(diagnostics.clone(), "x");
        for total in [2, 2, 5, 1] {
            refused.follow(Reason::Stale, total);
        }
        assert_eq!((refused.total(Reason::Stale), diagnostics.counter("refused_x_stale")), (6, 6));
    }

    #[test]
    fn a_stamp_between_arrival_and_clock_is_new() {
        let age = |stamp, received, now| age_s(Seconds(stamp), Seconds(received), Seconds(now));
        assert!((age(1.0, 3.0, 9.0) - 2.0).abs() < 1e-12, "old when it arrived");
        assert!(age(4.0, 3.0, 9.0).abs() < 1e-12, "the clock was read late");
        assert!((age(9.5, 3.0, 9.0) + 0.5).abs() < 1e-12, "ahead of the clock");
    }
}
