//! P1, P2 where a stream flickers: a balance that begins anew over and over judges nothing.
//!
//! Readings or orders of which most are lost come often enough to be no silence (S7), and too seldom for a balance.

use models::units::Seconds;

/// Time in which a balance that runs finds a heater that is at fault `[s]`: shorter moments judge nothing.
const MOMENT_S: f64 = 3.0;

/// Watches the balance of one heater.
#[derive(Debug, Clone)]
pub struct UnjudgedCheck {
    limit_s: f64,
    /// When the heater was known to be sound last, or not in use.
    judged: Option<Seconds>,
    /// Since when its balance has run.
    runs_since: Option<Seconds>,
}

impl UnjudgedCheck {
    /// A heater in use may go unjudged for `limit_s` `[s]`.
    #[must_use]
    pub fn new(limit_s: f64) -> Self {
        Self { limit_s, judged: None, runs_since: None }
    }

    /// Takes whether the heater is in use, and whether its balance would show a fault.
    pub fn look(&mut self, now: Seconds, in_use: bool, judges: bool) {
        let begins = self.judged.is_none_or(|judged| judged > now);
        if begins || !judges {
            self.runs_since = None;
        }
        let since = if judges { *self.runs_since.get_or_insert(now) } else { now };
        if begins || !in_use || (now - since).0 >= MOMENT_S {
            self.judged = Some(now);
        }
    }

    /// Time in which the supervisor itself stood still does not count; a clock that was set back takes the times with it.
    pub fn forgive(&mut self, now: Seconds, gap: Seconds) {
        let moved = |since: Seconds| Seconds((since + gap).0.min(now.0));
        (self.judged, self.runs_since) = (self.judged.map(moved), self.runs_since.map(moved));
    }

    /// For how long nothing has been judged, and what is allowed `[s]`; `None` where that is not too long.
    #[must_use]
    pub fn unjudged_s(&self, now: Seconds) -> Option<(f64, f64)> {
        let age_s = (now - self.judged?).0;
        (age_s > self.limit_s).then_some((age_s, self.limit_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Looks ten times a second; when it trips `[s]`.
    fn tripped_s(look: impl Fn(f64) -> (bool, bool)) -> Option<f64> {
        let mut check = UnjudgedCheck::new(20.0);
        (0..600_u32).map(|tick| 0.1 * f64::from(tick)).find(|time_s| {
            let (in_use, judges) = look(*time_s);
            check.look(Seconds(100.0 + time_s), in_use, judges);
            check.unjudged_s(Seconds(100.0 + time_s)).is_some()
        })
    }

    #[test]
    fn a_heater_in_use_is_judged_within_the_limit_or_is_told() {
        assert!(tripped_s(|_| (true, false)).is_some_and(|time_s| (20.0..20.3).contains(&time_s)));
        assert_eq!(tripped_s(|_| (false, false)), None, "it does not heat");
        assert_eq!(tripped_s(|time_s| (true, time_s % 19.0 < 3.2)), None);
        let once = tripped_s(|time_s| (true, (10.0..13.25).contains(&time_s)));
        assert!(once.is_some_and(|time_s| (33.0..33.5).contains(&time_s)), "{once:?}");
        let moments = tripped_s(|time_s| (true, time_s % 4.0 < 2.8));
        assert!(moments.is_some_and(|time_s| (20.0..20.3).contains(&time_s)), "{moments:?}");
    }

    #[test]
    fn time_set_back_begins_anew() {
        let mut check = UnjudgedCheck::new(20.0);
        check.look(Seconds(100.0), true, false);
        check.look(Seconds(50.0), true, false);
        assert_eq!(check.unjudged_s(Seconds(70.0)), None);
        assert!(
            check.unjudged_s(Seconds(70.5)).is_some_and(|(age_s, limit_s)| age_s > 20.0 && limit_s < 20.1)
        );
    }
}
