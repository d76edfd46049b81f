//! P4: the part fan's tachometer against what the fan is told.

use models::units::Seconds;

use crate::params::PartFanParams;

/// Watches one fan.
#[derive(Debug, Clone)]
pub struct PartFanCheck {
    params: PartFanParams,
    slow_since: Option<Seconds>,
}

impl PartFanCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: PartFanParams) -> Self {
        Self { params, slow_since: None }
    }

    /// Takes the duty `[0, 1]` and the revolutions `[1/s]`; `None` where there is no tachometer.
    pub fn on_speed(&mut self, now: Seconds, duty: f64, speed_1_s: Option<f64>) {
        // Below some duty a fan may not start at all.
        let slow = duty >= self.params.duty_min
            && speed_1_s.is_some_and(|speed| speed < self.params.share_min * duty * self.params.full_1_s);
        self.slow_since = if slow { self.slow_since.or(Some(now)) } else { None };
    }

    /// Forgets since when it has been slow.
    pub fn reset(&mut self) {
        self.slow_since = None;
    }

    /// Share of the full flow that the fan gives `[0, 1]`: by its tachometer, else as it is told.
    #[must_use]
    pub fn flow_share(&self, duty: f64, speed_1_s: Option<f64>) -> f64 {
        speed_1_s.map_or(duty, |speed| (speed / self.params.full_1_s).clamp(0.0, 1.0))
    }

    /// Whether it has been too slow for longer than it takes to spin up.
    #[must_use]
    pub fn tripped(&self, now: Seconds) -> bool {
        self.slow_since.is_some_and(|since| (now - since).0 >= self.params.persist_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tripped(duty: f64, speed_1_s: Option<f64>, for_s: f64) -> bool {
        let mut check = PartFanCheck::new(PartFanParams {
            full_1_s: 80.0,
            duty_min: 0.3,
            share_min: 0.6,
            persist_s: 4.0,
        });
        check.on_speed(Seconds(10.0), duty, speed_1_s);
        check.on_speed(Seconds(10.0 + for_s), duty, speed_1_s);
        check.tripped(Seconds(10.0 + for_s))
    }

    #[test]
    fn a_fan_that_stands_or_crawls_trips_after_its_spin_up() {
        assert!(!tripped(1.0, Some(0.0), 3.9) && tripped(1.0, Some(0.0), 4.0));
        assert!(tripped(1.0, Some(40.0), 4.0));
    }

    #[test]
    fn a_fan_at_speed_a_fan_off_and_a_fan_without_tachometer_do_not() {
        assert!(!tripped(1.0, Some(72.0), 60.0));
        assert!(!tripped(0.0, Some(0.0), 60.0));
        assert!(!tripped(0.2, Some(0.0), 60.0));
        assert!(!tripped(1.0, None, 60.0));
    }
}
