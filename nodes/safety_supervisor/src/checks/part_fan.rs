//! P4: the part fan's tachometer against what the fan is told.
//!
//! A fan that stands, or nearly, is a fault. One that turns slower than told is weak: that is told, and what the loop
//! corrects has nothing to do with it.

use models::units::Seconds;

use crate::params::PartFanParams;

/// What a person is told of a weak fan.
pub const SLOW: &str =
    "the part fan turns slower than told: clear or replace it; overhangs and bridges may be bad";

/// Watches one fan.
#[derive(Debug, Clone)]
pub struct PartFanCheck {
    params: PartFanParams,
    slow_since: Option<Seconds>,
    standing_since: Option<Seconds>,
    flagged: bool,
}

impl PartFanCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: PartFanParams) -> Self {
        Self { params, slow_since: None, standing_since: None, flagged: false }
    }

    /// Takes the duty `[0, 1]` and the revolutions `[1/s]`; `None` where there is no tachometer.
    pub fn on_speed(&mut self, now: Seconds, duty: f64, speed_1_s: Option<f64>) {
        // Below some duty a fan may not start at all.
        let below = |share: f64| {
            duty >= self.params.duty_min
                && speed_1_s.is_some_and(|speed| speed < share * duty * self.params.full_1_s)
        };
        let since = |was: Option<Seconds>, is: bool| if is { was.or(Some(now)) } else { None };
        self.slow_since = since(self.slow_since, below(self.params.share_min));
        self.standing_since = since(self.standing_since, below(self.params.share_standing));
        self.flagged &= self.slow_since.is_some();
    }

    /// Forgets since when it has been slow.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }

    /// Share of the full flow that the fan gives `[0, 1]`: by its tachometer, else as it is told.
    #[must_use]
    pub fn flow_share(&self, duty: f64, speed_1_s: Option<f64>) -> f64 {
        speed_1_s.map_or(duty, |speed| (speed / self.params.full_1_s).clamp(0.0, 1.0))
    }

    /// Whether it has been slower than told for longer than it takes to spin up.
    #[must_use]
    pub fn is_slow(&self, now: Seconds) -> bool {
        self.lasts(now, self.slow_since)
    }

    /// Whether it has stood, or nearly, for longer than it takes to spin up.
    #[must_use]
    pub fn tripped(&self, now: Seconds) -> bool {
        self.lasts(now, self.standing_since)
    }

    /// True once each time that it has become slow and does not stand.
    pub fn take(&mut self, now: Seconds) -> bool {
        let news = self.is_slow(now) && !self.tripped(now) && !self.flagged;
        self.flagged |= self.is_slow(now);
        news
    }

    fn lasts(&self, now: Seconds, since: Option<Seconds>) -> bool {
        since.is_some_and(|since| (now - since).0 >= self.params.persist_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check() -> PartFanCheck {
        PartFanCheck::new(PartFanParams {
            full_1_s: 80.0,
            duty_min: 0.3,
            share_min: 0.6,
            share_standing: 0.2,
            persist_s: 4.0,
        })
    }

    fn tripped(duty: f64, speed_1_s: Option<f64>, for_s: f64) -> bool {
        let mut check = check();
        check.on_speed(Seconds(10.0), duty, speed_1_s);
        check.on_speed(Seconds(10.0 + for_s), duty, speed_1_s);
        check.tripped(Seconds(10.0 + for_s))
    }

    #[test]
    fn a_weak_fan_is_told_once_and_trips_nothing() {
        let mut check = check();
        let mut told = [0, 0];
        for number in 0..1000_u32 {
            let now = Seconds(10.0 + 0.02 * f64::from(number));
            // Weak for 8 s, sound for 2 s, weak again.
            let speed_1_s = if (400..500).contains(&number) { 75.0 } else { 0.3 * 80.0 };
            check.on_speed(now, 1.0, Some(speed_1_s));
            told[usize::from(number >= 500)] += u32::from(check.take(now));
            assert!(!check.tripped(now));
            assert_eq!(check.is_slow(now), (200..400).contains(&number) || number >= 700, "{number}");
        }
        assert_eq!(told, [1, 1]);
    }

    #[test]
    fn a_fan_that_stands_or_crawls_trips_after_its_spin_up() {
        assert!(!tripped(1.0, Some(0.0), 3.9) && tripped(1.0, Some(0.0), 4.0));
        assert!(tripped(1.0, Some(15.0), 4.0) && !tripped(1.0, Some(17.0), 60.0));
        assert!(
            tripped(0.5, Some(7.0), 4.0) && !tripped(0.5, Some(9.0), 60.0),
            "half the duty, half the speed"
        );
    }

    #[test]
    fn a_fan_at_speed_a_fan_off_and_a_fan_without_tachometer_do_not() {
        assert!(!tripped(1.0, Some(72.0), 60.0));
        assert!(!tripped(0.0, Some(0.0), 60.0));
        assert!(!tripped(0.2, Some(0.0), 60.0));
        assert!(!tripped(1.0, None, 60.0));
    }
}
