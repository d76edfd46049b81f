//! S10: a reading that steps as no block can, and stays there: a loose contact, another divider, a swapped sensor.
//!
//! A block of known capacity and heater moves at most so fast. A reading that is further off than that, for several
//! samples that agree with each other, has stepped; one that comes back was a spike.

use models::units::{Celsius, Seconds};

use super::pace::{COUNTED_PERIOD_S, SLOW_SAMPLES};
use crate::params::JumpParams;

/// Slowest readings that are judged `[s]`.
const PERIOD_MAX_S: f64 = 1.5;

/// Watches one temperature.
#[derive(Debug, Clone)]
pub struct JumpCheck {
    params: JumpParams,
    /// Last reading that a block can have.
    held: Option<(Seconds, f64)>,
    /// Stamp of the newest reading.
    newest: Option<Seconds>,
    /// Readings in a row that have held: as many as a step needs, or the first ones may be the odd ones.
    agreed: u32,
    apart: Option<Apart>,
}

/// Readings away from the one that has held, which agree with each other.
#[derive(Debug, Clone, Copy)]
struct Apart {
    newest_c: f64,
    /// How far off a block could be when the first of them came `[K]`: that counts for the others, however slowly they come.
    reach_k: f64,
    in_a_row: u32,
    /// Since when `[s]`.
    for_s: f64,
}

