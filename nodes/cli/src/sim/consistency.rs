//! Whether the estimator's stated uncertainty holds against the truth: NEES, model book 1.5.

use nalgebra::{DMatrix, DVector, SVector};
use printer_sim::Truth;
use serde::Serialize;
use state_estimator::Estimate;
use std::collections::BTreeMap;

/// Deviations of the stated 95 % interval.
const COVERED: f64 = 1.96;
/// States of the estimator.
const STATES: usize = state_estimator::state::COUNT;
/// Their names, in the order of the estimator's vector.
pub const STATE_NAMES: [&str; STATES] = ["block", "nozzle", "thermistor", "flow", "slip", "gain"];
/// Median of a chi-square distribution with as many degrees of freedom: that of the NEES of a filter whose covariance is true.
pub const TRUE_MEDIAN: f64 = 5.35;

/// 2.5 and 97.5 % of a chi-square distribution with 1 to 6 degrees of freedom.
const BANDS: [[f64; 2]; STATES] =
    [[0.00098, 5.02], [0.0506, 7.38], [0.216, 9.35], [0.484, 11.14], [0.831, 12.83], [1.237, 14.45]];

/// Normalised estimation error squared of the states that sensors tell of: what is held grows in doubt without an error that
/// grows with it, and is no sign of a filter that is too cautious.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Told {
    /// Names of these states: the set that was told of most of the time.
    pub states: Vec<&'static str>,
    /// Median of the error over that time.
    pub nees_median: f64,
    /// That of a true covariance of as many states.
    pub true_median: f64,
    /// 2.5 and 97.5 % of a chi-square distribution with as many degrees of freedom: what holds 95 % of single moments.
    pub band: [f64; 2],
}

/// Median of a chi-square distribution with 1 to 6 degrees of freedom.
const MEDIANS: [f64; STATES] = [0.455, 1.386, 2.366, 3.357, 4.351, TRUE_MEDIAN];

/// Gathers the normalised estimation error squared while roads are deposited.
#[derive(Debug, Clone, Default)]
pub struct Consistency {
    nees: Vec<f64>,
    /// The same over the states that a sensor tells of, by these.
    told: BTreeMap<[bool; STATES], Vec<f64>>,
    /// Moments at which each state's error was within 1.96 of its stated deviations.
    covered: [f64; STATES],
    /// States that a sensor told of at some moment.
    observed: [bool; STATES],
    /// States that were not held at some moment.
    moved: [bool; STATES],
}

impl Consistency {
    /// Compares an estimate with the truth of the same moment.
    pub fn add(&mut self, estimate: &Estimate, truth: &Truth) {
        // Slip and gain are not observable, and the gear's slip is not defined, while nothing is pushed.
        if !truth.depositing {
            return;
        }
        let actual = SVector::<f64, STATES>::from([
            truth.block_k,
            truth.nozzle_k,
            truth.sensor_k,
            truth.outlet_m_s,
            truth.slip,
            truth.gain,
        ]);
        let held = estimate.held();
        self.observed = std::array::from_fn(|state| self.observed[state] || estimate.observed[state]);
        self.moved = std::array::from_fn(|state| self.moved[state] || !held[state]);
        let error = actual - estimate.x;
        for (state, covered) in self.covered.iter_mut().enumerate() {
            let inside = error[state].abs() <= COVERED * estimate.p[(state, state)].sqrt();
            *covered += f64::from(u8::from(inside));
        }
        // A covariance that is not positive definite vouches for nothing: no finite error is consistent with it.
        self.nees.push(estimate.p.cholesky().map_or(f64::INFINITY, |root| error.dot(&root.solve(&error))));
        let seen: Vec<usize> = (0..STATES).filter(|&state| estimate.observed[state]).collect();
        let error = DVector::from_iterator(seen.len(), seen.iter().map(|&state| error[state]));
        let p = DMatrix::from_fn(seen.len(), seen.len(), |row, column| estimate.p[(seen[row], seen[column])]);
        let nees = p.cholesky().map_or(f64::INFINITY, |root| error.dot(&root.solve(&error)));
        self.told.entry(estimate.observed).or_default().push(nees);
    }

    /// The error of the states that sensors tell of; `None` where none tells of any.
    #[must_use]
    pub fn told(&self) -> Option<Told> {
        let (seen, nees) = self.told.iter().max_by_key(|(_, nees)| nees.len())?;
        let states: Vec<&str> =
            STATE_NAMES.into_iter().zip(seen).filter(|(_, seen)| **seen).map(|(name, _)| name).collect();
        let last = states.len().checked_sub(1)?;
        let (true_median, band) = (*MEDIANS.get(last)?, *BANDS.get(last)?);
        Some(Told { nees_median: middle(nees)?, true_median, states, band })
    }

    /// Share of the time that each state's error was within 1.96 of its stated deviations: 95 % of a Gaussian.
    #[must_use]
    pub fn coverage(&self) -> Option<[f64; STATES]> {
        #[allow(clippy::cast_precision_loss, reason = "moments of a print are far below 2^52")]
        let count = self.nees.len() as f64;
        (count > 0.0).then(|| self.covered.map(|covered| covered / count))
    }

    /// States that no sensor told of while roads were laid, and those that the estimator held all the while; none before the
    /// first.
    #[must_use]
    pub fn blind(&self) -> [Vec<&'static str>; 2] {
        [self.observed, self.moved].map(|seen| {
            let never = STATE_NAMES.into_iter().zip(seen).filter(|(_, seen)| !seen && !self.nees.is_empty());
            never.map(|(name, _)| name).collect()
        })
    }

    /// Median of the error; `None` before the first.
    #[must_use]
    pub fn median(&self) -> Option<f64> {
        middle(&self.nees)
    }
}

/// Median; of an even number the upper of the two; `None` of none.
fn middle(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

#[cfg(test)]
mod tests;
