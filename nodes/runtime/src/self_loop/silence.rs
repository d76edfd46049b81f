//! How long the own messages have been away.

use models::units::Seconds;

/// Most that one pass of the watchdog counts as silence: a pass that comes late was not scheduled `[s]`.
const MOST_PER_PASS_S: f64 = 0.3;
/// Silence that ends the process `[s]`: with the fourth pass in which nothing was heard, within 1 s (C5) and a pass.
const LIMIT: Seconds = Seconds(0.9);
/// The same in the first [`YOUNG`] of a process: many that start at once keep each other busy with discovery, and one that
/// ends for that and is started again keeps them busier.
const YOUNG_LIMIT: Seconds = Seconds(3.0);
const YOUNG: Seconds = Seconds(6.0);
/// Silence allowed before the first number came back: many participants discover each other in 5 s `[s]`.
const START_LIMIT: Seconds = Seconds(15.0);

/// Adds up the time without an own message, as far as the watchdog ran.
#[derive(Debug)]
pub(super) struct Silence {
    last_pass: Seconds,
    silent: Seconds,
    established: bool,
    begin: Seconds,
}

impl Silence {
    pub(super) fn new(now: Seconds) -> Self {
        Self { last_pass: now, silent: Seconds(0.0), established: false, begin: now }
    }

    /// Nothing was ever heard, for this long.
    pub(super) fn is_unbroken(&self, limit: Seconds) -> bool {
        !self.established && self.silent > limit
    }

    /// One pass of the watchdog; true where the limit is passed.
    pub(super) fn pass(&mut self, now: Seconds, heard: bool) -> bool {
        let gap_s = (now - self.last_pass).0.min(MOST_PER_PASS_S);
        self.last_pass = now;
        if heard {
            self.established = true;
            self.silent = Seconds(0.0);
            return false;
        }
        self.silent = self.silent + Seconds(gap_s);
        let limit = match self.established {
            false => START_LIMIT,
            true if now - self.begin < YOUNG => YOUNG_LIMIT,
            true => LIMIT,
        };
        self.silent > limit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Passes every 0.25 s from `from` on, none heard, until the limit is passed; yields the time.
    fn ends_after(silence: &mut Silence, from: f64) -> f64 {
        (1..1000).map(|i| from + 0.25 * f64::from(i)).find(|now| silence.pass(Seconds(*now), false)).unwrap()
    }

    /// C5: dead event loops are noticed within 1 s (and one pass).
    #[test]
    fn silence_ends_the_process_after_its_limit() {
        let mut silence = Silence::new(Seconds(0.0));
        assert!(!silence.pass(Seconds(20.0), true));
        let ended = ends_after(&mut silence, 20.0);
        assert!((20.95..=21.05).contains(&ended), "{ended}");
    }

    /// A process that was stopped for 5 s is judged by what follows, not by the stop.
    #[test]
    fn a_pass_that_was_not_scheduled_counts_little() {
        let mut silence = Silence::new(Seconds(0.0));
        silence.pass(Seconds(0.2), true);
        assert!(!silence.pass(Seconds(5.2), false));
        assert!(!silence.pass(Seconds(5.4), true));
    }

    /// Twenty that start at once do not end each other by their discovery.
    #[test]
    fn a_young_process_has_more_time() {
        let mut silence = Silence::new(Seconds(0.0));
        assert!(!silence.pass(Seconds(0.2), true));
        let ended = ends_after(&mut silence, 0.2);
        assert!((3.2..=3.5).contains(&ended), "{ended}");
    }

    /// Only one that was never heard is alone for want of an echo.
    #[test]
    fn an_echo_is_for_what_was_never_heard() {
        let mut silence = Silence::new(Seconds(0.0));
        (1..60).for_each(|tenths| _ = silence.pass(Seconds(0.1 * f64::from(tenths)), false));
        assert!(silence.is_unbroken(Seconds(5.0)));
        silence.pass(Seconds(6.0), true);
        (61..160).for_each(|tenths| _ = silence.pass(Seconds(0.1 * f64::from(tenths)), false));
        assert!(!silence.is_unbroken(Seconds(5.0)));
    }

    #[test]
    fn discovery_has_more_time() {
        let ended = ends_after(&mut Silence::new(Seconds(0.0)), 0.0);
        assert!((15.0..=15.25).contains(&ended), "{ended}");
    }
}
