//! What the printer did a moment ago: sensors report late, and each at its own time.

use std::collections::VecDeque;

/// Least share that is made up for which tells of strokes `[-]`: that of a sound drive.
const SLIP_TELLING: f64 = 0.01;
/// Longest way back between two reports that is believed `[m]`: a retraction.
const BACK_MAX_M: f64 = 0.01;

/// One status of the printer, as far as the filter needs it later.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    pub(crate) stamp_s: f64,
    pub(crate) motor_m: f64,
    /// Motor without what is made up for the slip.
    pub(crate) wanted_m: f64,
    /// Share of the feed that is made up for.
    pub(crate) slip: f64,
    pub(crate) path_speed_m_s: f64,
    pub(crate) height_m: Option<f64>,
    pub(crate) depositing: bool,
}

/// Values with rising stamps; the oldest makes room.
#[derive(Debug, Clone)]
pub(crate) struct Ring<T> {
    values: VecDeque<T>,
    capacity: usize,
}

impl<T> Ring<T> {
    pub(crate) fn new(capacity: usize) -> Self {
        Self { values: VecDeque::with_capacity(capacity), capacity }
    }

    pub(crate) fn push(&mut self, value: T) {
        if self.values.len() == self.capacity {
            self.values.pop_front();
        }
        self.values.push_back(value);
    }

    pub(crate) fn replace_newest(&mut self, value: T) {
        self.values.pop_back();
        self.values.push_back(value);
    }

    pub(crate) fn clear(&mut self) {
        self.values.clear();
    }

    pub(crate) fn newest(&self) -> Option<&T> {
        self.values.back()
    }

    pub(crate) fn iter(&self) -> impl DoubleEndedIterator<Item = &T> + ExactSizeIterator {
        self.values.iter()
    }

    /// The pair of neighbours around `at_s`; the newest value itself counts as inside.
    fn around(&self, at_s: f64, stamp: impl Fn(&T) -> f64) -> Option<(usize, &T, &T)> {
        let after = self.values.partition_point(|value| stamp(value) < at_s);
        if after == 0 {
            let first = self.values.front()?;
            return (stamp(first) <= at_s).then_some((0, first, first));
        }
        Some((after, self.values.get(after - 1)?, self.values.get(after)?))
    }
}

/// Motor position at a time, and how far the interpolation may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Position {
    pub(crate) motor_m: f64,
    pub(crate) wanted_m: f64,
    pub(crate) error_m: f64,
}

impl Sample {
    pub(crate) fn position(&self) -> Position {
        Position { motor_m: self.motor_m, wanted_m: self.wanted_m, error_m: 0.0 }
    }

    /// Way of the motor's strokes back since a position `[m]`, 0 where nothing tells.
    ///
    /// A report shows what strokes forth and back leave. What is made up for the slip is of those forth alone: a way `F` forth
    /// is made `F s` longer than was wanted.
    pub(crate) fn back_m(&self, since: &Position) -> f64 {
        if self.slip < SLIP_TELLING {
            return 0.0;
        }
        let moved_m = self.motor_m - since.motor_m;
        let forth_m = (moved_m - (self.wanted_m - since.wanted_m)) / self.slip;
        let back_m = forth_m - moved_m;
        if (0.0..=BACK_MAX_M).contains(&back_m) && forth_m >= 0.0 { back_m } else { 0.0 }
    }
}

impl Ring<Sample> {
    /// Motor position at `at_s`, interpolated.
    ///
    /// Between two reports the speed may have changed at any time: the position is known to the change of speed
    /// over the neighbouring intervals times the distance to the nearer report.
    pub(crate) fn motor_at(&self, at_s: f64) -> Option<Position> {
        let (after, left, right) = self.around(at_s, |sample| sample.stamp_s)?;
        let span_s = right.stamp_s - left.stamp_s;
        if span_s <= 0.0 {
            return Some(left.position());
        }
        let speed_m_s = (right.motor_m - left.motor_m) / span_s;
        let change_m_s = [after.checked_sub(2).and_then(|i| self.speed(i)), self.speed(after)]
            .into_iter()
            .flatten()
            .fold(0.0, |most: f64, other| most.max((other - speed_m_s).abs()));
        let nearer_s = (at_s - left.stamp_s).min(right.stamp_s - at_s);
        Some(Position {
            motor_m: left.motor_m + speed_m_s * (at_s - left.stamp_s),
            wanted_m: left.wanted_m + (right.wanted_m - left.wanted_m) * (at_s - left.stamp_s) / span_s,
            error_m: change_m_s * nearer_s,
        })
    }

    /// Motor speed between report `index` and the next `[m/s]`.
    fn speed(&self, index: usize) -> Option<f64> {
        let (left, right) = (self.values.get(index)?, self.values.get(index + 1)?);
        Some((right.motor_m - left.motor_m) / (right.stamp_s - left.stamp_s))
    }

    /// Slowest and fastest motor speed in `[from_s, to_s]`.
    pub(crate) fn speed_range(&self, from_s: f64, to_s: f64) -> Option<(f64, f64)> {
        let mut range = None;
        for index in (0..self.values.len().saturating_sub(1)).rev() {
            let (left, right) = (self.values.get(index)?, self.values.get(index + 1)?);
            if right.stamp_s <= from_s {
                break;
            }
            if left.stamp_s >= to_s {
                continue;
            }
            let speed = self.speed(index)?;
            let (low, high) = range.unwrap_or((speed, speed));
            range = Some((low.min(speed), high.max(speed)));
        }
        range
    }

