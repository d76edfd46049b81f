//! Nonlinear least squares: Levenberg's and Marquardt's steps, and what the residuals say of the parameters.
//!
//! ```text
//! minimise  |r_d(p)|^2 / f + |r_p(p)|^2          r_d data over its stated noise, r_p beliefs over theirs
//! C = (J_d' J_d / f + J_p' J_p)^-1               f = s^2 tau
//! s^2 = |r_d|^2 / (N - P),  tau = 1 + 2 sum rho_k
//! ```
//! tau, the integrated autocorrelation of the data's residuals (Sokal 1997), is how many neighbouring residuals say the
//! same thing: a model that is slightly wrong makes them alike, and the intervals wider.

use nalgebra::{DMatrix, DVector};

/// What is minimised. Both parts are in units of their own standard deviations.
pub(super) struct Problem<'a> {
    /// Residuals at some parameters: the data's in the order of time, then the beliefs'. `None` where the parameters
    /// mean nothing.
    pub(super) residuals: &'a dyn Fn(&DVector<f64>) -> Option<DVector<f64>>,
    /// How many of them are the data's.
    pub(super) data: usize,
    /// Steps at most.
    pub(super) steps: u32,
    /// Relative change of the cost at which the steps end.
    pub(super) tolerance: f64,
}

/// Where it ended.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    pub(super) parameters: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
    /// Mean square of the data's residuals `[-]`, free parameters taken off.
    pub(super) variance: f64,
    /// Number of residuals that say the same thing `[-]`, 1 or more.
    pub(super) alike: f64,
}

/// Change of a parameter in a difference quotient: parameters are logarithms, or of the order of one.
const DIFFERENCE: f64 = 1e-5;
const DAMPING_START: f64 = 1e-5;
const DAMPING_MOST: f64 = 1e12;
/// Times that the noise is learned from the residuals and the fit done again.
const PASSES: u32 = 2;

impl Problem<'_> {
    /// The best parameters from `start` on; `None` where the problem means nothing there or has no unique answer.
    pub(super) fn solve(&self, start: DVector<f64>) -> Option<Fit> {
        let (mut parameters, mut inflation) = (start, 1.0);
        let (mut variance, mut alike) = (1.0, 1.0);
        for _ in 0..PASSES {
            parameters = self.descend(parameters, inflation)?;
            let residuals = (self.residuals)(&parameters)?;
            let data = residuals.rows(0, self.data);
            #[allow(clippy::cast_precision_loss, reason = "counts of samples")]
            let free = self.data.saturating_sub(parameters.len()).max(1) as f64;
            variance = data.norm_squared() / free;
            alike = autocorrelation(data.as_slice());
            inflation = variance * alike;
        }
        let (_, slopes) = self.linear(&parameters, inflation)?;
        let covariance = (slopes.transpose() * slopes).cholesky()?.inverse();
        Some(Fit { parameters, covariance, variance, alike })
    }

    fn descend(&self, start: DVector<f64>, inflation: f64) -> Option<DVector<f64>> {
        let (mut at, mut damping) = (start, DAMPING_START);
        for _ in 0..self.steps {
            let (residuals, slopes) = self.linear(&at, inflation)?;
            let cost = residuals.norm_squared();
            let (normal, downhill) = (slopes.transpose() * &slopes, -(slopes.transpose() * &residuals));
            loop {
                let mut damped = normal.clone();
                for index in 0..at.len() {
                    damped[(index, index)] *= 1.0 + damping;
                }
                let tried = &at + damped.cholesky()?.solve(&downhill);
                let reached = self.weighted(&tried, inflation).map(|residuals| residuals.norm_squared());
                if let Some(reached) = reached.filter(|reached| *reached <= cost) {
                    at = tried;
                    damping = (damping * 0.1).max(1e-12);
                    if cost - reached <= self.tolerance * cost {
                        return Some(at);
                    }
                    break;
                }
                damping *= 10.0;
                if damping > DAMPING_MOST {
                    return Some(at);
                }
            }
        }
        Some(at)
    }

    fn weighted(&self, at: &DVector<f64>, inflation: f64) -> Option<DVector<f64>> {
        let mut residuals = (self.residuals)(at)?;
        residuals.rows_mut(0, self.data).scale_mut(1.0 / inflation.sqrt());
        residuals.iter().all(|value| value.is_finite()).then_some(residuals)
    }

    /// Residuals and their slopes, by central differences.
    fn linear(&self, at: &DVector<f64>, inflation: f64) -> Option<(DVector<f64>, DMatrix<f64>)> {
        let residuals = self.weighted(at, inflation)?;
        let mut slopes = DMatrix::zeros(residuals.len(), at.len());
        for index in 0..at.len() {
            let beside = |change: f64| {
                let mut beside = at.clone();
                beside[index] += change;
                self.weighted(&beside, inflation)
            };
            let slope = (beside(DIFFERENCE)? - beside(-DIFFERENCE)?) / (2.0 * DIFFERENCE);
            slopes.set_column(index, &slope);
        }
        Some((residuals, slopes))
    }
}

