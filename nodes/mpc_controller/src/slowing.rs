//! Path speed while a dip of the flow passes by itself.
//!
//! While the encoder vouches for the feed, a section that jumped comes back with the lag of the melt
//! ([`models::transient`]): more feed now would be too much then. The same feed over time along a slower path gives the road
//! its section at once, and speeds up again as the flow comes back. What is made up for is measured anew with each frame
//! and fades between them, so that nothing winds up.

use crate::params::RawDeadband;
use std::collections::VecDeque;

/// What is less is left alone `[-]`.
const LEAST: f64 = 1e-3;

/// Statuses kept to meet a frame: 2 s at 50 Hz.
const STATUSES: usize = 100;

/// Least and largest value.
pub(crate) type Range = (f64, f64);

/// How much slower the path runs than the plan wants, for a dip of the flow that passes.
#[derive(Debug, Clone, Default)]
pub(crate) struct Slowing {
    /// Time and factor that was in force, newest last.
    in_force: VecDeque<(f64, f64)>,
    /// Share of the flow that was lacking, and when `[-]`, `[s]`.
    lacking: f64,
    at_s: f64,
    /// Factor on the plan's speed less one `[-]`.
    speed: f64,
    /// The plan's speed when this was last moved `[-]`.
    planned: f64,
}

impl Slowing {
    /// Nothing passes; what was in force stays known.
    pub(crate) fn forget(&mut self) {
        (self.lacking, self.speed) = (0.0, 0.0);
    }

    /// What lacked is being pushed.
    pub(crate) fn on_push(&mut self) {
        self.lacking = 0.0;
    }

    /// Factor on the plan's speed `[-]`, > 0; the feed per path is divided by it.
    pub(crate) fn factor(&self) -> f64 {
        1.0 + self.speed
    }

    /// Whether the path is not at the plan's speed.
    pub(crate) fn is_active(&self) -> bool {
        self.speed != 0.0
    }

    /// The speed in force at `stamp_s` over the plan's `[-]`.
    pub(crate) fn on_status(&mut self, stamp_s: f64, factor: f64) {
        if self.in_force.len() == STATUSES {
            self.in_force.pop_front();
        }
        self.in_force.push_back((stamp_s, factor));
    }

    /// A road whose section was off by `error` at `exposed_s` `[-]`, by a dip that passes. A dip begins where more than
    /// `least` lacks: what the noise of widths makes of a sound road is less.
    pub(crate) fn on_section(&mut self, exposed_s: f64, error: f64, least: f64, band: &RawDeadband) {
        let lacking = self.lacking(exposed_s, error);
        if self.lacking != 0.0 || lacking.abs() > least {
            (self.lacking, self.at_s) = (band.relative(lacking), exposed_s);
        }
    }

    /// Share of the flow that lacked at `exposed_s` in a road whose section was off by `error`, at the speed in force then `[-]`.
    pub(crate) fn lacking(&self, exposed_s: f64, error: f64) -> f64 {
        let later = self.in_force.partition_point(|(stamp_s, _)| *stamp_s <= exposed_s);
        let factor = later.checked_sub(1).map_or(1.0, |index| self.in_force[index].1);
        1.0 - (1.0 + error) * factor
    }

