//! The mean of a Gaussian process: known, or learnt by generalised least squares.

use std::f64::consts::PI;

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use crate::GpError;
use crate::checks::check_outputs;
use crate::cholesky::{factorize, log_determinant, solve_with};
use crate::kernel::{column, column_mut};
use crate::triangle::{inverse, solve_lower, solve_upper};
use crate::vector::{add_multiple, dot};

/// The mean m(x) of a Gaussian process before data.
///
/// Nothing is known of learnt coefficients β before the data: they are integrated out under a prior
/// without end, the limit of N(0, s² I) for large s. Their mean is that of generalised least squares,
/// β = (HᵀK⁻¹H)⁻¹HᵀK⁻¹y, and what the data leave open of them is part of every variance. For a
/// coefficient of which something is known add a [`Constant`](crate::Constant) or a
/// [`Linear`](crate::Linear) kernel to a fixed mean; for a function of your own see
/// [`WithMean`](crate::WithMean).
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

    /// How many coefficients are learnt, with `n_inputs` inputs.
    pub fn n_coefficients(self, n_inputs: usize) -> usize {
        match self {
            Self::Fixed(_) => 0,
            Self::Estimated => 1,
            Self::Linear => 1 + n_inputs,
        }
    }

    /// The columns of H, with inputs taken from the first row.
    fn basis(self, x: MatRef<'_, f64>) -> Vec<Vec<f64>> {
        let column = |k: usize| match k.checked_sub(1) {
            None => vec![1.0; x.nrows()],
            Some(d) => x.col(d).iter().map(|value| value - x[(0, d)]).collect(),
        };
        (0..self.n_coefficients(x.ncols())).map(column).collect()
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
    /// Of coefficients in the order of H's columns, and `origin` added to the constant.
    fn new(origin: f64, coefficients: &[f64], x: MatRef<'_, f64>) -> Self {
        let (constant, slopes) = match coefficients.split_first() {
            Some((constant, slopes)) => (*constant, slopes.to_vec()),
            None => (0.0, Vec::new()),
        };
        let first = (0..slopes.len()).map(|d| x[(0, d)]).collect();
        Self { value: origin + constant, first, slopes }
    }

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

/// A direction in which a learnt mean is uncertain: f moves by z d(x), d(x) = e(x) + k(x, X) w, with
/// z ~ N(0, 1) that is independent of all else.
///
/// The e are the basis functions h, turned and scaled so that (eᵀK⁻¹e) = 1 and e'ᵀK⁻¹e = 0 on the
/// data, and w = −K⁻¹e(X): the squares d(x)² add up to rᵀ(HᵀK⁻¹H)⁻¹r with r = h(x) − HᵀK⁻¹k(X, x).
///
/// # Source
/// Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), § 2.7, eq. 2.42.
#[derive(Clone, Debug)]
pub(crate) struct Deviation {
    /// e.
    pub(crate) trend: Trend,
    /// w.
    pub(crate) weights: Vec<f64>,
}

impl Deviation {
    /// Replaces the lower triangle of K⁻¹ by that of K⁻¹ − Σ w wᵀ, the precision of what of the data
    /// no learnt mean touches.
    pub(crate) fn project(all: &[Self], inverse: &mut Mat<f64>) {
        for Self { weights, .. } in all {
            for (j, weight) in weights.iter().enumerate() {
                add_multiple(&mut column_mut(inverse, j)[j..], -weight, &weights[j..]);
            }
        }
    }
}

/// What outputs tell once the covariance is factored.
pub(crate) struct Residual {
    pub(crate) trend: Trend,
    /// One a learnt coefficient.
    pub(crate) deviations: Vec<Deviation>,
    /// α = K⁻¹(y − m).
    pub(crate) weights: Vec<f64>,
    /// ln p(y), in nats.
    pub(crate) log_likelihood: f64,
}

impl Residual {
    /// Solves for the mean's coefficients and the weights; O(N²).
    ///
    /// Of P learnt coefficients ln p has no more than N − P numbers to be a density of: those
    /// combinations of the outputs, orthogonal to each other and of length 1, that no mean touches.
    /// It is −½ αᵀ(y − m) − ½ ln |K| − ½ ln |HᵀK⁻¹H| + ½ ln |HᵀH| − ½ (N − P) ln 2π, which is the
    /// vague limit of the integral over the mean, less what the data have no part in.
    ///
    /// # Errors
    /// `UndeterminedSlope` if rows are too few or too equal for the slopes; `NotPositiveDefinite`.
    ///
    /// # Source
    /// Rasmussen & Williams (2006), eq. 2.45; with ½ ln |HᵀH|: Harville, Bayesian inference for
    /// variance components using only error contrasts (1974).
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
        let spread = log_spread(&basis)?;
        let columns = basis.iter_mut().map(Vec::as_mut_slice);
        let mut vectors: Vec<&mut [f64]> =
            std::iter::once(weights.as_mut_slice()).chain(columns).collect();
        solve_lower(factor, &mut vectors);
        let mut precision = products(&basis);
        factorize("precision of the mean's coefficients", precision.as_mut())?;
        let mut coefficients: Vec<f64> = basis.iter().map(|column| dot(column, &weights)).collect();
        solve_with(precision.as_ref(), &mut coefficients);
        for (coefficient, column) in coefficients.iter().zip(&basis) {
            add_multiple(&mut weights, -coefficient, column);
        }
        let quadratic = dot(&weights, &weights);
        solve_upper(factor, &mut weights);
        let normalization = (y.len() - basis.len()) as f64 * (2.0 * PI).ln();
        let of_mean = log_determinant(precision.as_ref()) - spread;
        let log_likelihood = -0.5 * (quadratic + log_determinant(factor) + of_mean + normalization);
        let trend = Trend::new(origin, &coefficients, x);
        let deviations = deviations(factor, x, &basis, precision.as_ref());
        Ok(Self { trend, deviations, weights, log_likelihood })
    }
}