    /// Path speed and height of the road, if both kept within `spread` from `from_s` to `to_s`.
    pub(crate) fn steady_road(&self, (from_s, to_s): (f64, f64), spread: f64) -> Option<(f64, f64)> {
        let first = self.values.partition_point(|sample| sample.stamp_s <= from_s).checked_sub(1)?;
        let last = self.values.partition_point(|sample| sample.stamp_s < to_s);
        self.values.get(last)?;
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        let height_m = self.values.get(last)?.height_m?;
        for sample in self.values.range(first..=last) {
            let same = sample.height_m.is_some_and(|other| (other - height_m).abs() <= spread * height_m);
            if !sample.depositing || !same {
                return None;
            }
            low = low.min(sample.path_speed_m_s);
            high = high.max(sample.path_speed_m_s);
        }
        (high - low <= spread * high).then_some((0.5 * (low + high), height_m))
    }
}

impl Ring<(f64, f64)> {
    /// Value at `at_s`, interpolated.
    pub(crate) fn value_at(&self, at_s: f64) -> Option<f64> {
        let (_, left, right) = self.around(at_s, |pair| pair.0)?;
        let span_s = right.0 - left.0;
        let share = if span_s > 0.0 { (at_s - left.0) / span_s } else { 0.0 };
        Some(left.1 + share * (right.1 - left.1))
    }

    /// Sum of all steps back in `[from_s, to_s]`, 0 or more.
    pub(crate) fn way_back_m(&self, from_s: f64, to_s: f64) -> f64 {
        let within = self.values.iter().filter(|pair| (from_s..=to_s).contains(&pair.0));
        let mut before_m = None;
        within.fold(0.0, |back_m, pair| {
            let step_m = before_m.replace(pair.1).map_or(0.0, |before_m: f64| before_m - pair.1);
            back_m + step_m.max(0.0)
        })
    }

    /// Newest pair that is not later than `at_s`.
    pub(crate) fn newest_until(&self, at_s: f64) -> Option<(f64, f64)> {
        self.values.iter().rev().find(|pair| pair.0 <= at_s).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(stamp_s: f64, motor_m: f64) -> Sample {
        Sample {
            stamp_s,
            motor_m,
            wanted_m: motor_m,
            slip: 0.0,
            path_speed_m_s: 0.05,
            height_m: Some(2e-4),
            depositing: true,
        }
    }

    #[test]
    fn position_is_exact_at_constant_speed_and_bounded_at_a_change() {
        let mut ring = Ring::new(8);
        for (stamp, motor) in [(0.0, 0.0), (0.02, 0.04), (0.04, 0.08), (0.06, 0.2)] {
            ring.push(sample(stamp, motor));
        }
        let steady = ring.motor_at(0.01).unwrap();
        assert!((steady.motor_m - 0.02).abs() < 1e-12 && steady.error_m < 1e-12);
        // next interval is 4 m/s faster, 5 ms from the nearer report
        let near_change = ring.motor_at(0.035).unwrap();
        assert!((near_change.motor_m - 0.07).abs() < 1e-12);
        assert!((near_change.error_m - 4.0 * 0.005).abs() < 1e-12);
        assert!(ring.motor_at(0.07).is_none() && ring.motor_at(-0.01).is_none());
    }

    /// 1 mm forth, of which 10 % more for the slip, and 0.4 mm back: the motor tells of 0.7 mm.
    #[test]
    fn what_is_made_up_for_tells_of_strokes_back() {
        let (forth_m, back_m) = (1e-3 / 0.9, 0.4e-3);
        let since = sample(0.0, 0.0).position();
        let made_up = Sample { wanted_m: 1e-3 - back_m, slip: 0.1, ..sample(0.02, forth_m - back_m) };
        assert!((made_up.back_m(&since) - back_m).abs() < 1e-12);
        let back_alone = Sample { wanted_m: -back_m, slip: 0.1, ..sample(0.02, -back_m) };
        assert!((back_alone.back_m(&since) - back_m).abs() < 1e-12);
        // a host that makes up for nothing, or for it elsewhere, tells of none
        for (wanted_m, slip) in [(0.6e-3, 0.0), (0.6e-3, 0.002), (forth_m - back_m, 0.1), (0.8e-3, 0.1)] {
            let silent = Sample { wanted_m, slip, ..sample(0.02, forth_m - back_m) };
            assert!(silent.back_m(&since).abs() < 1e-15, "{wanted_m} {slip}");
        }
    }

    #[test]
    fn a_road_is_steady_only_while_speed_and_height_are() {
        let mut ring = Ring::new(8);
        for step in 0..8 {
            let mut sample = sample(f64::from(step) * 0.02, 0.0);
            sample.path_speed_m_s = if step < 5 { 0.05 } else { 0.03 };
            ring.push(sample);
        }
        assert_eq!(ring.steady_road((0.01, 0.07), 0.05), Some((0.05, 2e-4)));
        assert_eq!(ring.steady_road((0.03, 0.09), 0.05), None);
        assert_eq!(ring.steady_road((0.03, 0.2), 0.05), None);
    }

    #[test]
    fn the_oldest_makes_room() {
        let mut ring = Ring::new(2);
        for stamp in 0..3 {
            ring.push((f64::from(stamp), 10.0 * f64::from(stamp)));
        }
        assert_eq!(ring.value_at(0.5), None);
        assert_eq!(ring.value_at(1.5), Some(15.0));
        assert_eq!(ring.newest_until(1.9), Some((1.0, 10.0)));
    }
}
