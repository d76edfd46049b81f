//! Whether the estimator's stated uncertainty holds against the truth: NEES, model book 1.5.

use nalgebra::SVector;
use printer_sim::Truth;
use state_estimator::Estimate;

/// Deviations of the stated 95 % interval.
const COVERED: f64 = 1.96;
/// States of the estimator.
const STATES: usize = state_estimator::state::COUNT;

/// Gathers the normalised estimation error squared while roads are deposited.
#[derive(Debug, Clone, Default)]
pub struct Consistency {
    nees: Vec<f64>,
    /// Moments at which each state's error was within 1.96 of its stated deviations.
    covered: [f64; STATES],
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

    /// Median of the error; `None` before the first.
    #[must_use]
    pub fn median(&self) -> Option<f64> {
        let mut sorted = self.nees.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len() / 2).copied()
    }
}