impl JumpCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: JumpParams) -> Self {
        Self { params, held: None, newest: None, agreed: 0, apart: None }
    }

    /// Takes a temperature of `stamp`.
    pub fn on_sample(&mut self, stamp: Seconds, temp: Celsius) {
        let Some((then, held_c)) = self.held else {
            (self.held, self.newest) = (Some((stamp, temp.0)), Some(stamp));
            return;
        };
        let gap_s = (stamp - then).0;
        if gap_s <= 0.0 && gap_s > -self.params.gap_max_s {
            return;
        }
        let period_s = self.newest.replace(stamp).map_or(0.0, |newest| (stamp - newest).0);
        let reach_now_k = self.params.step_k + self.params.rate_max_k_s * gap_s;
        let reach_k = self.apart.map_or(reach_now_k, |apart| apart.reach_k);
        let near = (temp.0 - held_c).abs() <= reach_k;
        // Slow readings have to agree as often as it takes.
        let gap_max_s =
            self.params.gap_max_s.max((f64::from(SLOW_SAMPLES) + 0.5) * period_s.min(PERIOD_MAX_S));
        let judged = (0.0..gap_max_s).contains(&gap_s);
        if near || !judged || self.agreed < self.params.samples {
            self.agreed = if near && judged { self.agreed.saturating_add(1) } else { 1 };
            (self.held, self.apart) = (Some((stamp, temp.0)), None);
            return;
        }
        let agrees = |apart: &Apart| (temp.0 - apart.newest_c).abs() <= self.params.step_k;
        self.apart = Some(self.apart.filter(agrees).map_or(
            Apart { newest_c: temp.0, reach_k, in_a_row: 1, for_s: 0.0 },
            |apart| Apart {
                newest_c: temp.0,
                reach_k,
                in_a_row: apart.in_a_row.saturating_add(1),
                for_s: apart.for_s + period_s,
            },
        ));
    }

    /// Whether the newest reading is one that no block can have: what watches the block must not see it.
    #[must_use]
    pub fn is_apart(&self) -> bool {
        self.apart.is_some()
    }

    /// How far the newest reading is off `[K]`; `None` where it is not.
    #[must_use]
    pub fn step_k(&self) -> Option<f64> {
        let (apart, (_, held_c)) = (self.apart?, self.held?);
        Some(apart.newest_c - held_c)
    }

    /// Whether it stepped. It stays so until the gap is too long to be judged: the new level is then taken for what
    /// it is, and only a person's acknowledge ends what was latched meanwhile.
    #[must_use]
    pub fn tripped(&self) -> bool {
        let samples = self.params.samples;
        self.apart.is_some_and(|apart| {
            let slowly =
                apart.in_a_row >= SLOW_SAMPLES && apart.for_s >= f64::from(samples) * COUNTED_PERIOD_S;
            apart.in_a_row >= samples || slowly
        })
    }

    /// Forgets the readings.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(readings_c: &[f64]) -> JumpCheck {
        let mut check =
            JumpCheck::new(JumpParams { step_k: 12.0, rate_max_k_s: 4.0, samples: 8, gap_max_s: 3.0 });
        for (number, temp_c) in readings_c.iter().enumerate() {
            check.on_sample(Seconds(0.1 * number as f64), Celsius(*temp_c));
        }
        check
    }

    #[test]
    fn a_step_that_stays_trips_in_less_than_a_second_either_way() {
        for step_k in [-20.0, 20.0] {
            let mut readings_c = vec![210.0; 9];
            readings_c.extend([210.0 + step_k; 7]);
            assert!(!after(&readings_c).tripped());
            readings_c.push(210.0 + step_k);
            let check = after(&readings_c);
            assert!(check.tripped() && check.is_apart());
            assert_eq!(check.step_k(), Some(step_k));
        }
    }

    /// A 40 W heater with 16.7 J/K rises by 2.4 K/s: 120 K in 50 s, and 0.24 K from sample to sample.
    #[test]
    fn heat_up_and_spikes_are_none() {
        let ramp_c: Vec<f64> = (0..500).map(|number| 25.0 + 0.24 * f64::from(number)).collect();
        assert!(!after(&ramp_c).tripped() && after(&ramp_c).step_k().is_none());
        let spiky_c: Vec<f64> = (0..500).map(|number| if number % 3 == 0 { 240.0 } else { 210.0 }).collect();
        assert!(!after(&spiky_c).tripped());
    }

    /// What was on its way for longer counts for nothing; time that jumped back begins anew.
    #[test]
    fn an_overtaken_reading_is_left_out_and_time_set_back_begins_anew() {
        let mut check = after(&[210.0; 9]);
        for stamp_s in [0.75, 0.0, -2.0] {
            check.on_sample(Seconds(stamp_s), Celsius(240.0));
            assert!(!check.is_apart(), "{stamp_s}");
        }
        check.on_sample(Seconds(0.9), Celsius(240.0));
        assert!(check.is_apart());
        check.on_sample(Seconds(-10.0), Celsius(240.0));
        check.on_sample(Seconds(-9.9), Celsius(240.0));
        assert!(!check.is_apart(), "the level of then is taken for what it is");
    }

    #[test]
    fn a_first_reading_that_is_off_is_no_level() {
        let mut readings_c = vec![0.0];
        readings_c.extend([210.0; 20]);
        assert!(!after(&readings_c).tripped());
    }

    #[test]
    fn a_level_that_lasts_is_taken_for_what_it_is() {
        let mut readings_c = vec![210.0; 9];
        readings_c.extend([240.0; 40]);
        assert!(!after(&readings_c).tripped());
    }

    /// What a block can have done meanwhile counts: 12 K, and 4 K/s over the 2.5 s since the last reading.
    #[test]
    fn a_gap_is_allowed_what_a_heater_does_in_it() {
        for (step_k, apart) in [(21.5, false), (22.5, true), (-21.5, false), (-22.5, true)] {
            let mut check = after(&[210.0; 9]);
            check.on_sample(Seconds(0.8 + 2.5), Celsius(210.0 + step_k));
            assert_eq!(check.is_apart(), apart, "{step_k} K");
        }
    }

    /// Readings of 1 Hz: three that agree, 2 s after the step; two that look alike are spikes.
    #[test]
    fn slow_readings_agree_for_as_long() {
        let mut check = after(&[]);
        let mut take = |number: u32, temp_c: f64| {
            check.on_sample(Seconds(f64::from(number)), Celsius(temp_c));
            check.tripped()
        };
        assert!((0..12).all(|number| !take(number, 210.0)));
        assert!(!take(12, 240.0) && !take(13, 241.0) && !take(14, 210.0));
        assert!(!take(15, 240.0) && !take(16, 240.0) && take(17, 239.0));
    }

    /// A step down by 25 K at 1 Hz, after which the firmware heats: no block would be there after 1 s, whatever comes later.
    #[test]
    fn slow_readings_that_come_back_as_a_block_warms_have_stepped_all_the_same() {
        let mut check = after(&[]);
        for (number, temp_c) in [210.0; 12].into_iter().chain([185.0, 187.0, 189.0]).enumerate() {
            assert!(!check.tripped());
            check.on_sample(Seconds(number as f64), Celsius(temp_c));
        }
        assert!(check.tripped());
    }
}
