//! Roots of a covariance: what a process solves with.

use faer::MatRef;

use crate::cholesky::log_determinant;
use crate::triangle::{solve_lower, solve_upper};

/// A square T with T Tᵀ = Σ.
pub(crate) trait Root {
    /// Rows of Σ.
    fn n_rows(&self) -> usize;

    /// Replaces each vector b by T⁻¹b.
    fn solve(&self, vectors: &mut [&mut [f64]]);

    /// Replaces b by T⁻ᵀb.
    fn solve_transposed(&self, vector: &mut [f64]);

    /// ln |Σ|.
    fn log_determinant(&self) -> f64;

    /// Replaces b by Σ⁻¹b.
    fn solve_whole(&self, vector: &mut [f64]) {
        self.solve(&mut [&mut *vector]);
        self.solve_transposed(vector);
    }
}

/// A Cholesky factor, of which the lower triangle counts.
impl Root for MatRef<'_, f64> {
    fn n_rows(&self) -> usize {
        self.nrows()
    }

    fn solve(&self, vectors: &mut [&mut [f64]]) {
        solve_lower(*self, vectors);
    }

    fn solve_transposed(&self, vector: &mut [f64]) {
        solve_upper(*self, vector);
    }

    fn log_determinant(&self) -> f64 {
        log_determinant(*self)
    }
}
