//! Whose messages count where one alone may speak: two owners of `/clock` would set every deadline of the graph to and fro,
//! and a second thermistor would speak a heater well that is not.
//!
//! The first to speak owns the topic, until it has been silent for a while in which another one spoke on. Whether another
//! one is a rival or a successor its owner tells: a rival's owner is still there.

use crate::subscription::Gid;
use models::units::Seconds;

/// How long a successor has to have spoken `[s]`: after a stall of this process the owner's readings may stand in the
/// queue behind a stranger's.
const SPOKEN_S: f64 = 0.1;
/// How long a rival is remembered `[s]`.
const MEMORY_S: f64 = 5.0;

/// What is known of those who publish a topic; all times are real ones.
#[derive(Debug)]
pub(crate) struct Owner {
    handover: Seconds,
    owner: Option<(Gid, Seconds)>,
    /// Since when others have spoken without a word of the owner.
    others_since: Option<Seconds>,
    rival: Option<Seconds>,
}

impl Owner {
    /// Nobody has spoken. After a silence of `handover` the topic is another one's.
    pub(crate) fn handing_over_after(handover: Seconds) -> Self {
        Self { handover, owner: None, others_since: None, rival: None }
    }

    /// Whether a message of `publisher` counts that is taken at `now`.
    pub(crate) fn takes(&mut self, publisher: Gid, now: Seconds) -> bool {
        let others_since = self.others_since;
        match &mut self.owner {
            Some((owner, heard)) if owner.process() == publisher.process() => {
                *heard = now;
                if self.others_since.take().is_some() {
                    self.rival = Some(now);
                }
                true
            }
            Some((_, heard)) => {
                let since = others_since.unwrap_or(now);
                self.others_since = Some(since);
                let hands_over = now - *heard >= self.handover && (now - since).0 >= SPOKEN_S;
                if hands_over {
                    let owner = Some((publisher, now));
                    *self = Self { owner, ..Self::handing_over_after(self.handover) };
                }
                hands_over
            }
            None => {
                self.owner = Some((publisher, now));
                true
            }
        }
    }

    /// Whether somebody else speaks as well.
    pub(crate) fn has_rival(&self, now: Seconds) -> bool {
        self.rival.is_some_and(|seen| (now - seen).0 < MEMORY_S)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIRST: Gid = Gid([1; 16]);
    const SECOND: Gid = Gid([2; 16]);

    fn owner() -> Owner {
        Owner::handing_over_after(Seconds(1.0))
    }

    #[test]
    fn a_second_clock_is_a_rival_that_never_counts_and_is_forgotten() {
        let mut owner = owner();
        assert!(owner.takes(FIRST, Seconds(0.0)));
        for number in 1..=500_u32 {
            let now = Seconds(0.01 * f64::from(number));
            assert!(!owner.takes(SECOND, now), "{number}");
            assert!(owner.takes(FIRST, now));
            assert!(owner.has_rival(now), "{number}");
        }
        assert!(owner.takes(FIRST, Seconds(9.9)) && owner.has_rival(Seconds(9.9)));
        assert!(owner.takes(FIRST, Seconds(10.1)) && !owner.has_rival(Seconds(10.1)));
    }

    /// A printer that is started again is no rival of the one that died.
    #[test]
    fn a_successor_is_believed_after_a_second_and_is_no_rival() {
        let mut owner = owner();
        assert!(owner.takes(FIRST, Seconds(0.0)));
        assert!(!owner.takes(SECOND, Seconds(0.5)));
        assert!(!owner.takes(SECOND, Seconds(0.99)));
        assert!(owner.takes(SECOND, Seconds(1.0)));
        assert!(owner.takes(SECOND, Seconds(1.01)) && !owner.has_rival(Seconds(1.01)));
        assert!(!owner.takes(FIRST, Seconds(1.02)), "the one before comes too late");
        assert!(owner.takes(SECOND, Seconds(1.03)) && owner.has_rival(Seconds(1.03)));
    }

    /// This process stood still for 3 s: what has waited is taken in any order.
    #[test]
    fn a_stall_of_the_listener_is_no_silence_of_the_owner() {
        let mut owner = owner();
        assert!(owner.takes(FIRST, Seconds(0.0)));
        assert!(!owner.takes(SECOND, Seconds(3.0)));
        assert!(owner.takes(FIRST, Seconds(3.001)));
        assert!(!owner.takes(SECOND, Seconds(3.2)));
    }

    #[test]
    fn the_writers_of_one_process_are_one_owner() {
        let other_writer = Gid(std::array::from_fn(|byte| if byte < 12 { 1 } else { 9 }));
        let mut owner = owner();
        assert!(owner.takes(FIRST, Seconds(0.0)) && owner.takes(other_writer, Seconds(0.01)));
        assert!(!owner.has_rival(Seconds(0.01)));
    }
}