    /// Moves on to `now_s`, within `range` and by `most` at most, the part of it taken that the plan's speed `planned` has
    /// moved itself. What lacks fades with `fade_s` > 0, and `share` of it is made up for.
    pub(crate) fn advance(
        &mut self,
        now_s: f64,
        (fade_s, share): (f64, f64),
        (range, most): (Range, f64),
        planned: f64,
    ) {
        let lacking = self.lacking * (-(now_s - self.at_s).max(0.0) / fade_s).exp();
        let wanted = (-share * lacking).clamp(range.0.min(0.0), range.1.max(0.0));
        let passed = wanted.abs() < LEAST;
        if passed {
            // The next one has to begin anew.
            self.lacking = 0.0;
        }
        let wanted = if passed { 0.0 } else { wanted };
        let room = (most - (planned - self.planned).abs() * self.factor()).max(0.0) / (1.0 + planned);
        self.planned = planned;
        self.speed += (wanted - self.speed).clamp(-room, room);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FADE_S: f64 = 1.25;
    const WIDE: Range = (-0.2, 0.15);
    /// A dip begins at 5 %, and nothing of it is left alone.
    const LEAST_DIP: f64 = 0.05;
    const BAND: RawDeadband = RawDeadband { start: 0.0, full: 0.01, start_k: 2.0, full_k: 4.0 };

    /// Steps of 50 ms up to `until_s`; what is told is in force at once.
    fn run(slowing: &mut Slowing, from_s: f64, until_s: f64, most: f64) -> f64 {
        let mut now_s = from_s;
        while now_s < until_s - 1e-9 {
            now_s += 0.05;
            slowing.advance(now_s, (FADE_S, 1.0), (WIDE, most), 0.0);
            slowing.on_status(now_s, slowing.factor());
        }
        slowing.factor() - 1.0
    }

    #[test]
    fn a_thin_road_slows_the_path_by_as_much_and_less_as_it_passes() {
        let mut slowing = Slowing::default();
        slowing.on_section(0.0, -0.12, LEAST_DIP, &BAND);
        assert!((run(&mut slowing, 0.0, 0.05, 1.0) + 0.12 * (-0.05 / FADE_S).exp()).abs() < 1e-9);
        assert!((run(&mut slowing, 0.05, 1.25, 1.0) + 0.12 * (-1.0_f64).exp()).abs() < 1e-9);
        assert!(slowing.is_active());
        assert!(run(&mut slowing, 1.25, 9.0, 1.0).abs() < f64::EPSILON && !slowing.is_active());
    }

    /// The flow comes back by itself: a frame that shows a sound road at a slow path tells of what still lacks.
    #[test]
    fn what_the_slow_path_makes_good_still_lacks() {
        let mut slowing = Slowing::default();
        slowing.on_section(0.0, -0.1, LEAST_DIP, &BAND);
        let speed = run(&mut slowing, 0.0, 0.5, 1.0);
        slowing.on_section(0.5, 0.0, LEAST_DIP, &BAND);
        slowing.advance(0.5, (FADE_S, 1.0), (WIDE, 1.0), 0.0);
        assert!((slowing.factor() - 1.0 - speed).abs() < 1e-9);
    }

    /// Behind a push nothing lacks, and the path goes back to the plan's speed.
    #[test]
    fn what_is_pushed_slows_no_more() {
        let mut slowing = Slowing::default();
        slowing.on_section(0.0, -0.12, LEAST_DIP, &BAND);
        assert!(run(&mut slowing, 0.0, 0.2, 1.0) < -0.09);
        slowing.on_push();
        assert!(run(&mut slowing, 0.2, 0.25, 1.0).abs() < f64::EPSILON);
    }

    #[test]
    fn what_is_no_dip_begins_none_and_what_is_left_of_one_is_followed() {
        let mut slowing = Slowing::default();
        slowing.on_section(0.0, -0.04, LEAST_DIP, &BAND);
        assert!(run(&mut slowing, 0.0, 0.1, 1.0).abs() < f64::EPSILON);
        slowing.on_section(0.1, -0.06, LEAST_DIP, &BAND);
        assert!(run(&mut slowing, 0.1, 0.2, 1.0) < -0.05);
        slowing.on_section(0.2, 0.02, LEAST_DIP, &BAND);
        assert!((-0.045..-0.035).contains(&run(&mut slowing, 0.2, 0.25, 1.0)), "{}", slowing.factor());
    }

    #[test]
    fn after_a_dip_the_next_one_has_to_begin_anew() {
        let mut slowing = Slowing::default();
        slowing.on_section(0.0, -0.12, LEAST_DIP, &BAND);
        run(&mut slowing, 0.0, 9.0, 1.0);
        slowing.on_section(9.0, -0.04, LEAST_DIP, &BAND);
        assert!(run(&mut slowing, 9.0, 9.1, 1.0).abs() < f64::EPSILON);
    }

    #[test]
    fn it_moves_by_its_rate_within_its_range_beside_the_plan() {
        let mut slowing = Slowing::default();
        slowing.on_section(0.0, -0.9, LEAST_DIP, &BAND);
        assert!((run(&mut slowing, 0.0, 0.05, 0.01) + 0.01).abs() < 1e-12);
        assert!((run(&mut slowing, 0.05, 1.0, 0.05) + 0.2).abs() < 1e-12, "no slower than its range");
        slowing.forget();
        slowing.on_section(1.0, -0.9, LEAST_DIP, &BAND);
        slowing.advance(1.0, (FADE_S, 1.0), (WIDE, 0.05), 0.03);
        let both = 1.03 * slowing.factor();
        assert!(
            (both - 1.0 - (0.03 - 0.02)).abs() < 1e-12,
            "the plan's own move takes a part of the rate: {both}"
        );
    }
}
