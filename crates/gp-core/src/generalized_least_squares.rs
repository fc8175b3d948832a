//! A learnt mean from sums over rows, for processes that keep no more of their data.

use faer::{Mat, MatRef};

use crate::cholesky::{factorize, log_determinant, solve_with};
use crate::kernel::column;
use crate::triangle::inverse;
use crate::{GpError, Monomials};

/// What sums over N rows tell of the coefficients β of a mean h(x)ᵀβ, with C the inverse of the covariance
/// of the outputs y less what is known of them.
///
/// # Source
/// Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), § 2.7.
pub struct GeneralizedLeastSquares<'a> {
    monomials: &'a Monomials,
    n_rows: usize,
    scale: f64,
    /// s yᵀCy.
    y_y: f64,
    /// s HᵀCy.
    basis_y: Vec<f64>,
    /// s HᵀCH.
    precision: Mat<f64>,
    /// Its Cholesky factor.
    factor: Mat<f64>,
    /// (HᵀCH)⁻¹HᵀCy.
    best: Vec<f64>,
}

impl<'a> GeneralizedLeastSquares<'a> {
    /// - `products`: s (y, H)ᵀC(y, H), of which the lower triangle is read; - `scale`: s.
    /// - `monomials`: h, which H has a column of each of; - `n_rows`: N.
    ///
    /// # Errors
    /// `UndeterminedSlope` if the rows do not tell the coefficient of some input; `NotPositiveDefinite`.
    pub fn new(
        products: MatRef<'_, f64>,
        scale: f64,
        monomials: &'a Monomials,
        n_rows: usize,
    ) -> Result<Self, GpError> {
        let n = products.nrows() - 1;
        let precision = Mat::from_fn(n, n, |i, j| products[(1 + i.max(j), 1 + i.min(j))]);
        let basis_y: Vec<f64> = (0..n).map(|i| products[(1 + i, 0)]).collect();
        let (mut factor, mut best) = (precision.clone(), basis_y.clone());
        if n == 1 {
            best[0] = basis_y[0] / precision[(0, 0)];
            factor[(0, 0)] = precision[(0, 0)].sqrt();
        } else {
            factorize("precision of the mean", factor.as_mut())
                .map_err(|error| undetermined(error, monomials, n_rows))?;
            solve_with(factor.as_ref(), &mut best);
        }
        let y_y = products[(0, 0)];
        Ok(Self { monomials, n_rows, scale, y_y, basis_y, precision, factor, best })
    }

    /// The most likely β.
    pub fn best(&self) -> &[f64] {
        &self.best
    }

    /// s rᵀCr of r = y − H β.
    pub fn quadratic(&self, coefficients: &[f64]) -> f64 {
        let c = coefficients;
        let linear: f64 = c.iter().zip(&self.basis_y).map(|(c, by)| 2.0 * c * by).sum();
        let term = |i: usize| -> f64 {
            c.iter().enumerate().map(|(j, other)| c[i] * other * self.precision[(i, j)]).sum()
        };
        self.y_y - linear + (0..c.len()).map(term).sum::<f64>()
    }

    /// Coefficients of independent directions of variance 1 in which β is uncertain.
    ///
    /// - `whole`: the diagonal of s HᵀDH with D the inverse of the covariance's diagonal part, from which
    ///   the m other coefficients of the model took away; - `m`: m.
    ///
    /// # Errors
    /// `NotPositiveDefinite` where only rounding is left.
    pub fn deviations(&self, whole: &[f64], m: usize) -> Result<Vec<Vec<f64>>, GpError> {
        for (k, whole) in whole.iter().enumerate() {
            let rest = self.factor[(k, k)].powi(2);
            if rest.is_nan() || rest <= m as f64 * f64::EPSILON * whole {
                let what = "precision of the mean";
                return Err(GpError::NotPositiveDefinite { what, size: k + 1, pivot: k });
            }
        }
        if let [_] = self.best[..] {
            return Ok(vec![vec![(self.precision[(0, 0)] / self.scale).sqrt().recip()]]);
        }
        let turned = inverse(self.factor.as_ref()).transpose() * faer::Scale(self.scale.sqrt());
        Ok((0..self.best.len()).map(|c| column(&turned, c).to_vec()).collect())
    }

    /// ln |HᵀCH| − ln |HᵀH|.
    ///
    /// - `spread`: HᵀH.
    ///
    /// # Errors
    /// As `new`.
    pub fn log_determinant(&self, spread: MatRef<'_, f64>) -> Result<f64, GpError> {
        let n = self.best.len();
        if n == 1 {
            return Ok((self.precision[(0, 0)] / self.scale / self.n_rows as f64).ln());
        }
        let mut spread = spread.to_owned();
        factorize("basis of the mean", spread.as_mut())
            .map_err(|error| undetermined(error, self.monomials, self.n_rows))?;
        let own = log_determinant(self.factor.as_ref()) - n as f64 * self.scale.ln();
        Ok(own - log_determinant(spread.as_ref()))
    }
}

/// Which slope the rows do not tell, where a matrix of the mean has no factor.
fn undetermined(error: GpError, monomials: &Monomials, n_rows: usize) -> GpError {
    match error {
        GpError::NotPositiveDefinite { pivot, .. } => match monomials.input(pivot) {
            Some(input) => GpError::UndeterminedSlope { input, n_rows },
            None => error,
        },
        _ => error,
    }
}
