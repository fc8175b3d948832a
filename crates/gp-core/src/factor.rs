//! What a process has factored of the covariance of its observations.

use faer::{Mat, MatMut, MatRef};

use crate::kernel::{Coregionalized, SharedRows, fill_lower_gram};
use crate::kronecker::{Kronecker, Mixing};
use crate::noise::Noise;
use crate::root::Root;
use crate::vector::{add_multiple, dot};
use crate::{Cholesky, GpError, Kernel};

pub(crate) const COVARIANCE: &str = "covariance of the observations";

/// A root of K(X, X) + noise.
#[derive(Clone, Debug)]
pub(crate) enum Factor {
    /// Of all rows together.
    Whole(Cholesky),
    /// Of several outputs at the same inputs.
    Shared(Kronecker),
}

impl Factor {
    /// # Errors
    /// `NotPositiveDefinite`.
    pub(crate) fn new(
        kernel: &dyn Kernel,
        x: MatRef<'_, f64>,
        noise: Noise<'_>,
    ) -> Result<Self, GpError> {
        match shared(kernel, x, noise) {
            Some(kronecker) => Ok(Self::Shared(kronecker)),
            None => Ok(Self::Whole(whole(kernel, x, noise)?)),
        }
    }

    /// Replaces B by T⁻¹B.
    pub(crate) fn solve_columns(&self, rhs: MatMut<'_, f64>) {
        match self {
            Self::Whole(cholesky) => cholesky.solve_lower(rhs),
            Self::Shared(kronecker) => kronecker.solve_columns(rhs),
        }
    }

    /// Replaces X by X T⁻ᵀ.
    pub(crate) fn solve_rows(&self, rows: MatMut<'_, f64>) {
        match self {
            Self::Whole(cholesky) => cholesky.solve_rows(rows),
            Self::Shared(kronecker) => kronecker.solve_rows(rows),
        }
    }

    /// The diagonal of the inverse; O(N³).
    pub(crate) fn inverse_diagonal(&self) -> Vec<f64> {
        match self {
            Self::Whole(cholesky) => cholesky.inverse_diagonal(),
            Self::Shared(kronecker) => kronecker.inverse_diagonal(),
        }
    }

    /// Replaces b by the covariance times b.
    pub(crate) fn multiply(&self, vector: &mut [f64]) {
        match self {
            Self::Whole(cholesky) => {
                let lower = |j: usize| &entries(cholesky.factor(), j)[j..];
                let n = vector.len();
                let across: Vec<f64> = (0..n).map(|j| dot(lower(j), &vector[j..])).collect();
                vector.fill(0.0);
                (0..n).for_each(|j| add_multiple(&mut vector[j..], across[j], lower(j)));
            }
            Self::Shared(kronecker) => kronecker.multiply(vector),
        }
    }
}

impl Root for Factor {
    fn n_rows(&self) -> usize {
        match self {
            Self::Whole(cholesky) => cholesky.factor().n_rows(),
            Self::Shared(kronecker) => kronecker.n_rows(),
        }
    }

    fn solve(&self, vectors: &mut [&mut [f64]]) {
        match self {
            Self::Whole(cholesky) => cholesky.factor().solve(vectors),
            Self::Shared(kronecker) => kronecker.solve(vectors),
        }
    }

    fn solve_transposed(&self, vector: &mut [f64]) {
        match self {
            Self::Whole(cholesky) => cholesky.factor().solve_transposed(vector),
            Self::Shared(kronecker) => kronecker.solve_transposed(vector),
        }
    }

    fn log_determinant(&self) -> f64 {
        match self {
            Self::Whole(cholesky) => cholesky.factor().log_determinant(),
            Self::Shared(kronecker) => kronecker.log_determinant(),
        }
    }
}

/// Of all rows together; O(N³).
///
/// # Errors
/// `NotPositiveDefinite`.
pub(crate) fn whole(
    kernel: &dyn Kernel,
    x: MatRef<'_, f64>,
    noise: Noise<'_>,
) -> Result<Cholesky, GpError> {
    let mut matrix = Mat::zeros(x.nrows(), x.nrows());
    fill_lower_gram(kernel, x, &mut matrix);
    (0..x.nrows()).for_each(|i| matrix[(i, i)] += noise.of_row(i));
    Cholesky::new(COVARIANCE, matrix)
}

/// Of several outputs at the same inputs; none where kernel, rows or noise are not so, or where outputs
/// without noise do not allow it.
fn shared(kernel: &dyn Kernel, x: MatRef<'_, f64>, noise: Noise<'_>) -> Option<Kronecker> {
    let (form, rows) = shared_rows(kernel, x, noise)?;
    let mut gram = Mat::zeros(rows.n, rows.n);
    fill_lower_gram(form.shared(), x.subrows(0, rows.n), &mut gram);
    let mixing = Mixing::new(&form.of_outputs(&rows), &form.of_noise(&rows, noise.common));
    Kronecker::new(mixing.ok()?, &gram, Vec::new()).ok()
}

/// The form B ⊗ K + R ⊗ I of the covariance, if it has it.
pub(crate) fn shared_rows(
    kernel: &dyn Kernel,
    x: MatRef<'_, f64>,
    noise: Noise<'_>,
) -> Option<(Coregionalized, SharedRows)> {
    if noise.of_rows.iter().any(|noise| *noise != 0.0) {
        return None;
    }
    Coregionalized::of(kernel, x)
}

fn entries(factor: MatRef<'_, f64>, j: usize) -> &[f64] {
    factor.col(j).try_as_col_major().expect("owned matrices are column-major").as_slice()
}
