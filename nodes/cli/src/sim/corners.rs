//! Width error where the file's speed changes: the part of a print that pressure advance can help.
//!
//! What a trim of the speed adds is none of it: the same deposits count, however a print is corrected.

use std::collections::VecDeque;

/// Deposits this near to a change of speed, before or after it, count as a corner `[s]`.
pub const CORNER_S: f64 = 0.2;
/// An acceleration of the file's path above this is a change of speed `[m/s2]`: planners use 0.1 and more, and what rounding
/// makes of a constant speed over a step of 1 ms is below 1e-12.
const ACCELERATION_M_S2: f64 = 0.01;

/// Squared width errors near changes of speed, weighted by time.
#[derive(Debug, Clone, Default)]
pub struct Corners {
    /// Time and squared error of deposits that may yet turn out to lie before a change.
    waiting: VecDeque<(f64, f64)>,
    changed_s: Option<f64>,
    before_m_s: Option<f64>,
    squares_s: f64,
    time_s: f64,
}

impl Corners {
    /// A step in which no road was laid: the speed of the next road is not a change of this one's.
    pub fn pass(&mut self) {
        self.before_m_s = None;
    }

    /// A step of a road at `now_s`: the file's speed of the tool, without any trim, and relative error of the width.
    pub fn add(&mut self, now_s: f64, speed_m_s: f64, error: f64, dt_s: f64) {
        let before_m_s = self.before_m_s.replace(speed_m_s);
        if before_m_s.is_some_and(|before_m_s| (speed_m_s - before_m_s).abs() > ACCELERATION_M_S2 * dt_s) {
            self.changed_s = Some(now_s);
            for (_, square) in self.waiting.drain(..) {
                self.squares_s += square * dt_s;
                self.time_s += dt_s;
            }
        }
        while self.waiting.front().is_some_and(|(at_s, _)| now_s - at_s > CORNER_S) {
            self.waiting.pop_front();
        }
        if self.changed_s.is_some_and(|changed_s| now_s - changed_s <= CORNER_S) {
            self.squares_s += error * error * dt_s;
            self.time_s += dt_s;
        } else {
            self.waiting.push_back((now_s, error * error));
        }
    }

    /// Root of the mean square; `None` where no speed has changed.
    #[must_use]
    pub fn rms(&self) -> Option<f64> {
        (self.time_s > 0.0).then(|| (self.squares_s / self.time_s).sqrt())
    }

    /// Time that counts as corners `[s]`.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.time_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speed steps at 1 s; the error is 0.1 within 0.1 s of it and 0.5 beyond 0.3 s: only the former and nothing between
    /// counts, 0.2 s of 0.4 s.
    #[test]
    fn only_what_is_near_a_change_counts() {
        let mut corners = Corners::default();
        for step in 0..2000_u32 {
            let now_s = f64::from(step) * 1e-3;
            let away_s = (now_s - 1.0).abs();
            let error = if away_s < 0.1 {
                0.1
            } else if away_s > 0.3 {
                0.5
            } else {
                0.0
            };
            corners.add(now_s, if now_s < 1.0 { 0.02 } else { 0.04 }, error, 1e-3);
        }
        // 0.1^2 over half of the time: 0.0707; a step more or less at each end is 1 % of it.
        assert!((corners.rms().unwrap() - 0.0707).abs() < 1e-3, "{:?}", corners.rms());
        assert!((corners.time_s() - 0.4).abs() < 5e-3);
    }

    /// `M204 S100` under `M220 S50`: a planner that ramps at 0.1 m/s2, at half of the speed and in twice the time.
    #[test]
    fn the_slowest_ramp_of_a_planner_is_a_change() {
        let mut corners = Corners::default();
        for step in 0..100_u32 {
            let now_s = f64::from(step) * 1e-3;
            corners.add(now_s, 0.02 + 0.025 * now_s, 1.0, 1e-3);
        }
        assert!((corners.time_s() - 0.1).abs() < 1e-9, "{}", corners.time_s());
    }

    #[test]
    fn constant_speed_and_the_start_of_a_road_are_no_corner() {
        let mut corners = Corners::default();
        for step in 0..100_u32 {
            corners.add(f64::from(step) * 1e-3, 0.02, 1.0, 1e-3);
        }
        corners.pass();
        corners.add(1.0, 0.05, 1.0, 1e-3);
        assert_eq!(corners.rms(), None);
    }
}
