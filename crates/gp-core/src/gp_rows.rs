//! Adding rows to an exact Gaussian process and removing them, in O(N²).

use std::borrow::Cow;
use std::sync::Arc;

use faer::{Mat, MatRef};

use crate::checks::{check_inputs, check_not_negative, check_outputs, check_range};
use crate::factor::{COVARIANCE, Factor, whole};
use crate::noise::Noise;
use crate::{Cholesky, Gp, GpError};

impl Gp {
    /// Takes in one more row with the hyperparameters as they are; O(N²), but for the first one beside
    /// several outputs at the same inputs, which then are no longer at the same ones: O(N³).
    ///
    /// - `x`: its inputs, D; `y`: its output.
    /// - `row_noise`: its known noise variance beside the common one, usually 0.
    ///
    /// # Errors
    /// `ShapeMismatch`, `NotFinite`, `Negative`; `NotPositiveDefinite` if it repeats another row and
    /// has no noise. The process is left as it was.
    pub fn add_row(&mut self, x: &[f64], y: f64, row_noise: f64) -> Result<(), GpError> {
        let (n, d) = (self.y.len(), self.x.ncols());
        check_inputs("inputs", MatRef::from_row_major_slice(x, 1, x.len()), d)?;
        check_outputs("outputs", &[y], 1)?;
        check_not_negative("noise variance of the row", row_noise)?;
        let mut covariance = vec![0.0; n];
        self.kernel().column(self.inputs(), x, &mut covariance);
        covariance.push(self.kernel().value(x, x) + self.noise_variance() + row_noise);
        let known = self.whole_factor()?;
        self.factor = Arc::new(Factor::Whole(known.with_row(COVARIANCE, covariance)?));
        if row_noise > 0.0 || !self.row_noise.is_empty() {
            self.row_noise.resize(n, 0.0);
            self.row_noise.push(row_noise);
        }
        let entry = |i: usize, j: usize| if i < n { self.x[(i, j)] } else { x[j] };
        self.x = Arc::new(Mat::from_fn(n + 1, d, entry));
        self.y.push(y);
        self.solve()
    }

    /// Forgets the row `index`; O(N²).
    ///
    /// # Errors
    /// `OutOfRange` if there is no such row; `TooFewRows` if it is the only one;
    /// `UndeterminedSlope` if the others do not tell the slopes of a linear mean. The process is left
    /// as it was.
    pub fn remove_row(&mut self, index: usize) -> Result<(), GpError> {
        let n = self.y.len();
        check_range("row", index as f64, 0.0, n as f64 - 1.0)?;
        if n == 1 {
            return Err(GpError::TooFewRows { needed: 2, actual: 1 });
        }
        let mut rest = self.clone();
        rest.factor = Arc::new(Factor::Whole(self.whole_factor()?.without_row(index)));
        let entry = |i: usize, j: usize| self.x[(i + usize::from(i >= index), j)];
        rest.x = Arc::new(Mat::from_fn(n - 1, self.x.ncols(), entry));
        rest.y.remove(index);
        if !rest.row_noise.is_empty() {
            rest.row_noise.remove(index);
        }
        rest.solve()?;
        *self = rest;
        Ok(())
    }

    /// The factor of all rows together.
    pub(crate) fn whole_factor(&self) -> Result<Cow<'_, Cholesky>, GpError> {
        Ok(match &*self.factor {
            Factor::Whole(cholesky) => Cow::Borrowed(cholesky),
            Factor::Shared(_) => {
                let noise = Noise { common: self.noise_variance(), of_rows: &self.row_noise };
                Cow::Owned(whole(self.kernel(), self.inputs(), noise)?)
            }
        })
    }
}
