//! Factors, squares and triangular solutions of small matrices, for the two unscented forms.
//!
//! Bounds are known when compiled and whole columns are worked on, zeros included: a compiler turns that into straight
//! code, which a general library's views and checks keep it from (a step is twice as fast by it, `fdm bench estimator`).

use nalgebra::{SMatrix, SVector};

/// Lower Cholesky factor of a symmetric matrix, of which the lower half is read; `None` where it is not positive
/// definite.
#[inline(always)]
pub(crate) fn cholesky<const N: usize>(matrix: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    let mut root = *matrix;
    for j in 0..N {
        let square = root[(j, j)];
        if square.is_nan() || square <= 0.0 {
            return None;
        }
        let inverse = 1.0 / square.sqrt();
        let column: [f64; N] = std::array::from_fn(|i| if i < j { 0.0 } else { root[(i, j)] * inverse });
        for (i, entry) in column.iter().enumerate() {
            root[(i, j)] = *entry;
        }
        for k in j + 1..N {
            let factor = column[k];
            for (i, entry) in column.iter().enumerate() {
                root[(i, k)] -= entry * factor;
            }
        }
    }
    Some(root)
}

/// [`cholesky`] of a matrix that usually is diagonal: noises that know nothing of one another.
pub(crate) fn root_of_noise<const N: usize>(noise: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    let mut root = SMatrix::<f64, N, N>::zeros();
    let mut apart = true;
    for j in 0..N {
        for i in 0..N {
            apart &= i == j || noise[(i, j)] == 0.0;
        }
        root[(j, j)] = noise[(j, j)].sqrt();
    }
    if !apart {
        return cholesky(noise);
    }
    // what is no number is not positive either
    (0..N).all(|index| root[(index, index)] > 0.0).then_some(root)
}

/// Adds `weight U Uᵀ` to a symmetric matrix: symmetric to the last bit.
#[inline(always)]
pub(crate) fn add_square<const N: usize, const M: usize>(
    matrix: &mut SMatrix<f64, N, N>,
    columns: &SMatrix<f64, N, M>,
    weight: f64,
) {
    let half = N / 2;
    for j in 0..half {
        add_column(matrix, columns, weight, j, 0);
    }
    for j in half..N {
        add_column(matrix, columns, weight, j, half);
        for i in 0..half {
            matrix[(i, j)] = matrix[(j, i)];
        }
    }
}

/// The part of [`add_square`] in a column, from a row on.
#[inline(always)]
fn add_column<const N: usize, const M: usize>(
    matrix: &mut SMatrix<f64, N, N>,
    columns: &SMatrix<f64, N, M>,
    weight: f64,
    j: usize,
    from: usize,
) {
    let mut column: [f64; N] = std::array::from_fn(|i| matrix[(i, j)]);
    for k in 0..M {
        let other = columns[(j, k)];
        for i in from..N {
            // the weight comes last: a product is the same to the bit whichever of the two comes first
            column[i] += columns[(i, k)] * other * weight;
        }
    }
    for (i, entry) in column.into_iter().enumerate() {
        matrix[(i, j)] = entry;
    }
}

/// Product of two matrices.
#[inline(always)]
pub(crate) fn product<const N: usize, const K: usize, const M: usize>(
    left: &SMatrix<f64, N, K>,
    right: &SMatrix<f64, K, M>,
) -> SMatrix<f64, N, M> {
    let mut product = SMatrix::<f64, N, M>::zeros();
    for j in 0..M {
        let mut column = [0.0; N];
        for k in 0..K {
            let factor = right[(k, j)];
            for (i, entry) in column.iter_mut().enumerate() {
                *entry += left[(i, k)] * factor;
            }
        }
        for (i, entry) in column.into_iter().enumerate() {
            product[(i, j)] = entry;
        }
    }
    product
}

/// `X` of `X Lᵀ = C` for a lower factor `L`, in place of `C`.
#[inline(always)]
pub(crate) fn over_transposed<const N: usize, const M: usize>(
    matrix: &mut SMatrix<f64, N, M>,
    root: &SMatrix<f64, M, M>,
) {
    for j in 0..M {
        let mut column: [f64; N] = std::array::from_fn(|i| matrix[(i, j)]);
        for k in 0..j {
            let factor = root[(j, k)];
            for (i, entry) in column.iter_mut().enumerate() {
                *entry -= matrix[(i, k)] * factor;
            }
        }
        let inverse = 1.0 / root[(j, j)];
        for (i, entry) in column.into_iter().enumerate() {
            matrix[(i, j)] = entry * inverse;
        }
    }
}

/// `x` of `L x = b` for a lower factor `L`.
#[inline(always)]
pub(crate) fn under<const M: usize>(
    root: &SMatrix<f64, M, M>,
    mut right: SVector<f64, M>,
) -> SVector<f64, M> {
    for k in 0..M {
        right[k] /= root[(k, k)];
        for i in k + 1..M {
            right[i] -= root[(i, k)] * right[k];
        }
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Cholesky, vector};

    /// Odd, so that its halves are not alike.
    const N: usize = 5;

    fn covariance() -> SMatrix<f64, N, N> {
        let root = SMatrix::<f64, N, N>::from_fn(|i, j| ((3 * i + 5 * j) as f64).sin());
        root * root.transpose() + SMatrix::identity() * 0.3
    }

    #[test]
    fn the_factor_is_the_librarys_and_what_is_not_positive_has_none() {
        let covariance = covariance();
        let root = cholesky(&covariance).unwrap();
        assert!((root - Cholesky::new(covariance).unwrap().unpack()).amax() < 1e-14);
        for (at, value) in [((3, 3), -1.0), ((4, 4), 0.0), ((2, 1), 100.0), ((4, 3), f64::NAN)] {
            let mut broken = covariance;
            broken[at] = value;
            assert_eq!(cholesky(&broken), None, "{at:?} {value}");
        }
    }

    #[test]
    fn noise_may_be_correlated_and_has_to_be_positive() {
        let diagonal = SMatrix::<f64, 3, 3>::from_diagonal(&vector![4.0, 1.0, 0.25]);
        let wanted = SMatrix::<f64, 3, 3>::from_diagonal(&vector![2.0, 1.0, 0.5]);
        assert_eq!(root_of_noise(&diagonal), Some(wanted));
        let covariance = covariance();
        assert_eq!(root_of_noise(&covariance), cholesky(&covariance));
        for value in [0.0, -1.0, f64::NAN] {
            let mut broken = diagonal;
            broken[(1, 1)] = value;
            assert_eq!(root_of_noise(&broken), None, "{value}");
        }
    }

    #[test]
    fn squares_products_and_solutions_are_the_librarys() {
        let covariance = covariance();
        let columns = SMatrix::<f64, N, 3>::from_fn(|i, j| ((2 * i + 7 * j) as f64).cos());
        let mut sum = covariance;
        add_square(&mut sum, &columns, -0.4);
        assert!((sum - (covariance - columns * columns.transpose() * 0.4)).amax() < 1e-14);
        assert_eq!(sum, sum.transpose());
        assert!((product(&covariance, &columns) - covariance * columns).amax() < 1e-14);
        let root = cholesky(&covariance).unwrap();
        let right = vector![1.0, -2.0, 0.5, 3.0, -1.0];
        assert!((root * under(&root, right) - right).amax() < 1e-13);
        let wide = columns.transpose();
        let mut solution = wide;
        over_transposed(&mut solution, &root);
        assert!((solution * root.transpose() - wide).amax() < 1e-13);
    }
}
