//! The mean of a Gaussian process: known, or learnt by generalised least squares.

use std::f64::consts::PI;

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use crate::GpError;
use crate::checks::check_outputs;
use crate::cholesky::{factorize, log_determinant, solve_with};
use crate::triangle::{solve_lower, solve_upper};
use crate::vector::{add_multiple, dot};

/// The mean m(x) of a Gaussian process before data.
///
/// Learnt coefficients are hyperparameters at their maximum-likelihood values, the generalised
/// least squares β = (HᵀK⁻¹H)⁻¹HᵀK⁻¹y. Where they should be integrated out instead, add a
/// [`Constant`](crate::Constant) and a [`Linear`](crate::Linear) kernel; for a function of your own
/// see [`WithMean`](crate::WithMean).
///
/// # Source
/// Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), § 2.7.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Mean {
    /// A learnt constant: H is a column of ones.
    #[default]
    Estimated,
    /// A known constant, in the unit of the output.
    Fixed(f64),
    /// A learnt constant and a learnt slope an input: a row of H is (1, x).
    Linear,
}

impl Mean {
    /// # Errors
    /// `NotFinite` for a fixed value that is not.
    pub fn check(self) -> Result<(), GpError> {
        match self {
            Self::Fixed(value) => check_outputs("mean", &[value], 1),
            _ => Ok(()),
        }
    }

    /// As `check`, where only constants are known.
    ///
    /// # Errors
    /// As `check`; `LinearMean` for one.
    pub fn check_constant(self) -> Result<(), GpError> {
        if self == Self::Linear { Err(GpError::LinearMean) } else { self.check() }
    }

    /// The columns of H, with inputs taken from the first row.
    fn basis(self, x: MatRef<'_, f64>) -> Vec<Vec<f64>> {
        let n_slopes = match self {
            Self::Fixed(_) => return Vec::new(),
            Self::Estimated => 0,
            Self::Linear => x.ncols(),
        };
        let slope = |d: usize| x.col(d).iter().map(|value| value - x[(0, d)]).collect();
        std::iter::once(vec![1.0; x.nrows()]).chain((0..n_slopes).map(slope)).collect()
    }
}

/// A mean with its coefficients.
#[derive(Clone, Debug)]
pub(crate) struct Trend {
    /// At the first row, from which slopes count so that far inputs cost no digits.
    value: f64,
    first: Vec<f64>,
    slopes: Vec<f64>,
}

impl Trend {
    /// m at x = 0.
    pub(crate) fn constant(&self) -> f64 {
        self.value - dot(&self.first, &self.slopes)
    }

    /// One an input, or none of a constant mean.
    pub(crate) fn slopes(&self) -> &[f64] {
        &self.slopes
    }

    /// Writes m of every row.
    pub(crate) fn fill(&self, x: MatRef<'_, f64>, mean: &mut [f64]) {
        mean.fill(self.value);
        for (d, (slope, first)) in self.slopes.iter().zip(&self.first).enumerate() {
            for (mean, x) in mean.iter_mut().zip(x.col(d).iter()) {
                *mean += slope * (x - first);
            }
        }
    }
}

/// What outputs tell once the covariance is factored.
pub(crate) struct Residual {
    pub(crate) trend: Trend,
    /// α = K⁻¹(y − m).
    pub(crate) weights: Vec<f64>,
    /// ln p(y), in nats.
    pub(crate) log_likelihood: f64,
}

impl Residual {
    /// Solves for the mean's coefficients and the weights; O(N²).
    ///
    /// # Errors
    /// `NotPositiveDefinite` if inputs are too few or too equal for the slopes.
    pub(crate) fn solve(
        factor: MatRef<'_, f64>,
        x: MatRef<'_, f64>,
        y: &[f64],
        mean: Mean,
    ) -> Result<Self, GpError> {
        // Offsets are taken from the first output, so that the mean loses no digits to a far origin.
        let origin = match mean {
            Mean::Fixed(value) => value,
            _ => y[0],
        };
        let mut weights: Vec<f64> = y.iter().map(|y| y - origin).collect();
        let mut basis = mean.basis(x);
        let columns = basis.iter_mut().map(Vec::as_mut_slice);
        let mut vectors: Vec<&mut [f64]> =
            std::iter::once(weights.as_mut_slice()).chain(columns).collect();
        solve_lower(factor, &mut vectors);
        let coefficients = least_squares(&basis, &weights)?;
        for (coefficient, column) in coefficients.iter().zip(&basis) {
            add_multiple(&mut weights, -coefficient, column);
        }
        let quadratic = dot(&weights, &weights);
        solve_upper(factor, &mut weights);
        let normalization = y.len() as f64 * (2.0 * PI).ln();
        let log_likelihood = -0.5 * (quadratic + log_determinant(factor) + normalization);
        let (constant, slopes) = match coefficients.split_first() {
            Some((constant, slopes)) => (*constant, slopes.to_vec()),
            None => (0.0, Vec::new()),
        };
        let first = (0..slopes.len()).map(|d| x[(0, d)]).collect();
        let trend = Trend { value: origin + constant, first, slopes };
        Ok(Self { trend, weights, log_likelihood })
    }
}

/// The coefficients β that make |y − Hβ| least.
fn least_squares(basis: &[Vec<f64>], y: &[f64]) -> Result<Vec<f64>, GpError> {
    let p = basis.len();
    let mut square = Mat::from_fn(p, p, |i, j| dot(&basis[i], &basis[j]));
    factorize("precision of the mean's coefficients", square.as_mut())?;
    let mut coefficients: Vec<f64> = basis.iter().map(|column| dot(column, y)).collect();
    solve_with(square.as_ref(), &mut coefficients);
    Ok(coefficients)
}