/// From L⁻¹H and the Cholesky factor C of HᵀK⁻¹H: e = C⁻¹h.
fn deviations(
    factor: MatRef<'_, f64>,
    x: MatRef<'_, f64>,
    basis: &[Vec<f64>],
    precision: MatRef<'_, f64>,
) -> Vec<Deviation> {
    if basis.is_empty() {
        return Vec::new();
    }
    let turned = inverse(precision).transpose().to_owned();
    let deviation = |c: usize| {
        let coefficients = column(&turned, c);
        let mut weights = vec![0.0; x.nrows()];
        for (coefficient, column) in coefficients.iter().zip(basis) {
            add_multiple(&mut weights, -coefficient, column);
        }
        solve_upper(factor, &mut weights);
        Deviation { trend: Trend::new(0.0, coefficients, x), weights }
    };
    (0..basis.len()).map(deviation).collect()
}

/// ln |HᵀH|.
fn log_spread(basis: &[Vec<f64>]) -> Result<f64, GpError> {
    if basis.first().is_some_and(|column| column.len() < basis.len()) {
        let n_rows = basis[0].len();
        return Err(GpError::UndeterminedSlope { input: n_rows - 1, n_rows });
    }
    let mut square = products(basis);
    match factorize("basis of the mean", square.as_mut()) {
        Ok(()) => Ok(log_determinant(square.as_ref())),
        Err(GpError::NotPositiveDefinite { pivot, .. }) if pivot > 0 => {
            Err(GpError::UndeterminedSlope { input: pivot - 1, n_rows: basis[0].len() })
        }
        Err(error) => Err(error),
    }
}

/// HᵀH.
fn products(basis: &[Vec<f64>]) -> Mat<f64> {
    Mat::from_fn(basis.len(), basis.len(), |i, j| dot(&basis[i], &basis[j]))
}
