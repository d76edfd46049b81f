//! A signal of any length in bounded memory: smallest, largest and mean value of each column of time.

/// Columns of a series that is drawn against time: twice a wide plot's pixels.
const COLUMNS: usize = 1024;
/// Width of a column at first `[s]`; it doubles whenever the columns run out.
const WIDTH_MIN_S: f64 = 1.0 / 64.0;
/// A line is broken where this many times the usual distance between two columns is empty.
const GAP: usize = 8;

/// What fell into one column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cell {
    pub(crate) low: f64,
    pub(crate) high: f64,
    sum: f64,
    count: u32,
}

impl Cell {
    const EMPTY: Self = Self { low: f64::INFINITY, high: f64::NEG_INFINITY, sum: 0.0, count: 0 };

    fn add(&mut self, other: Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
        self.sum += other.sum;
        self.count = self.count.saturating_add(other.count);
    }

    /// Mean value.
    pub(crate) fn mean(&self) -> f64 {
        // A sum beyond the range of a float stays between the extremes all the same.
        (self.sum / f64::from(self.count)).clamp(self.low, self.high)
    }
}

/// A column with something in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Column {
    /// Middle of the column.
    pub(crate) at: f64,
    pub(crate) cell: Cell,
}

/// Columns over an axis that begins at 0 and grows as needed.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    limit: usize,
    width: f64,
    cells: Vec<Cell>,
    /// Values that are no numbers, or have no place on the axis.
    pub(crate) refused: u64,
}

impl Default for Series {
    fn default() -> Self {
        Self::with_columns(COLUMNS)
    }
}

impl Series {
    /// A series with at most `limit` columns.
    pub(crate) fn with_columns(limit: usize) -> Self {
        Self { limit: limit.max(2), width: WIDTH_MIN_S, cells: Vec::new(), refused: 0 }
    }

    /// Takes a value in; what is no finite number is counted, not drawn.
    pub(crate) fn add(&mut self, at: f64, value: f64) {
        if !value.is_finite() || !at.is_finite() || !(0.0..1e12).contains(&at) {
            self.refused += 1;
            return;
        }
        while self.index(at) >= self.limit {
            self.halve();
        }
        let index = self.index(at);
        if self.cells.len() <= index {
            self.cells.resize(index + 1, Cell::EMPTY);
        }
        self.cells[index].add(Cell { low: value, high: value, sum: value, count: 1 });
    }

    fn index(&self, at: f64) -> usize {
        // In [0, 1e12 * 64): a cast of a float saturates.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let index = (at / self.width) as usize;
        index
    }

    fn halve(&mut self) {
        self.cells = merged(&self.cells, 2);
        self.width *= 2.0;
    }

    /// Nothing was taken in.
    pub(crate) fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Columns that hold something, at most about `columns` of them over `span`.
    pub(crate) fn columns(&self, columns: usize, span: f64) -> Vec<Column> {
        let wanted = span / columns.max(1) as f64;
        let ratio = (wanted / self.width).round().clamp(1.0, 1e6);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // in [1, 1e6]
        let ratio = ratio as usize;
        let width = self.width * ratio as f64;
        let cells = merged(&self.cells, ratio);
        let filled = cells.iter().enumerate().filter(|(_, cell)| cell.count > 0);
        filled.map(|(index, cell)| Column { at: (index as f64 + 0.5) * width, cell: *cell }).collect()
    }

    /// The same, broken where the signal was away for long.
    pub(crate) fn runs(&self, columns: usize, span: f64) -> Vec<Vec<Column>> {
        let filled = self.columns(columns, span);
        let mut steps: Vec<f64> = filled.windows(2).map(|pair| pair[1].at - pair[0].at).collect();
        steps.sort_by(f64::total_cmp);
        let usual = steps.get(steps.len() / 2).copied().unwrap_or(f64::INFINITY);
        let away = (usual * GAP as f64).max(span / 50.0);
        let mut runs: Vec<Vec<Column>> = Vec::new();
        for column in filled {
            match runs.last_mut() {
                Some(run) if run.last().is_some_and(|last| column.at - last.at <= away) => run.push(column),
                _ => runs.push(vec![column]),
            }
        }
        runs
    }

    /// Mean of what lies between two places; `None` where nothing does.
    pub(crate) fn mean_between(&self, from: f64, to: f64) -> Option<f64> {
        if !(from.is_finite() && to.is_finite()) || to < from || from < 0.0 {
            return None;
        }
        let last = self.index(to).min(self.cells.len().checked_sub(1)?);
        let mut all = Cell::EMPTY;
        for cell in self.cells.get(self.index(from)..=last)? {
            all.add(*cell);
        }
        (all.count > 0).then(|| all.mean())
    }

    /// Smallest and largest value.
    #[cfg(test)]
    pub(crate) fn extremes(&self) -> Option<(f64, f64)> {
        let filled = || self.cells.iter().filter(|cell| cell.count > 0);
        let low = filled().map(|cell| cell.low).reduce(f64::min)?;
        let high = filled().map(|cell| cell.high).reduce(f64::max)?;
        Some((low, high))
    }
}

fn merged(cells: &[Cell], ratio: usize) -> Vec<Cell> {
    let sum = |group: &[Cell]| {
        group.iter().fold(Cell::EMPTY, |mut sum, cell| {
            sum.add(*cell);
            sum
        })
    };
    cells.chunks(ratio.max(1)).map(sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// 1 h at 50 Hz: bounded, and the one spike is still there.
    #[test]
    fn a_long_signal_stays_small_and_keeps_its_extremes() {
        let mut series = Series::default();
        for step in 0..180_000_u32 {
            series.add(f64::from(step) / 50.0, if step == 77_777 { 9.0 } else { f64::from(step % 2) });
        }
        assert!(series.cells.len() <= COLUMNS);
        assert_eq!(series.extremes(), Some((0.0, 9.0)));
        let columns = series.columns(400, 3600.0);
        assert!((200..=800).contains(&columns.len()), "{}", columns.len());
        assert!(columns.iter().any(|column| column.cell.high > 8.9 && (column.at - 1555.5).abs() < 10.0));
    }

    #[test]
    fn a_silence_breaks_the_line() {
        let mut series = Series::default();
        for step in 0..1000_u32 {
            let at = f64::from(step) * 0.1;
            if !(30.0..50.0).contains(&at) {
                series.add(at, 1.0);
            }
        }
        assert_eq!(series.runs(400, 100.0).len(), 2);
    }

    #[test]
    fn the_mean_between_two_places_is_that_of_the_values() {
        let mut series = Series::with_columns(65536);
        for step in 0..100_u32 {
            series.add(f64::from(step), f64::from(step));
        }
        assert_eq!(series.mean_between(10.0, 12.0), Some(11.0));
        assert_eq!(series.mean_between(200.0, 300.0), None);
        assert_eq!(series.mean_between(f64::NAN, 300.0), None);
    }

    proptest! {
        /// Whatever comes in, nothing that is no number comes out, and the memory is bounded.
        #[test]
        fn any_input_is_taken_or_counted(points in prop::collection::vec((any::<f64>(), any::<f64>()), 0..200)) {
            let mut series = Series::default();
            for (at, value) in &points {
                series.add(*at, *value);
            }
            prop_assert!(series.cells.len() <= COLUMNS);
            for column in series.columns(300, 10.0) {
                prop_assert!(column.at.is_finite() && column.cell.mean().is_finite());
                prop_assert!(column.cell.low <= column.cell.high);
            }
            let taken = points.len() as u64 - series.refused;
            prop_assert_eq!(taken == 0, series.is_empty());
        }
    }
}
