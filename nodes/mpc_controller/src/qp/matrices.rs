//! Constant matrices of the problem.

use super::{FLOW, Lags, ROWS, STAGE, TEMPERATURE, input};
use crate::params::RawCost;
use clarabel::algebra::CscMatrix;

/// Entries of a matrix before it is packed.
#[derive(Default)]
struct Entries {
    rows: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
}

impl Entries {
    fn add(&mut self, row: usize, column: usize, value: f64) {
        self.rows.push(row);
        self.columns.push(column);
        self.values.push(value);
    }

    fn pack(self, rows: usize, columns: usize) -> CscMatrix<f64> {
        CscMatrix::new_from_triplets(rows, columns, self.rows, self.columns, self.values)
    }
}

/// Upper triangle of the cost `½ xᵀ P x`: the stage cost is on the deviations that its own moves led to.
pub(super) fn quadratic(cost: &RawCost, horizon: usize, width_ratio: f64) -> CscMatrix<f64> {
    let mut entries = Entries::default();
    let width = 2.0 * (width_ratio / cost.width_scale).powi(2);
    let change = cost.change_weights();
    for stage in 0..horizon {
        let at = stage * STAGE;
        entries.add(at + input::SPEED, at + input::SPEED, width + 2.0 / cost.speed_scale.powi(2));
        entries.add(at + input::FEED, at + input::FEED, 2.0 / cost.feed_scale.powi(2));
        entries.add(at + input::SETPOINT, at + input::SETPOINT, 2.0 * cost.setpoint_weight_1_k2);
        entries.add(at + FLOW, at + FLOW, width);
        entries.add(at + input::SPEED, at + FLOW, -width);
        let temperature = 2.0 * cost.temperature_weight / cost.temperature_scale_k.powi(2);
        entries.add(at + TEMPERATURE, at + TEMPERATURE, temperature);
        for (index, weight) in change.into_iter().enumerate() {
            // each move takes part in the change to it and in the change from it
            let count = if stage + 1 < horizon { 2.0 } else { 1.0 };
            entries.add(at + index, at + index, 2.0 * weight * count);
            if stage > 0 {
                entries.add(at - STAGE + index, at + index, -2.0 * weight);
            }
        }
    }
    entries.pack(horizon * STAGE, horizon * STAGE)
}

/// Deviations with the move that each follows, and what is left of it after a step.
pub(super) fn responses(lags: &Lags) -> [(usize, usize, f64); 2] {
    [(FLOW, input::FEED, lags.keep_flow()), (TEMPERATURE, input::SETPOINT, lags.keep_temperature())]
}

/// Prediction (equalities), then per stage and move: upper bound, lower bound, rise, fall.
pub(super) fn constraints(lags: &Lags) -> CscMatrix<f64> {
    let mut entries = Entries::default();
    for stage in 0..lags.horizon {
        let at = stage * STAGE;
        for (offset, (deviation, cause, keep)) in responses(lags).into_iter().enumerate() {
            let row = 2 * stage + offset;
            entries.add(row, at + deviation, 1.0);
            entries.add(row, at + cause, keep - 1.0);
            if stage > 0 {
                entries.add(row, at - STAGE + deviation, -keep);
            }
        }
        for index in 0..input::COUNT {
            let row = 2 * lags.horizon + stage * ROWS + 4 * index;
            entries.add(row, at + index, 1.0);
            entries.add(row + 1, at + index, -1.0);
            entries.add(row + 2, at + index, 1.0);
            entries.add(row + 3, at + index, -1.0);
            if stage > 0 {
                entries.add(row + 2, at - STAGE + index, -1.0);
                entries.add(row + 3, at - STAGE + index, 1.0);
            }
        }
    }
    entries.pack((2 + ROWS) * lags.horizon, STAGE * lags.horizon)
}
