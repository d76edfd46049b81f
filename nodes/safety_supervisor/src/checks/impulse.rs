//! P8: an impulse at the tool that no commanded move gives: a knock, or lost steps.
//!
//! `residual = |a - g| - a_max`, with `g` a slow mean of the readings (gravity and the mounting's tilt) and `a_max` the
//! most that commanded moves and the structure's own ringing show. Enough samples beyond the limit within a short span
//! are an impulse. It is flagged, never acted upon: whether the print was moved, the camera says (`checks::shift`).

use models::units::Seconds;

use crate::params::ImpulseParams;

/// Watches the accelerations of the tool.
#[derive(Debug, Clone)]
pub struct ImpulseCheck {
    params: ImpulseParams,
    still_m_s2: Option<[f64; 3]>,
    /// Samples beyond the limit in the span that is open, and its start.
    open: Option<(Seconds, u32)>,
    newest: Option<Seconds>,
    flagged: Option<Seconds>,
    unseen: bool,
    total: u64,
}

impl ImpulseCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: ImpulseParams) -> Self {
        Self { params, still_m_s2: None, open: None, newest: None, flagged: None, unseen: false, total: 0 }
    }

    /// Takes evenly spaced samples, gravity included `[m/s2]`; those already seen are left out.
    pub fn on_samples(&mut self, first: Seconds, period: Seconds, samples: &[[f64; 3]]) {
        let mut stamp = first;
        for sample in samples {
            if self.newest.is_none_or(|newest| stamp > newest) {
                self.newest = Some(stamp);
                self.on_sample(stamp, period, *sample);
            }
            stamp = stamp + period;
        }
    }

    fn on_sample(&mut self, stamp: Seconds, period: Seconds, sample: [f64; 3]) {
        let still = *self.still_m_s2.get_or_insert(sample);
        let apart: [f64; 3] = std::array::from_fn(|axis| sample[axis] - still[axis]);
        let magnitude_m_s2 = apart.iter().map(|part| part * part).sum::<f64>().sqrt();
        let limit_m_s2 = self.params.commanded_max_m_s2 + self.params.residual_m_s2;
        if magnitude_m_s2 > limit_m_s2 {
            self.on_beyond(stamp);
        } else {
            // An impulse is no part of what is still.
            let share = (period.0 / self.params.still_s).min(1.0);
            self.still_m_s2 = Some(std::array::from_fn(|axis| still[axis] + share * apart[axis]));
        }
    }

    fn on_beyond(&mut self, stamp: Seconds) {
        let (start, count) = match self.open {
            Some((start, count)) if (stamp - start).0 <= self.params.span_s => (start, count + 1),
            _ => (stamp, 1),
        };
        self.open = Some((start, count));
        let again = self.flagged.is_none_or(|flagged| (stamp - flagged).0 > self.params.apart_s);
        if count >= self.params.samples && again {
            self.flagged = Some(stamp);
            self.unseen = true;
            self.total += 1;
        }
    }

    /// Begins anew; how many there were stays known.
    pub fn reset(&mut self) {
        *self = Self { unseen: self.unseen, total: self.total, ..Self::new(self.params) };
    }

    /// Whether an impulse was flagged since the last call.
    pub fn take(&mut self) -> bool {
        std::mem::take(&mut self.unseen)
    }

    /// Whether the last impulse is no older than `span`.
    #[must_use]
    pub fn recent(&self, now: Seconds, span: Seconds) -> bool {
        self.flagged.is_some_and(|flagged| (now - flagged).0 <= span.0)
    }

    /// Impulses so far.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.total
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Seconds = Seconds(1e-3);

    fn check() -> ImpulseCheck {
        ImpulseCheck::new(ImpulseParams {
            commanded_max_m_s2: 5.0,
            residual_m_s2: 15.0,
            samples: 4,
            span_s: 0.02,
            apart_s: 0.2,
            still_s: 1.0,
        })
    }

    /// A second at rest, then `count` samples of `burst_m_s2` along x.
    fn after(count: usize, burst_m_s2: f64) -> ImpulseCheck {
        let mut check = check();
        check.on_samples(Seconds(0.0), PERIOD, &vec![[0.0, 0.0, 9.81]; 1000]);
        check.on_samples(Seconds(1.0), PERIOD, &vec![[burst_m_s2, 0.0, 9.81]; count]);
        check
    }

    #[test]
    fn a_burst_beyond_all_commanded_moves_is_flagged_once() {
        let mut burst = after(12, 30.0);
        assert!(burst.take() && !burst.take());
        assert_eq!(burst.total(), 1);
        assert!(burst.recent(Seconds(1.5), Seconds(1.0)) && !burst.recent(Seconds(9.0), Seconds(1.0)));
    }

    #[test]
    fn a_spike_and_a_hard_commanded_move_are_none() {
        assert_eq!(after(3, 60.0).total(), 0);
        assert_eq!(after(500, 19.0).total(), 0);
    }

    #[test]
    fn gravity_is_none_whatever_the_mounting() {
        let mut check = check();
        check.on_samples(Seconds(0.0), PERIOD, &[[0.0, -9.81, 0.0]; 500]);
        assert_eq!(check.total(), 0);
    }

    #[test]
    fn samples_that_come_twice_count_once() {
        let mut check = after(3, 60.0);
        check.on_samples(Seconds(1.0), PERIOD, &[[60.0, 0.0, 9.81]; 3]);
        assert_eq!(check.total(), 0);
    }
}
