//! P1 behind a blind thermistor: the heaters are off by order, and no reading shows whether they are.
//!
//! A switch that conducts by itself shows in a reading that warms ([`super::rising`]). Where the reading is not the block's,
//! or there is none, only the mains relay is sure.

use models::units::Seconds;

/// What is known of the readings while the heaters are off by order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sight {
    /// They come, and show what the block does.
    Clear,
    /// They come, too few in a row to tell them from a loose plug's.
    Unsure,
    /// There are none, or impossible ones.
    None,
    /// They were not the block's, or may not have been: nobody knows until a person has looked.
    Doubted,
}

/// Watches for how long nobody has seen whether it cools.
#[derive(Debug, Clone)]
pub struct UnseenCheck {
    limit_s: f64,
    since: Option<Seconds>,
    doubted: bool,
}

impl UnseenCheck {
    /// Heaters that are off by order may go unseen for `limit_s` `[s]`.
    #[must_use]
    pub fn new(limit_s: f64) -> Self {
        Self { limit_s, since: None, doubted: false }
    }

    /// Takes what is seen of heaters that are off by order; `None` where they are not.
    pub fn look(&mut self, now: Seconds, sight: Option<Sight>) {
        let Some(sight) = sight else {
            (self.since, self.doubted) = (None, false);
            return;
        };
        self.doubted |= sight == Sight::Doubted;
        let before = self.since.filter(|since| *since <= now);
        self.since = match sight {
            Sight::Clear if !self.doubted => None,
            Sight::Unsure if !self.doubted => before,
            _ => before.or(Some(now)),
        };
    }

    /// Time in which the supervisor itself stood still does not count; a clock that was set back takes the time with it.
    pub fn forgive(&mut self, now: Seconds, gap: Seconds) {
        self.since = self.since.map(|since| Seconds((since + gap).0.min(now.0)));
    }

    /// For how long nothing has been seen, and what is allowed `[s]`; `None` where that is not too long.
    #[must_use]
    pub fn unseen_s(&self, now: Seconds) -> Option<(f64, f64)> {
        let age_s = (now - self.since?).0;
        (age_s > self.limit_s).then_some((age_s, self.limit_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use Sight::{Clear, Doubted, Unsure};

    /// A check that has looked every tenth of a second from 100 s on.
    fn after(looks: &[Sight]) -> UnseenCheck {
        let mut check = UnseenCheck::new(2.0);
        for (number, sight) in looks.iter().enumerate() {
            check.look(Seconds(100.0 + 0.1 * number as f64), Some(*sight));
        }
        check
    }

    /// Two seconds without sight, in whose middle this was seen.
    fn with(sight: Sight) -> UnseenCheck {
        let mut looks = [Sight::None; 30];
        looks[15] = sight;
        after(&looks)
    }

    #[test]
    fn what_is_unseen_until_it_is_seen_clearly_counts() {
        assert_eq!(after(&[Sight::None; 21]).unseen_s(Seconds(102.0)), None, "not yet beyond");
        let (age_s, limit_s) = after(&[Sight::None; 21]).unseen_s(Seconds(102.1)).unwrap();
        assert!((age_s - 2.1).abs() < 1e-9 && (limit_s - 2.0).abs() < 1e-9);
        assert_eq!(with(Clear).unseen_s(Seconds(103.0)), None, "seen meanwhile");
        assert!(with(Unsure).unseen_s(Seconds(103.0)).is_some(), "a loose plug's reading is none");
        for seen in [Clear, Unsure] {
            assert_eq!(after(&[seen; 30]).unseen_s(Seconds(200.0)), None);
        }
    }

    #[test]
    fn doubt_lasts_until_the_latch_ends() {
        let mut check = after(&[Doubted, Clear, Clear]);
        assert!(check.unseen_s(Seconds(102.1)).is_some());
        check.look(Seconds(102.1), None);
        check.look(Seconds(102.2), Some(Clear));
        assert_eq!(check.unseen_s(Seconds(200.0)), None);
    }

    #[test]
    fn time_that_nobody_had_and_a_clock_set_back_count_for_nothing() {
        let mut check = after(&[Sight::None; 15]);
        check.forgive(Seconds(111.4), Seconds(10.0));
        assert_eq!(check.unseen_s(Seconds(111.9)), None, "1.9 s beside the 10 s");
        assert!(check.unseen_s(Seconds(112.1)).is_some());
        check.forgive(Seconds(61.4), Seconds(-50.0));
        assert!(check.unseen_s(Seconds(62.1)).is_some(), "as old as it was");
        check.look(Seconds(50.0), Some(Sight::None));
        assert_eq!(check.unseen_s(Seconds(51.9)), None, "from ahead of the clock: anew");
        // of what is doubted too, whatever is seen then
        let mut check = after(&[Doubted; 15]);
        check.look(Seconds(50.0), Some(Unsure));
        assert_eq!(check.unseen_s(Seconds(51.9)), None);
        assert!(check.unseen_s(Seconds(52.1)).is_some());
    }
}
