//! The Cholesky factor of a covariance matrix, and what is solved with it.

use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Mat, MatMut, MatRef, Par};

use crate::checks::{check_count, check_finite, check_positive};
use crate::kernel::{column, column_mut};
use crate::{GpError, triangle};

/// L with L Lᵀ = K, the same bits for any number of threads.
#[derive(Clone, Debug)]
pub struct Cholesky {
    factor: Mat<f64>,
}

impl Cholesky {
    /// Factors a symmetric matrix of which the lower triangle is given.
    ///
    /// # Errors
    /// `NotPositiveDefinite` with the pivot at which the factorisation broke down.
    pub fn new(what: &'static str, mut matrix: Mat<f64>) -> Result<Self, GpError> {
        factorize(what, matrix.as_mut())?;
        Ok(Self { factor: matrix })
    }

    /// From L itself, as it was saved; of it the lower triangle is read.
    ///
    /// # Errors
    /// `ShapeMismatch` if it is not square; `NotFinite`; `NotPositive` for an entry of its diagonal.
    pub fn from_factor(factor: Mat<f64>) -> Result<Self, GpError> {
        check_count("columns of the factor", factor.nrows(), factor.ncols())?;
        check_finite("factor", factor.as_ref())?;
        for i in 0..factor.nrows() {
            check_positive("diagonal of the factor", factor[(i, i)])?;
        }
        Ok(Self { factor })
    }

    /// L; only its lower triangle has a meaning.
    pub fn factor(&self) -> MatRef<'_, f64> {
        self.factor.as_ref()
    }

    /// Replaces B by L⁻¹ B.
    pub fn solve_lower(&self, rhs: MatMut<'_, f64>) {
        solve_lower_triangular_in_place(self.factor.as_ref(), rhs, Par::Seq);
    }

    /// Replaces X by X L⁻ᵀ: the same for the rows of X, and much the faster way for many of them.
    pub fn solve_rows(&self, rows: MatMut<'_, f64>) {
        triangle::solve_rows(self.factor.as_ref(), rows);
    }

    /// The factor of K with one more row and column, the diagonal entry last; O(N²).
    ///
    /// # Errors
    /// `NotPositiveDefinite` if the new row is a combination of the others.
    pub fn with_row(&self, what: &'static str, mut row: Vec<f64>) -> Result<Self, GpError> {
        let n = self.factor.nrows();
        let diagonal = row.pop().unwrap_or(0.0);
        self.solve_lower(MatMut::from_column_major_slice_mut(&mut row, n, 1));
        let rest = diagonal - row.iter().map(|value| value * value).sum::<f64>();
        if rest <= (n + 1) as f64 * f64::EPSILON * diagonal {
            return Err(GpError::NotPositiveDefinite { what, size: n + 1, pivot: n });
        }
        row.push(rest.sqrt());
        let entry = |i, j| if i < n && j < n { self.factor[(i, j)] } else { 0.0 };
        let mut factor = Mat::from_fn(n + 1, n + 1, entry);
        (0..=n).for_each(|j| factor[(n, j)] = row[j]);
        Ok(Self { factor })
    }

    /// The factor of K without row and column `index`; O(N²).
    ///
    /// The rows behind it take its column in by rotations: L'L'ᵀ = L₃L₃ᵀ + l lᵀ.
    pub fn without_row(&self, index: usize) -> Self {
        let n = self.factor.nrows() - 1;
        let skip = |i: usize| i + usize::from(i >= index);
        let mut factor =
            Mat::from_fn(n, n, |i, j| if j > i { 0.0 } else { self.factor[(skip(i), skip(j))] });
        let mut rest: Vec<f64> = (0..n).map(|i| self.factor[(skip(i), index)]).collect();
        for j in index..n {
            let (diagonal, below) = (factor[(j, j)], rest[j]);
            let length = diagonal.hypot(below);
            let (cosine, sine) = (diagonal / length, below / length);
            for (entry, rest) in column_mut(&mut factor, j)[j..].iter_mut().zip(&mut rest[j..]) {
                let turned = cosine * *entry + sine * *rest;
                *rest = cosine * *rest - sine * *entry;
                *entry = turned;
            }
        }
        Self { factor }
    }

    /// The diagonal of K⁻¹, in O(N³).
    pub fn inverse_diagonal(&self) -> Vec<f64> {
        let inverse = triangle::inverse(self.factor.as_ref());
        let squares = |j| column(&inverse, j)[j..].iter().map(|value| value * value).sum();
        (0..inverse.ncols()).map(squares).collect()
    }
}

