//! What the printer did a moment ago: sensors report late, and each at its own time.

use std::collections::VecDeque;

/// Least share that is made up for which tells of strokes `[-]`: that of a sound drive.
const SLIP_TELLING: f64 = 0.01;
/// Reports that are further apart hide a corner that the tool slows down for `[s]`: 30 mm/s lost and won again at 1 m/s2.
const HIDING_S: f64 = 0.06;
/// Largest angle of an arc between two reports, halved `[rad]`: a steeper one is not told from a corner.
const STEEPEST: f64 = 1.2;
/// Heights that differ by a smaller share are of one road `[-]`.
const STILL: f64 = 0.05;
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
    /// Place of the tool over the bed: x, y.
    pub(crate) tool_m: [f64; 2],
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
    /// Way of the tool from report `index` to the next, straight `[m]`.
    fn chord(&self, index: usize) -> Option<[f64; 2]> {
        let (left, right) = (self.values.get(index)?, self.values.get(index + 1)?);
        Some([right.tool_m[0] - left.tool_m[0], right.tool_m[1] - left.tool_m[1]])
    }

    /// Angle that the tool turns by from report `index` to the next, by how it goes on from or to report `other` `[rad]`.
    fn turning(&self, index: usize, other: usize) -> Option<f64> {
        let ([x, y], [other_x, other_y]) = (self.chord(index)?, self.chord(other)?);
        let angle = (other_x * y - other_y * x).atan2(other_x * x + other_y * y);
        let (span_s, other_s) = (self.span_s(index)?, self.span_s(other)?);
        Some(angle.abs() * span_s / (0.5 * (span_s + other_s)))
    }

    /// Time from report `index` to the next `[s]`.
    fn span_s(&self, index: usize) -> Option<f64> {
        Some(self.values.get(index + 1)?.stamp_s - self.values.get(index)?.stamp_s)
    }

    /// The tool went as far from report `index` to the next as the speeds at both tell, of a straight road, or of an arc that
    /// turns as its neighbours do: one of an angle `a` is longer than its chord by `(a / 2) / sin(a / 2)`.
    fn goes_straight_on(&self, index: usize, spread: f64) -> Option<bool> {
        let span_s = self.span_s(index)?;
        if span_s <= HIDING_S {
            return Some(true);
        }
        let before = index.checked_sub(1).and_then(|before| self.turning(index, before));
        let turns = [before, self.turning(index, index + 1)];
        let half =
            turns.into_iter().flatten().reduce(f64::min).map_or(0.0, |turn| (0.5 * turn).min(STEEPEST));
        let bend = if half < 1e-3 { 1.0 } else { half.sin() / half };
        let speed_m_s =
            0.5 * (self.values.get(index)?.path_speed_m_s + self.values.get(index + 1)?.path_speed_m_s);
        let (told_m, [x, y]) = (speed_m_s * span_s, self.chord(index)?);
        Some(((1.0 - spread) * bend * told_m..=(1.0 + spread) * told_m).contains(&x.hypot(y)))
    }

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

    /// Path speed and height of the road, if both kept within `spread` from `from_s` to `to_s`, and the tool went as far
    /// between reports that are far apart as the speeds at both tell.
    pub(crate) fn steady_road(&self, window_s: (f64, f64), spread: f64) -> Option<(f64, f64)> {
        let (first, last) = self.reports(window_s)?;
        if !(first..last).all(|index| self.goes_straight_on(index, spread).unwrap_or(false)) {
            return None;
        }
        let height_m = self.height_m((first, last), spread)?;
        let (low, high) = self.path_speeds((first, last));
        (high - low <= spread * high).then_some((0.5 * (low + high), height_m))
    }

    /// Path speed at `to_s` and height of a road that was laid from `from_s` on between reports that are close, so that what the
    /// tool did between them is known; and the spread of its speed, `most` at most.
    pub(crate) fn unsteady_road(&self, window_s: (f64, f64), most: f64) -> Option<((f64, f64), f64)> {
        let (first, last) = self.reports(window_s)?;
        if !(first..last).all(|index| self.span_s(index).is_some_and(|span_s| span_s <= HIDING_S)) {
            return None;
        }
        let height_m = self.height_m((first, last), STILL)?;
        let (low, high) = self.path_speeds((first, last));
        if high - low > most * high {
            return None;
        }
        let (_, left, right) = self.around(window_s.1, |sample| sample.stamp_s)?;
        let span_s = right.stamp_s - left.stamp_s;
        let share = if span_s > 0.0 { (window_s.1 - left.stamp_s) / span_s } else { 0.0 };
        let speed_m_s = left.path_speed_m_s + share * (right.path_speed_m_s - left.path_speed_m_s);
        Some(((speed_m_s, height_m), (high - low) / high))
    }

    /// First and last report that tell of a window.
    fn reports(&self, (from_s, to_s): (f64, f64)) -> Option<(usize, usize)> {
        let first = self.values.partition_point(|sample| sample.stamp_s <= from_s).checked_sub(1)?;
        let last = self.values.partition_point(|sample| sample.stamp_s < to_s);
        (last < self.values.len()).then_some((first, last))
    }

    /// Height of the road that every one of these reports is of, within `spread`.
    fn height_m(&self, (first, last): (usize, usize), spread: f64) -> Option<f64> {
        let height_m = self.values.get(last)?.height_m?;
        let same = |sample: &Sample| {
            sample.depositing
                && sample.height_m.is_some_and(|other| (other - height_m).abs() <= spread * height_m)
        };
        self.values.range(first..=last).all(same).then_some(height_m)
    }

    /// Slowest and fastest path speed of reports.
    fn path_speeds(&self, (first, last): (usize, usize)) -> (f64, f64) {
        let speeds = self.values.range(first..=last).map(|sample| sample.path_speed_m_s);
        speeds.fold((f64::INFINITY, 0.0), |(low, high), speed| (low.min(speed), f64::max(high, speed)))
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
mod tests;
