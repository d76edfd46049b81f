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
/// What is pushed so for longer than a stroke, with nothing drawn out before, passes an empty tube that nobody saw emptied,
/// or more is pushed than melts: between no heat and all that a nozzle takes, half of it `[-]`.
const LOAD_SHARE: f64 = 0.5;

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
    /// Pushed faster than any nozzle melts without a rest `[m]`.
    rushed_m: f64,
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
            rushed_m: 0.0,
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
        let melted_m = LOAD_M_S * (stamp - then).0;
        let rushes = moved_m > melted_m;
        self.rushed_m = if rushes { (self.rushed_m + moved_m).min(OUT_MAX_M) } else { 0.0 };
        if rushes && out_m > STROKE_MAX_M {
            return pushed_m;
        }
        if self.rushed_m > STROKE_MAX_M {
            return pushed_m + LOAD_SHARE * melted_m;
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
mod tests;
