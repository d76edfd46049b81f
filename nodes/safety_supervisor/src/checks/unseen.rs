//! P1 behind a blind thermistor: the heaters are off by order, and no reading shows whether they are.
//!
//! A switch that conducts by itself shows in a reading that warms ([`super::rising`]). Where the reading is not the block's,
//! or there is none, only the mains relay is sure.

use models::units::Seconds;

/// Watches for how long nobody has seen whether it cools.
#[derive(Debug, Clone)]
pub struct UnseenCheck {
    limit_s: f64,
    since: Option<Seconds>,
}

impl UnseenCheck {
    /// Heaters that are off by order may go unseen for `limit_s` `[s]`.
    #[must_use]
    pub fn new(limit_s: f64) -> Self {
        Self { limit_s, since: None }
    }

    /// Takes whether the heaters are off by order and not seen to be.
    pub fn look(&mut self, now: Seconds, unseen: bool) {
        self.since = unseen.then(|| self.since.filter(|since| *since <= now).unwrap_or(now));
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

    /// A check that has looked every tenth of a second from 100 s on.
    fn after(looks: &[bool]) -> UnseenCheck {
        let mut check = UnseenCheck::new(2.0);
        for (number, unseen) in looks.iter().enumerate() {
            check.look(Seconds(100.0 + 0.1 * number as f64), *unseen);
        }
        check
    }

    #[test]
    fn only_what_is_unseen_without_a_break_counts() {
        assert_eq!(after(&[true; 21]).unseen_s(Seconds(102.0)), None, "not yet beyond");
        assert!(
            after(&[true; 21]).unseen_s(Seconds(102.1)).is_some_and(|(age_s, limit_s)| {
                (age_s - 2.1).abs() < 1e-9 && (limit_s - 2.0).abs() < 1e-9
            })
        );
        let mut once = [true; 30];
        once[15] = false;
        assert_eq!(after(&once).unseen_s(Seconds(103.0)), None, "seen meanwhile");
        assert_eq!(after(&[false; 30]).unseen_s(Seconds(200.0)), None);
    }

    #[test]
    fn time_that_nobody_had_and_a_clock_set_back_count_for_nothing() {
        let mut check = after(&[true; 15]);
        check.forgive(Seconds(111.4), Seconds(10.0));
        assert_eq!(check.unseen_s(Seconds(111.9)), None, "1.9 s beside the 10 s");
        assert!(check.unseen_s(Seconds(112.1)).is_some());
        check.forgive(Seconds(61.4), Seconds(-50.0));
        assert!(check.unseen_s(Seconds(62.1)).is_some(), "as old as it was");
        check.look(Seconds(50.0), true);
        assert_eq!(check.unseen_s(Seconds(51.9)), None, "from ahead of the clock: anew");
    }
}
