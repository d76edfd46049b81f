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
    use models::command::EstimateHealth;
    use models::units::Seconds;
    use nalgebra::SMatrix;
    use state_estimator::{CHANNELS, Channel, Refusals, state};

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

    /// A block at this many kelvin, of which the estimator is sure to 2 K; the other states are known and right.
    fn estimated(block_k: f64) -> Estimate {
        let mut p = SMatrix::identity();
        p[(state::BLOCK, state::BLOCK)] = 4.0;
        let x = SVector::from([block_k, 0.0, 0.0, 0.0, 0.0, 0.0]);
        Estimate {
            stamp: Seconds(0.0),
            x,
            p,
            nis: [None; CHANNELS],
            nis_mean: [None; CHANNELS],
            innovations: [None; CHANNELS],
            measured: [0; CHANNELS],
            gated: [0; CHANNELS],
            alive: [false; CHANNELS],
            observed: [false; STATES],
            window: [None; CHANNELS],
            reference_feed_m_s: 0.0,
            steps: 0,
            resets: 0,
            noise_scale: [1.0; CHANNELS],
            melt_lag: 1.0,
            health: EstimateHealth::Sound,
            refusals: Refusals::default(),
        }
    }

    fn of(estimates: &[Estimate]) -> Consistency {
        let laid = Truth { depositing: true, ..Truth::default() };
        let mut consistency = Consistency::default();
        estimates.iter().for_each(|estimate| consistency.add(estimate, &laid));
        consistency
    }

    /// 1.96 times 2 K are 3.92 K, to either side.
    #[test]
    fn an_interval_covers_what_is_within_its_stated_deviations() {
        let errors_k = [3.9, -3.9, 3.95, -3.95];
        let [block, others @ ..] = of(&errors_k.map(estimated)).coverage().unwrap();
        assert_eq!((block, others), (0.5, [1.0; 5]));
    }

    /// (2 K / 2 K)^2 = 1, (4 / 2)^2 = 4, (6 / 2)^2 = 9: the one between is told, in whatever order they come.
    #[test]
    fn the_error_is_squared_over_the_stated_variance() {
        assert_eq!(of(&[6.0, 2.0, -4.0].map(estimated)).median(), Some(4.0));
    }

    /// Errors of 2 and 2 with variances of 4 and a covariance of 2: (2, 2) P^-1 (2, 2) = 16 / 12.
    #[test]
    fn states_that_err_together_are_weighed_together() {
        let mut estimate = estimated(2.0);
        estimate.x[state::NOZZLE] = 2.0;
        estimate.p[(state::NOZZLE, state::NOZZLE)] = 4.0;
        estimate.p[(state::BLOCK, state::NOZZLE)] = 2.0;
        estimate.p[(state::NOZZLE, state::BLOCK)] = 2.0;
        let median = of(&[estimate]).median().unwrap();
        assert!((median - 4.0 / 3.0).abs() < 1e-12, "{median}");
    }

    #[test]
    fn a_covariance_that_is_none_vouches_for_nothing() {
        let mut estimate = estimated(0.0);
        estimate.p[(state::GAIN, state::GAIN)] = -1.0;
        assert_eq!(of(&[estimate]).median(), Some(f64::INFINITY));
    }

    #[test]
    fn only_what_is_laid_counts() {
        let mut consistency = Consistency::default();
        consistency.add(&estimated(100.0), &Truth::default());
        assert_eq!((consistency.coverage(), consistency.median()), (None, None));
        assert_eq!(consistency.blind().map(|names| names.len()), [0, 0]);
    }

    /// One moment is enough to be told of, or to move; slip is held where neither encoder nor widths live.
    #[test]
    fn blind_is_what_was_never_observed_and_held_what_never_moved() {
        let mut seen = estimated(0.0);
        (seen.observed[state::BLOCK], seen.observed[state::FLOW]) = (true, true);
        let blind = of(&[estimated(0.0), seen]).blind();
        assert_eq!(blind, [vec!["nozzle", "thermistor", "slip", "gain"], vec!["slip"]]);
        seen.alive[Channel::Encoder as usize] = true;
        assert_eq!(of(&[estimated(0.0), seen]).blind()[1], Vec::<&str>::new());
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
