//! The least of a curve through the mean squares of a pattern's lines.

use super::NoBest;
use nalgebra::{SMatrix, SVector};

/// Where the mean squares are least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Valley {
    /// At the least of the curve, relative to the centre, with its standard error `[s]`.
    Here {
        /// From the centre.
        offset_s: f64,
        /// Standard error by the scatter of the lines.
        error_s: f64,
    },
    /// Towards smaller K.
    Below,
    /// Towards larger K.
    Above,
}

/// A weighted least-squares polynomial of `N` terms in units of the centre, where the normal equations are well scaled.
struct Curve<const N: usize> {
    terms: SVector<f64, N>,
    covariance: SMatrix<f64, N, N>,
    /// Two-sided 95 % quantile of its degrees of freedom.
    certain: f64,
}

impl<const N: usize> Curve<N> {
    /// A mean square `m` of errors with noise of variance `s^2` scatters with a variance in proportion to
    /// `4 (m - s^2) s^2 + 2 s^4`: its inverse is the line's weight.
    fn fit(lines: &[[f64; 2]], centre_s: f64, noise: f64) -> Option<Self> {
        let row = |advance_s: f64| {
            let x = advance_s / centre_s - 1.0;
            SVector::<f64, N>::from_fn(|power, _| (0..power).fold(1.0, |product, _| product * x))
        };
        let floor = (noise * noise).max(f64::MIN_POSITIVE.sqrt());
        let weight =
            |square: f64| floor * floor / (4.0 * (square - floor).max(0.0) * floor + 2.0 * floor * floor);
        let (mut normal, mut right) = (SMatrix::<f64, N, N>::zeros(), SVector::<f64, N>::zeros());
        for [advance_s, square] in lines {
            normal += row(*advance_s) * row(*advance_s).transpose() * weight(*square);
            right += row(*advance_s) * *square * weight(*square);
        }
        let inverse = normal.try_inverse()?;
        let terms = inverse * right;
        let residual = |[k, square]: &[f64; 2]| weight(*square) * (square - row(*k).dot(&terms)).powi(2);
        #[expect(clippy::cast_precision_loss, reason = "a small count")]
        let freedom = lines.len() as f64 - N as f64;
        let variance = lines.iter().map(residual).sum::<f64>() / freedom;
        Some(Self { terms, covariance: inverse * variance, certain: student(freedom) })
    }

    /// Whether a term stands out of its own uncertainty.
    fn stands_out(&self, term: usize) -> bool {
        self.terms[term].abs() > self.certain * self.covariance[(term, term)].sqrt()
    }
}

/// Vertex of the parabola through the lines, or the way to it.
pub(super) fn valley(lines: &[[f64; 2]], centre_s: f64, noise: f64) -> Result<Valley, NoBest> {
    let curve = Curve::<3>::fit(lines, centre_s, noise).ok_or(NoBest::Flat)?;
    let [slope, bend] = [curve.terms[1], curve.terms[2]];
    if bend > 0.0 && curve.stands_out(2) {
        let gradient = SVector::<f64, 3>::new(0.0, -0.5 / bend, 0.5 * slope / (bend * bend));
        let error_s = gradient.dot(&(curve.covariance * gradient)).sqrt() * centre_s;
        return Ok(Valley::Here { offset_s: -0.5 * slope / bend * centre_s, error_s });
    }
    match slope {
        _ if !curve.stands_out(1) => Err(NoBest::Flat),
        rising if rising > 0.0 => Ok(Valley::Below),
        _ => Ok(Valley::Above),
    }
}

/// Least of a cubic, relative to the centre, with its standard error `[s]`; `None` where it has none. Where a printer's
/// lag is not linear the valley is steeper on one side, which shifts a parabola's vertex.
pub(super) fn cubic_least(lines: &[[f64; 2]], centre_s: f64, noise: f64) -> Option<[f64; 2]> {
    let curve = Curve::<4>::fit(lines, centre_s, noise)?;
    let [slope, bend, skew] = [curve.terms[1], curve.terms[2], curve.terms[3]];
    let root = (bend * bend - 3.0 * skew * slope).sqrt();
    // A NaN is no least.
    if !(root > 0.0 && bend > 0.0) {
        return None;
    }
    let x = -slope / (bend + root);
    // The slope there is 0: dx = -(d slope + 2 x d bend + 3 x^2 d skew) / (2 root).
    let gradient = SVector::<f64, 4>::new(0.0, 1.0, 2.0 * x, 3.0 * x * x) / (-2.0 * root);
    Some([x * centre_s, gradient.dot(&(curve.covariance * gradient)).sqrt() * centre_s])
}

/// Two-sided 95 % quantile of Student's t: three terms about the normal's (Abramowitz and Stegun 26.7.5).
pub(super) fn student(freedom: f64) -> f64 {
    let z: f64 = 1.96;
    let first = (z.powi(3) + z) / (4.0 * freedom);
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / (96.0 * freedom.powi(2));
    let third =
        (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / (384.0 * freedom.powi(3));
    z + first + second + third
}
