//! When the filter turns: by a timer, and at once on a sample, so that what it tells does not wait for the timer.

use models::units::Seconds;

/// Periods between a sample and the two turns of the timer that follow it: neither must come just before the next sample.
/// A clock that is read every 20 ms shows 80 to 120 ms between samples that come every 100 ms; a timer of 50 ms turns after
/// 62.5 to 82.5 ms then, and not before 130 ms again. A sensor that falls silent leaves the timer its period.
const LATER: [f64; 2] = [1.25, 2.6];
/// Share of the period that lies between two answers at least: a flood of samples is not answered one by one.
const LEAST: f64 = 0.25;

/// Times of turns and answers on the node's clock.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pace {
    period: Seconds,
    turned_at: Seconds,
    answered_at: Seconds,
    /// When the first sample came that waits for an answer.
    asked_at: Option<Seconds>,
    /// When the sample came that was answered last, and turns since.
    sample_at: Seconds,
    turns: usize,
}

impl Pace {
    /// No turn yet; the timer has this period.
    #[must_use]
    pub(crate) fn new(period: Seconds) -> Self {
        let never = Seconds(f64::NEG_INFINITY);
        let (asked_at, turns) = (None, LATER.len());
        Self { period, turned_at: never, answered_at: never, asked_at, sample_at: never, turns }
    }

    /// A sample has come: `None` where it is answered by a turn now, else how long the timer's turn is put off, which then
    /// answers it. It waits where another one has just been answered, and where the clock shows the time of a turn: two
    /// estimates of one moment are one too many.
    #[must_use]
    pub(crate) fn asked(&mut self, now: Seconds) -> Option<Seconds> {
        self.follow(now);
        self.asked_at.get_or_insert(now);
        let since_s = if now > self.turned_at { (now - self.answered_at).0 } else { 0.0 };
        let early_s = LEAST * self.period.0 - since_s;
        (early_s > 0.0).then_some(Seconds(early_s))
    }

    /// The filter has turned: how long the timer is put off, where a sample came lately. Counted from the sample, not from
    /// its answer: else one that had to wait would draw the timer onto the next.
    #[must_use]
    pub(crate) fn turned(&mut self, now: Seconds) -> Option<Seconds> {
        self.follow(now);
        self.turned_at = now;
        if let Some(asked_at) = self.asked_at.take() {
            (self.answered_at, self.sample_at, self.turns) = (now, asked_at, 0);
        }
        let periods = LATER.get(self.turns)?;
        self.turns += 1;
        let after = self.sample_at + Seconds(periods * self.period.0) - now;
        (after.0 > 0.0).then_some(after)
    }

    /// Where time was set back, what was before means nothing any more.
    fn follow(&mut self, now: Seconds) {
        if now < self.turned_at {
            *self = Self::new(self.period);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A timer of 50 ms, first due together with the first sample.
    struct Turning {
        pace: Pace,
        due_s: f64,
        turns: u32,
        waits: u32,
    }

    impl Turning {
        fn look(&mut self, now: Seconds) {
            if now.0 >= self.due_s {
                self.due_s += self.pace.period.0;
                self.turn(now);
            }
        }

        fn turn(&mut self, now: Seconds) {
            self.turns += 1;
            self.due_s = self.pace.turned(now).map_or(self.due_s, |after| (now + after).0);
        }

        fn sample(&mut self, now: Seconds) {
            if let Some(after) = self.pace.asked(now) {
                self.due_s = (now + after).0;
            } else {
                self.turn(now);
            }
        }
    }

    /// A clock that is read every 20 ms, and 100 samples, one every 100 ms, that come just after a reading; each seventh
    /// comes just before it, and sees the one before.
    fn turning() -> Turning {
        let mut turning = Turning { pace: Pace::new(Seconds(0.05)), due_s: 0.1, turns: 0, waits: 0 };
        let mut readings = (1..).map(|reading| 0.02 * f64::from(reading));
        for number in 1..=100 {
            for now_s in readings.by_ref() {
                let comes = now_s >= 0.1 * f64::from(number) - 1e-9;
                if comes && number % 7 == 0 {
                    turning.sample(Seconds(now_s - 0.02));
                }
                turning.look(Seconds(now_s));
                if comes {
                    if number % 7 != 0 {
                        turning.sample(Seconds(now_s));
                    }
                    turning.waits += u32::from(turning.pace.asked_at.is_some());
                    break;
                }
            }
        }
        turning
    }

    /// Where the timer falls together with the first sample, that one waits for the next reading; those after it must not.
    /// Two estimates a sample of 10 Hz are 20 Hz.
    #[test]
    fn no_sample_waits_but_one_that_meets_the_timer_at_the_start() {
        let Turning { waits, turns, .. } = turning();
        assert!(waits <= 1 && turns >= 199, "{waits} wait, {turns} estimates");
    }

    /// 62.5 and 130 ms after the last sample, then every 50 ms.
    #[test]
    fn a_sensor_that_falls_silent_leaves_the_timer_its_period() {
        let mut pace = Pace::new(Seconds(0.05));
        assert_eq!(pace.asked(Seconds(1.0)), None);
        for (now_s, wanted_s) in [(1.0, 0.0625), (1.0625, 0.0675), (1.13, 0.0)] {
            let after_s = pace.turned(Seconds(now_s)).map_or(0.0, |after| after.0);
            assert!((after_s - wanted_s).abs() < 1e-9, "{after_s} s after {now_s} s");
        }
    }

    #[test]
    fn a_sample_just_after_a_turn_of_the_timer_is_answered_where_the_clock_has_moved() {
        let mut pace = Pace::new(Seconds(0.05));
        assert_eq!(pace.turned(Seconds(1.0)), None);
        assert!(pace.asked(Seconds(1.0)).is_some(), "an estimate of this moment is out");
        assert_eq!(pace.asked(Seconds(1.001)), None);
    }

    #[test]
    fn where_time_is_set_back_the_timer_is_put_off_by_no_more_than_ever() {
        let mut pace = Pace::new(Seconds(0.05));
        assert_eq!(pace.asked(Seconds(100.0)), None);
        assert!(pace.turned(Seconds(100.0)).is_some());
        assert_eq!(pace.turned(Seconds(1.0)), None);
        assert_eq!(pace.asked(Seconds(1.001)), None);
        assert!(pace.turned(Seconds(1.001)).is_some_and(|after| after.0 < 0.07));
    }

    /// 12.5 ms lie between two answers, however many ask.
    #[test]
    fn a_flood_is_answered_once_a_quarter_of_the_period() {
        let mut pace = Pace::new(Seconds(0.05));
        let mut answers = 0;
        for millisecond in 0..100 {
            let now = Seconds(1.0 + 1e-3 * f64::from(millisecond));
            if pace.asked(now).is_none() {
                answers += 1;
                assert!(pace.turned(now).is_some());
            }
        }
        assert_eq!(answers, 8);
    }
}
