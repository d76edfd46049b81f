//! Whether the estimator's stated uncertainty holds against the truth: NEES, model book 1.5.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector, SVector};
use printer_sim::Truth;
use serde::Serialize;
use state_estimator::Estimate;

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
    /// 2.5 and 97.5 % of a chi-square distribution with as many degrees of freedom.
    pub band: [f64; 2],
}

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
        let band = *BANDS.get(states.len().checked_sub(1)?)?;
        Some(Told { nees_median: middle(nees)?, states, band })
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

    /// Block 4 K off, of which 2 K are stated: 4 of one degree of freedom, whatever the others do that nothing tells of.
    #[test]
    fn states_that_nothing_tells_of_do_not_count_as_told() {
        let mut estimate = estimated(4.0);
        estimate.observed[state::BLOCK] = true;
        let mut off = estimate;
        (off.x[state::GAIN], off.observed[state::GAIN]) = (3.0, true);
        let told = of(&[estimate, off, estimate]).told().unwrap();
        assert_eq!(told, Told { states: vec!["block"], nees_median: 4.0, band: [0.00098, 5.02] });
        // 4 and 9 of two, once these are told of most of the time.
        let told = of(&[estimate, off, off]).told().unwrap();
        assert_eq!(told, Told { states: vec!["block", "gain"], nees_median: 13.0, band: [0.0506, 7.38] });
    }

    /// Of a block and a thermistor that err together alone their own covariance counts: 16 / 12, as above.
    #[test]
    fn what_is_told_of_is_weighed_by_its_own_covariance() {
        let mut estimate = estimated(2.0);
        (estimate.x[state::SENSOR], estimate.p[(state::SENSOR, state::SENSOR)]) = (2.0, 4.0);
        (estimate.p[(state::BLOCK, state::SENSOR)], estimate.p[(state::SENSOR, state::BLOCK)]) = (2.0, 2.0);
        (estimate.observed[state::BLOCK], estimate.observed[state::SENSOR]) = (true, true);
        estimate.x[state::SLIP] = 7.0;
        let median = of(&[estimate]).told().unwrap().nees_median;
        assert!((median - 4.0 / 3.0).abs() < 1e-12, "{median}");
    }

    #[test]
    fn where_nothing_is_told_of_nothing_is_said_of_it() {
        assert_eq!(of(&[estimated(0.0)]).told(), None);
        assert_eq!(of(&[]).told(), None);
    }

    /// Wilson and Hilferty, from three degrees on: degrees (1 - a +- 1.96 sqrt(a))^3 with a = 2 / (9 degrees).
    #[test]
    fn the_bands_are_a_chi_squares() {
        for (degrees, band) in (1_u8..).map(f64::from).zip(BANDS).skip(2) {
            let a = 2.0 / (9.0 * degrees);
            let bounds = [-COVERED, COVERED].map(|z| degrees * (1.0 - a + z * a.sqrt()).powi(3));
            for (bound, stated) in bounds.into_iter().zip(band) {
                assert!((bound - stated).abs() < 0.06, "{degrees}: {bound}, {stated}");
            }
        }
        // One degree: the square of a Gaussian; two: an exponential distribution of mean 2.
        assert!((BANDS[0][1].sqrt() - 2.2414).abs() < 1e-3 && (BANDS[0][0].sqrt() - 0.03134).abs() < 1e-4);
        let two = [0.975_f64, 0.025].map(|above| -2.0 * above.ln());
        assert!(BANDS[1].iter().zip(two).all(|(stated, bound)| (stated - bound).abs() < 0.005), "{two:?}");
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