/// Integrated autocorrelation `[-]`, 1 or more: summed up to the first lag that is not clearly above chance.
fn autocorrelation(values: &[f64]) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "a count of samples")]
    let chance = 2.0 / (values.len() as f64).sqrt();
    let power: f64 = values.iter().map(|value| value * value).sum();
    let along = |lag: usize| {
        let products = values.iter().zip(&values[lag..]).map(|(one, other)| one * other);
        products.sum::<f64>() / power
    };
    1.0 + 2.0 * (1..values.len() / 4).map(along).take_while(|along| *along > chance).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use printer_sim::sensors::Noise;

    /// A decay of amplitude 3 and rate 0.5, seen 400 times with white noise of 0.1 or with noise whose neighbours are
    /// alike: AR(1) with 0.8 has tau = (1 + 0.8) / (1 - 0.8) = 9.
    fn decay(seed: u64, memory: f64) -> Fit {
        let mut noise = Noise::new(seed, 1);
        let (mut last, fresh) = (0.0, (1.0_f64 - memory * memory).sqrt());
        let seen: Vec<(f64, f64)> = (0..400_u32)
            .map(|step| {
                let at = f64::from(step) * 0.02;
                last = memory * last + fresh * noise.draw();
                (at, 3.0 * (-0.5 * at).exp() + 0.1 * last)
            })
            .collect();
        let residuals = |p: &DVector<f64>| {
            let residual = |(at, value): &(f64, f64)| (value - p[0].exp() * (-p[1].exp() * at).exp()) / 0.1;
            Some(DVector::from_iterator(seen.len(), seen.iter().map(residual)))
        };
        let problem = Problem { residuals: &residuals, data: 400, steps: 50, tolerance: 1e-9 };
        problem.solve(DVector::from_vec(vec![0.0, 0.0])).unwrap()
    }

    fn inside(fit: &Fit) -> bool {
        let wanted = [3.0_f64.ln(), 0.5_f64.ln()];
        (0..2).all(|index| {
            (fit.parameters[index] - wanted[index]).abs() < 1.96 * fit.covariance[(index, index)].sqrt()
        })
    }

    /// 95 % twice is at least 90 % of the runs; 60 runs of chance 0.9 have 44 or more but for 1 in 10^4.
    #[test]
    fn the_truth_lies_inside_the_interval_as_often_as_it_says() {
        let white = (0..60).filter(|seed| inside(&decay(*seed, 0.0))).count();
        let alike = (0..60).filter(|seed| inside(&decay(*seed, 0.8))).count();
        assert!(white >= 44 && alike >= 44, "{white} {alike} of 60");
    }

    #[test]
    fn noise_whose_neighbours_are_alike_widens_the_intervals() {
        let (white, alike) = (decay(1, 0.0), decay(1, 0.8));
        assert!((white.variance - 1.0).abs() < 0.2 && white.alike < 1.5, "{white:?}");
        assert!(alike.alike > 4.0 && alike.covariance[(0, 0)] > 4.0 * white.covariance[(0, 0)], "{alike:?}");
    }
}
