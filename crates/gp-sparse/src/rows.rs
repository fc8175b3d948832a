//! Adding rows to a sparse process and removing them, with parameters and pseudo-inputs as they are.

use faer::{Mat, MatRef};
use gp_core::GpError;
use gp_core::checks::check_row_noise;
use gp_core::cholesky::factorize;
use gp_core::kernel::fill_lower_gram;
use gp_core::triangle::inverse;

use crate::SparseGp;
use crate::block::Shared;
use crate::objective::PSEUDO_COVARIANCE;
use crate::part::Part;
use crate::reduction::reduction;
use crate::row_sums::{RowSums, Solved, spread};
use crate::sparse_gp::{check_data, rows_of};

impl SparseGp {
    /// Takes in more rows; O(rows M² + M³), and the same as if all had been there from the first.
    ///
    /// - `x`: inputs, N×D; `y`: outputs, N; `row_noise`: known noise variances of them, N, or none.
    ///
    /// # Errors
    /// As [`Self::fit_with_row_noise`]; `NoRowSums` of a process that was saved without them. The process
    /// is left as it was.
    pub fn add_rows(
        &mut self,
        x: MatRef<'_, f64>,
        y: &[f64],
        row_noise: &[f64],
    ) -> Result<(), GpError> {
        self.take(x, y, row_noise, 1.0)
    }

    /// Forgets rows, which have to be among those that it has seen: of the data it keeps sums alone, and
    /// cannot tell; O(rows M² + M³).
    ///
    /// # Errors
    /// As `add_rows`; `TooFewRows` if none is left; `NotPositiveDefinite` where rows were not among them.
    pub fn remove_rows(
        &mut self,
        x: MatRef<'_, f64>,
        y: &[f64],
        row_noise: &[f64],
    ) -> Result<(), GpError> {
        self.take(x, y, row_noise, -1.0)
    }

    /// The number of rows that it has seen, if it is known.
    pub fn n_rows(&self) -> Option<usize> {
        self.sums.as_ref().map(|sums| sums.n_rows)
    }

    fn take(
        &mut self,
        x: MatRef<'_, f64>,
        y: &[f64],
        row_noise: &[f64],
        sign: f64,
    ) -> Result<(), GpError> {
        check_data(self.kernel(), x, y)?;
        gp_core::checks::check_inputs("inputs", x, self.z.ncols())?;
        check_row_noise(row_noise, y.len())?;
        let mut sums = self.sums.clone().ok_or(GpError::NoRowSums)?;
        let n_rows =
            if sign > 0.0 { Some(sums.n_rows + y.len()) } else { sums.n_rows.checked_sub(y.len()) };
        sums.n_rows = n_rows
            .filter(|n| *n > 0)
            .ok_or(GpError::TooFewRows { needed: y.len() + 1, actual: sums.n_rows })?;
        sums.add(&self.sums_of(x, y, row_noise, &sums), sign);
        let factor = self.factor()?;
        let mut solved = Solved::new(self.z.nrows());
        solved.solve(&sums, factor.as_ref(), self.settings)?;
        let root_inverse = inverse(solved.root.as_ref());
        self.reduction = reduction(self.factor_inverse.as_ref(), root_inverse.as_ref())?;
        self.mean = solved.mean(sums.origin);
        self.deviations = solved.deviations();
        self.objective = solved.value;
        (self.root, self.root_inverse, self.sums) = (solved.root, root_inverse, Some(sums));
        Ok(())
    }

    /// The sums of other rows, about the origin and center of `like`.
    fn sums_of(&self, x: MatRef<'_, f64>, y: &[f64], row_noise: &[f64], like: &RowSums) -> RowSums {
        let (m, z) = (self.z.nrows(), rows_of(self.z.as_ref()));
        let shared = Shared {
            kernel: &*self.kernel,
            z: &z,
            approximation: self.settings.approximation,
            noise_variance: self.noise_variance,
            factor_inverse: self.factor_inverse.as_ref(),
        };
        let parts = Part::sums((x, y, row_noise), like.origin, &like.monomials, m, &shared);
        let mut sums =
            RowSums { n_rows: y.len(), spread: spread(&like.monomials, x), ..like.clone() };
        sums.merge(parts.iter());
        sums
    }

    /// L with K_uu = L Lᵀ.
    fn factor(&self) -> Result<Mat<f64>, GpError> {
        let m = self.z.nrows();
        let mut factor = Mat::zeros(m, m);
        fill_lower_gram(&*self.kernel, self.z.as_ref(), &mut factor);
        for a in 0..m {
            factor[(a, a)] *= 1.0 + self.settings.jitter;
        }
        factorize(PSEUDO_COVARIANCE, factor.as_mut())?;
        Ok(factor)
    }
}
