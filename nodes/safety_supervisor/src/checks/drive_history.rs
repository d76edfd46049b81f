//! What the printer said it does, by its own stamps: temperatures and states come over separate streams, late and in
//! bunches on a busy machine, and only their stamps tell what belongs together.

use models::units::Seconds;

use super::heater::Drive;
use super::roughness::Roughness;

/// States kept: 2.5 s at 50 Hz.
const KEPT: usize = 128;

/// Fastest that any extruder pushes filament `[m/s]`; faster is a position that jumped, and no heat follows it.
const FEED_MAX_M_S: f64 = 0.1;

/// Longest stroke back whose return is the same, hot filament `[m]`: a Bowden's retraction and its pressure advance; what is
/// drawn back farther is another filament when it comes again.
const STROKE_MAX_M: f64 = 0.015;

/// Longest way that a filament is drawn out `[m]`.
const OUT_MAX_M: f64 = 3.0;
/// Faster than any nozzle melts, 29 mm3/s: pushed so behind a filament that was drawn out, it passes an empty tube `[m/s]`.
const LOAD_M_S: f64 = 0.012;

/// Period in which a firmware sets the duty `[s]`: of states that come as often nothing is unseen.
const SET_PERIOD_S: f64 = 0.1;
/// Longest time between two states that counts for their period `[s]`.
const PERIOD_MAX_S: f64 = 0.6;
/// States over which their period is smoothed.
const SMOOTHED: f64 = 30.0;

/// Means over a span.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Means {
    /// Heater duty `[0, 1]`.
    pub duty: f64,
    /// Part fan `[0, 1]`.
    pub fan: f64,
    /// Speed of filament that is pushed for the first time `[m/s]`, 0 or more.
    pub feed_m_s: f64,
}

/// Ring of states, oldest first; each holds from its stamp until the next one's.
#[derive(Debug, Clone)]
pub struct DriveHistory {
    ring: [Option<State>; KEPT],
    next: usize,
    /// Filament drawn back and not yet pushed again `[m]`.
    drawn_m: f64,
    /// The same of a filament that was drawn out whole `[m]`.
    out_m: f64,
    /// Of the duty from state to state `[-]`.
    roughness: Roughness,
    /// Mean time between two states `[s]`.
    period_s: f64,
}

/// A state with the filament that was pushed for the first time until then `[m]`.
type State = (Seconds, Drive, f64);

impl Default for DriveHistory {
    fn default() -> Self {
        Self {
            ring: [None; KEPT],
            next: 0,
            drawn_m: 0.0,
            out_m: 0.0,
            roughness: Roughness::new(0.0),
            period_s: SET_PERIOD_S,
        }
    }
}

impl DriveHistory {
    /// Adds a state; one that is not newer than the last replaces nothing, time that jumped back starts anew.
    pub fn push(&mut self, stamp: Seconds, drive: Drive) {
        if let Some((newest, _)) = self.newest() {
            if (newest - stamp).0 > 1.0 {
                *self = Self::default();
            } else if stamp <= newest {
                return;
            } else {
                self.period_s += ((stamp - newest).0.min(PERIOD_MAX_S) - self.period_s) / SMOOTHED;
            }
        }
        self.roughness.on_sample(stamp, Some(drive.duty));
        let pushed_m = self.pushed_m(stamp, &drive);
        self.ring[self.next] = Some((stamp, drive, pushed_m));
        self.next = (self.next + 1) % KEPT;
    }

    /// Density of the duty's noise that passes unseen between two states `[s]`: states that are farther apart than the duty
    /// is set show one of several values, and are taken for all of them.
    #[must_use]
    pub fn unseen_duty2_s(&self) -> f64 {
        self.roughness.deviation().powi(2) * (self.period_s - SET_PERIOD_S).max(0.0)
    }

    /// The newest state.
    #[must_use]
    pub fn newest(&self) -> Option<(Seconds, Drive)> {
        self.last().map(|(stamp, drive, _)| (stamp, drive))
    }

    fn last(&self) -> Option<State> {
        self.ring[(self.next + KEPT - 1) % KEPT]
    }

