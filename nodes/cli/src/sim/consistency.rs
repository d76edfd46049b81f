//! Whether the estimator's stated uncertainty holds against the truth: NEES, model book 1.5.

use nalgebra::SVector;
use printer_sim::Truth;
use state_estimator::Estimate;

/// Deviations of the stated 95 % interval.
const COVERED: f64 = 1.96;
/// States of the estimator.
const STATES: usize = state_estimator::state::COUNT;
/// Their names, in the order of the estimator's vector.
pub const STATE_NAMES: [&str; STATES] = ["block", "nozzle", "thermistor", "flow", "slip", "gain"];
/// Median of a chi-square distribution with as many degrees of freedom: that of the NEES of a filter whose covariance is true.
pub const TRUE_MEDIAN: f64 = 5.35;

/// Gathers the normalised estimation error squared while roads are deposited.
#[derive(Debug, Clone, Default)]
pub struct Consistency {
    nees: Vec<f64>,
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
        let mut sorted = self.nees.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use state_estimator::state;

    /// The names stand where the estimator's indices point.
    #[test]
    fn the_states_are_named_in_the_estimators_order() {
        let named = [
            (state::BLOCK, "block"),
            (state::NOZZLE, "nozzle"),
            (state::SENSOR, "thermistor"),
            (state::FLOW, "flow"),
            (state::SLIP, "slip"),
            (state::GAIN, "gain"),
        ];
        for (index, name) in named {
            assert_eq!(STATE_NAMES[index], name);
        }
    }

    /// Wilson and Hilferty: the cube root of a chi-square over its degrees is about normal, with mean and median
    /// 1 - 2 / (9 degrees).
    #[test]
    fn the_median_of_a_true_covariance_is_below_the_mean() {
        let degrees = 6.0_f64;
        let median = degrees * (1.0 - 2.0 / (9.0 * degrees)).powi(3);
        assert!((TRUE_MEDIAN - median).abs() < 0.02, "{median}");
    }
}
