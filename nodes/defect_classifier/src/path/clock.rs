//! From the node's clock to the slicer's plan and back: a speed trim stretches the moves, a pause stops them.

use std::collections::VecDeque;

/// Time along the plan against the node's clock, from the printer's statuses. Bounded.
#[derive(Debug, Clone)]
pub(crate) struct PlanClock {
    /// `(stamp, path time)`, both rising `[s]`.
    points: VecDeque<(f64, f64)>,
    points_max: usize,
    ahead_max_s: f64,
}

impl PlanClock {
    pub(crate) fn new(points_max: usize, ahead_max_s: f64) -> Self {
        Self { points: VecDeque::with_capacity(points_max), points_max, ahead_max_s }
    }

    /// Takes a status; false where it is not later than the last, or the plan went back.
    pub(crate) fn push(&mut self, stamp_s: f64, path_s: f64) -> bool {
        if let Some(&(last_s, last_path_s)) = self.points.back()
            && (stamp_s <= last_s || path_s < last_path_s)
        {
            return false;
        }
        if self.points.len() == self.points_max {
            self.points.pop_front();
        }
        self.points.push_back((stamp_s, path_s));
        true
    }

    pub(crate) fn newest_s(&self) -> Option<f64> {
        self.points.back().map(|point| point.0)
    }

    /// Path time at a stamp: interpolated, and carried on at the last pace for a bounded time.
    pub(crate) fn path_s(&self, stamp_s: f64) -> Option<f64> {
        let after = self.points.partition_point(|point| point.0 < stamp_s);
        if after == self.points.len() {
            let ahead_s = stamp_s - self.newest_s()?;
            let (from, to) = (self.points.get(after.checked_sub(2)?)?, self.points.get(after - 1)?);
            return (ahead_s <= self.ahead_max_s).then(|| to.1 + slope(*from, *to) * ahead_s);
        }
        if after == 0 {
            let first = self.points.front()?;
            // Equality alone counts as inside.
            return (first.0 <= stamp_s).then_some(first.1);
        }
        let (from, to) = (*self.points.get(after - 1)?, *self.points.get(after)?);
        Some(from.1 + slope(from, to) * (stamp_s - from.0))
    }

    /// Stamp at which the plan reached `path_s`; the first one where it stood still.
    pub(crate) fn stamp_s(&self, path_s: f64) -> Option<f64> {
        let after = self.points.partition_point(|point| point.1 < path_s);
        if after == 0 {
            let first = self.points.front()?;
            return (first.1 <= path_s).then_some(first.0);
        }
        if after == self.points.len() {
            let (from, to) = (*self.points.get(after.checked_sub(2)?)?, *self.points.get(after - 1)?);
            let pace = slope(from, to);
            let ahead_s = (path_s - to.1) / pace;
            return (pace > 0.0 && ahead_s <= self.ahead_max_s).then_some(to.0 + ahead_s);
        }
        let (from, to) = (*self.points.get(after - 1)?, *self.points.get(after)?);
        Some(from.0 + (path_s - from.1) / slope(from, to))
    }
}

fn slope(from: (f64, f64), to: (f64, f64)) -> f64 {
    (to.1 - from.1) / (to.0 - from.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Full pace for 1 s, then half of it, then a stop of 1 s.
    fn clock() -> PlanClock {
        let mut clock = PlanClock::new(8, 0.1);
        for (stamp_s, path_s) in [(10.0, 2.0), (11.0, 3.0), (12.0, 3.5), (13.0, 3.5), (14.0, 4.5)] {
            assert!(clock.push(stamp_s, path_s));
        }
        clock
    }

    #[test]
    fn a_trim_stretches_the_plan_and_a_pause_stops_it() {
        let clock = clock();
        let path = |stamp_s: f64| clock.path_s(stamp_s).unwrap();
        assert!((path(10.25) - 2.25).abs() < 1e-12 && (path(11.5) - 3.25).abs() < 1e-12);
        assert!((path(12.7) - 3.5).abs() < 1e-12 && (path(14.05) - 4.55).abs() < 1e-12);
        assert_eq!((clock.path_s(9.9), clock.path_s(14.2)), (None, None));
    }

    #[test]
    fn the_way_back_is_the_inverse_where_the_plan_moves() {
        let clock = clock();
        for stamp_s in [10.0, 10.3, 11.7, 13.4, 14.08] {
            let back_s = clock.stamp_s(clock.path_s(stamp_s).unwrap()).unwrap();
            assert!((back_s - stamp_s).abs() < 1e-9, "{stamp_s} {back_s}");
        }
        assert!((clock.stamp_s(3.5).unwrap() - 12.0).abs() < 1e-12);
    }

    #[test]
    fn what_does_not_rise_is_refused_and_the_oldest_makes_room() {
        let mut clock = clock();
        assert!(!clock.push(14.0, 5.0) && !clock.push(15.0, 4.0));
        for step in 1..10 {
            assert!(clock.push(14.0 + f64::from(step), 4.5 + f64::from(step)));
        }
        assert_eq!((clock.path_s(12.0), clock.points.len()), (None, 8));
    }
}