    /// Pressure advance and retractions push again what they have drawn back: it is hot already. What is loaded reaches no
    /// nozzle before its tube is full.
    fn pushed_m(&mut self, stamp: Seconds, drive: &Drive) -> f64 {
        let Some((then, before, pushed_m)) = self.last() else { return 0.0 };
        let moved_m = drive.motor_position_m - before.motor_position_m;
        // What is drawn back does not slip.
        let moved_m = if moved_m > 0.0 { moved_m * (1.0 - drive.slip) } else { moved_m };
        if !moved_m.is_finite() {
            // counted where it came in; a sum would keep it for ever
            return pushed_m;
        }
        let out_m = self.out_m;
        self.out_m = (out_m - moved_m).clamp(0.0, OUT_MAX_M);
        if out_m > STROKE_MAX_M && moved_m > LOAD_M_S * (stamp - then).0 {
            return pushed_m;
        }
        let returned_m = moved_m.clamp(0.0, self.drawn_m);
        self.drawn_m = (self.drawn_m - returned_m + (-moved_m).max(0.0)).min(STROKE_MAX_M);
        pushed_m + moved_m.max(0.0) - returned_m
    }

    fn entries(&self) -> impl Iterator<Item = State> + '_ {
        (0..KEPT).filter_map(|offset| self.ring[(self.next + offset) % KEPT])
    }

    /// Means over `(from, to]`, the first and the last state held on beyond the ends; `None` without a state or a
    /// span.
    #[must_use]
    pub fn means(&self, from: Seconds, to: Seconds) -> Option<Means> {
        let span_s = (to - from).0;
        let first = self.entries().next()?;
        if span_s <= 0.0 {
            return None;
        }
        let (mut duty_s, mut fan_s) = (0.0, 0.0);
        let mut held = (Seconds(f64::NEG_INFINITY), first.1);
        for (stamp, drive, _) in self.entries().chain([(Seconds(f64::INFINITY), first.1, 0.0)]) {
            let overlap_s = (stamp.0.min(to.0) - held.0.0.max(from.0)).max(0.0);
            duty_s += held.1.duty * overlap_s;
            fan_s += held.1.fan * overlap_s;
            held = (stamp, drive);
        }
        let fed_m = self.fed_m(to)? - self.fed_m(from)?;
        Some(Means {
            duty: duty_s / span_s,
            fan: fan_s / span_s,
            feed_m_s: (fed_m / span_s).clamp(0.0, FEED_MAX_M_S),
        })
    }

    /// Filament pushed for the first time until a moment, between states in proportion.
    fn fed_m(&self, at: Seconds) -> Option<f64> {
        let mut before: Option<(Seconds, f64)> = None;
        for (stamp, _, pushed_m) in self.entries() {
            if stamp >= at {
                let Some((start, from_m)) = before else { return Some(pushed_m) };
                let share = (at - start).0 / (stamp - start).0;
                return Some(from_m + share * (pushed_m - from_m));
            }
            before = Some((stamp, pushed_m));
        }
        before.map(|(_, pushed_m)| pushed_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(duty: f64, motor_position_m: f64) -> Drive {
        Drive { duty, fan: 0.0, motor_position_m, slip: 0.0 }
    }

    #[test]
    fn means_follow_the_stamps_whenever_the_states_came() {
        let mut history = DriveHistory::default();
        for (stamp_s, duty) in [(1.0, 1.0), (1.02, 0.0), (1.06, 1.0)] {
            history.push(Seconds(stamp_s), drive(duty, 0.1 * stamp_s));
        }
        // On for 20 ms, off for 40 ms, on for the last 40 ms: 60 %.
        let means = history.means(Seconds(1.0), Seconds(1.1)).unwrap();
        assert!((means.duty - 0.6).abs() < 1e-12, "{means:?}");
        // The motor went 6 mm in the 60 ms that the states cover.
        assert!((means.feed_m_s - 0.006 / 0.1).abs() < 1e-9, "{means:?}");
    }

    #[test]
    fn an_overtaken_state_is_left_out_and_time_set_back_begins_anew() {
        let mut history = DriveHistory::default();
        history.push(Seconds(100.0), drive(0.1, 0.0));
        for (stamp_s, newest_s) in [(99.5, 100.0), (100.0, 100.0), (99.0, 100.0), (98.9, 98.9), (99.0, 99.0)]
        {
            history.push(Seconds(stamp_s), drive(0.2, 0.0));
            let newest = history.newest().map(|(stamp, _)| stamp);
            assert_eq!(newest, Some(Seconds(newest_s)), "{stamp_s}");
        }
        assert!(
            history.means(Seconds(98.9), Seconds(99.0)).is_some_and(|means| (means.duty - 0.2).abs() < 1e-12)
        );
    }

    /// Fed until now, of states 20 ms apart at these positions.
    fn fed_m(positions_m: &[f64]) -> f64 {
        let mut history = DriveHistory::default();
        for (number, position_m) in (0_u32..).zip(positions_m) {
            history.push(Seconds(0.02 * f64::from(number)), drive(0.0, *position_m));
        }
        history.fed_m(Seconds(1e3)).unwrap()
    }

    /// Pressure advance draws back at each corner what it then pushes: that warms nothing twice. A filament that was drawn out
    /// whole and comes again is cold but for the last 15 mm.
    #[test]
    fn what_was_drawn_back_is_hot_already() {
        assert!((fed_m(&[0.0, 3e-3, 1e-3, 3.5e-3, 1.5e-3, 4e-3]) - 4e-3).abs() < 1e-12);
        // 80 mm at 10 mm/s.
        let again = (1..=400_u32).map(|step| -0.07 + 2e-4 * f64::from(step));
        let positions_m: Vec<f64> = [0.0, 0.01, -0.07].into_iter().chain(again).collect();
        assert!((fed_m(&positions_m) - (0.01 + 0.08 - STROKE_MAX_M)).abs() < 1e-9);
    }

    /// 400 mm out of a Bowden tube, 380 mm in again at 20 mm/s, the rest and as much more at 5 mm/s. What is pushed as fast
    /// with nothing drawn out is on its way to the nozzle.
    #[test]
    fn a_filament_that_is_loaded_takes_no_heat_before_it_is_there() {
        let mut history = DriveHistory::default();
        let (mut stamp_s, mut position_m) = (0.0, 0.0);
        let mut moved = |way_m: f64, speed_m_s: f64| {
            for _ in 0..100 {
                stamp_s += way_m.abs() / speed_m_s / 100.0;
                position_m += way_m / 100.0;
                history.push(Seconds(stamp_s), drive(0.5, position_m));
            }
            history.fed_m(Seconds(1e3)).unwrap()
        };
        let first_m = moved(0.02, 0.02);
        assert!(first_m > 0.0195, "{first_m}");
        assert!((moved(-0.4, 0.05) - first_m).abs() < 1e-12);
        assert!((moved(0.38, 0.02) - first_m).abs() < 1e-12);
        let more_m = moved(0.04, 5e-3) - first_m;
        assert!((0.024..0.0401).contains(&more_m), "{more_m}");
    }

    /// A balance that was told of 1 km in 0.1 s would be lost for ever.
    #[test]
    fn what_the_drive_gear_loses_takes_no_heat() {
        let mut history = DriveHistory::default();
        for (stamp_s, motor_m, slip) in [(1.0, 0.0, 0.0), (2.0, 0.004, 0.3), (3.0, 0.008, 1.0)] {
            history.push(Seconds(stamp_s), Drive { slip, ..drive(0.5, motor_m) });
        }
        let fed = |from_s, to_s| history.means(Seconds(from_s), Seconds(to_s)).unwrap().feed_m_s;
        assert!((fed(1.0, 2.0) - 0.0028).abs() < 1e-12 && fed(2.0, 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_position_that_jumps_feeds_no_faster_than_an_extruder_can() {
        for (jump_m, feed_m_s) in [(1e3, FEED_MAX_M_S), (-1e3, 0.0)] {
            let mut history = DriveHistory::default();
            history.push(Seconds(1.0), drive(0.0, 0.0));
            history.push(Seconds(1.1), drive(0.0, jump_m));
            let means = history.means(Seconds(1.0), Seconds(1.1)).unwrap();
            assert!((means.feed_m_s - feed_m_s).abs() < 1e-12, "{means:?}");
        }
    }

    #[test]
    fn a_state_twice_or_late_changes_nothing_and_a_jump_back_starts_anew() {
        let mut history = DriveHistory::default();
        history.push(Seconds(5.0), drive(1.0, 0.0));
        history.push(Seconds(5.0), drive(0.0, 0.0));
        history.push(Seconds(4.9), drive(0.0, 0.0));
        assert_eq!(history.newest(), Some((Seconds(5.0), drive(1.0, 0.0))));
        history.push(Seconds(1.0), drive(0.5, 0.0));
        assert_eq!(history.entries().count(), 1);
    }

    #[test]
    fn the_ring_keeps_the_newest() {
        let mut history = DriveHistory::default();
        for number in 0..1000_u32 {
            history.push(Seconds(f64::from(number)), drive(0.0, f64::from(number)));
        }
        assert_eq!(history.entries().count(), KEPT);
        assert!((history.fed_m(Seconds(998.5)).unwrap() - 998.5).abs() < 1e-9);
    }
}