/// Overwrites the lower triangle of a symmetric matrix by its Cholesky factor.
///
/// A pivot below N·ε times its diagonal entry holds rounding only and counts as not positive.
///
/// # Errors
/// `NotPositiveDefinite` with the pivot at which the factorisation broke down.
pub fn factorize(what: &'static str, mut matrix: MatMut<'_, f64>) -> Result<(), GpError> {
    let n = matrix.nrows();
    let failed = |pivot| GpError::NotPositiveDefinite { what, size: n, pivot };
    let diagonal: Vec<f64> = (0..n).map(|i| matrix[(i, i)]).collect();
    triangle::factorize(matrix.as_mut()).map_err(failed)?;
    let threshold = n as f64 * f64::EPSILON;
    let sound = |i: usize| matrix[(i, i)].powi(2) > threshold * diagonal[i];
    match (0..n).find(|&i| !sound(i)) {
        Some(pivot) => Err(failed(pivot)),
        None => Ok(()),
    }
}

/// Overwrites the factor L by the lower triangle of (L Lᵀ)⁻¹; 2n³/3 operations.
///
/// - `scratch`: [`scratch_rows`](triangle::scratch_rows)×n.
pub fn invert(mut factor: MatMut<'_, f64>, mut scratch: MatMut<'_, f64>) {
    triangle::invert(factor.as_mut(), scratch.as_mut());
    triangle::square(factor, scratch);
}

/// Replaces b by (L Lᵀ)⁻¹ b.
pub fn solve_with(factor: MatRef<'_, f64>, rhs: &mut [f64]) {
    triangle::solve_lower(factor, &mut [rhs]);
    triangle::solve_upper(factor, rhs);
}

/// ln |L Lᵀ|.
pub fn log_determinant(factor: MatRef<'_, f64>) -> f64 {
    2.0 * (0..factor.nrows()).map(|i| factor[(i, i)].ln()).sum::<f64>()
}

/// The exact Gram matrix of a positive semi-definite matrix is factored with pivoting: F Fᵀ = K.
///
/// F has as many columns as K has pivots above N·ε times its largest diagonal entry.
///
/// # Errors
/// `NotPositiveDefinite` if K has a negative pivot beyond rounding.
pub fn pivoted_factor(what: &'static str, matrix: MatRef<'_, f64>) -> Result<Mat<f64>, GpError> {
    let n = matrix.nrows();
    let mut rest: Vec<f64> = (0..n).map(|i| matrix[(i, i)]).collect();
    let largest = rest.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let tolerance = n as f64 * f64::EPSILON * largest;
    let mut factor = Mat::zeros(n, n);
    for rank in 0..n {
        let pivot = (0..n).fold(0, |best, i| if rest[i] > rest[best] { i } else { best });
        if rest[pivot] <= tolerance {
            return match rest.iter().position(|&value| value < -100.0 * tolerance) {
                Some(pivot) => Err(GpError::NotPositiveDefinite { what, size: n, pivot }),
                None => Ok(factor.subcols(0, rank).to_owned()),
            };
        }
        let root = rest[pivot].sqrt();
        for i in 0..n {
            let known: f64 = (0..rank).map(|k| factor[(i, k)] * factor[(pivot, k)]).sum();
            let value = (matrix[(i, pivot)] - known) / root;
            factor[(i, rank)] = value;
            rest[i] -= value * value;
        }
        rest[pivot] = 0.0;
    }
    Ok(factor)
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::{factorize, pivoted_factor};
    use crate::GpError;

    #[test]
    fn the_pivoted_factor_multiplies_back_and_shows_the_rank() {
        let root = Mat::from_fn(6, 3, |i, j| ((3 * i + 2 * j) as f64).sin() + (i * j) as f64);
        let matrix = &root * root.transpose();
        let factor = pivoted_factor("test", matrix.as_ref()).unwrap();
        assert_eq!(factor.ncols(), 3);
        assert!((&factor * factor.transpose() - &matrix).norm_max() < 1e-12 * matrix.norm_max());
        let nothing = pivoted_factor("test", Mat::zeros(2, 2).as_ref()).unwrap();
        assert_eq!(nothing.ncols(), 0);
    }

    #[test]
    fn a_pivot_of_rounding_only_is_not_positive() {
        let mut matrix = Mat::full(2, 2, 1.0);
        matrix[(1, 1)] += f64::EPSILON;
        let expected = GpError::NotPositiveDefinite { what: "test", size: 2, pivot: 1 };
        assert_eq!(factorize("test", matrix.as_mut()), Err(expected));
        let mut matrix = Mat::full(2, 2, 1.0);
        matrix[(1, 1)] += 1e-12;
        assert_eq!(factorize("test", matrix.as_mut()), Ok(()));
    }
}
