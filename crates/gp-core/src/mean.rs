//! The mean of a Gaussian process: known, or learnt by generalised least squares.

use std::f64::consts::PI;

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use crate::checks::{check_outputs, check_range};
use crate::cholesky::{factorize, log_determinant, solve_with};
use crate::kernel::{column, column_mut};
use crate::root::Root;
use crate::triangle::inverse;
use crate::vector::{add_multiple, dot};
use crate::{GpError, Monomials};

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
    /// A learnt coefficient of every product of at most so many inputs, 1 to 6: with 2 a row of H is 1, all
    /// inputs, their squares and their products in pairs.
    Polynomial(u32),
}

impl Mean {
    /// # Errors
    /// `NotFinite` for a fixed value that is not; `OutOfRange` for a degree.
    pub fn check(self) -> Result<(), GpError> {
        match self {
            Self::Fixed(value) => check_outputs("mean", &[value], 1),
            Self::Polynomial(degree) => {
                check_range("degree of the mean", f64::from(degree), 1.0, 6.0)
            }
            _ => Ok(()),
        }
    }

    /// As `check`, where only constants are known.
    ///
    /// # Errors
    /// As `check`; `LinearMean` for one, and for a polynomial.
    pub fn check_constant(self) -> Result<(), GpError> {
        match self {
            Self::Linear | Self::Polynomial(_) => Err(GpError::LinearMean),
            _ => self.check(),
        }
    }

    /// How many coefficients are learnt, with `n_inputs` inputs.
    pub fn n_coefficients(self, n_inputs: usize) -> usize {
        match self.degree() {
            None => 0,
            Some(degree) => (1..=degree as usize).fold(1, |n, k| n * (n_inputs + k) / k),
        }
    }

    /// The degree of a learnt mean, 0 of a constant; none of a known one.
    pub fn degree(self) -> Option<u32> {
        match self {
            Self::Fixed(_) => None,
            Self::Estimated => Some(0),
            Self::Linear => Some(1),
            Self::Polynomial(degree) => Some(degree),
        }
    }

    /// The functions that coefficients are learnt of, about the first row; none of a known mean.
    fn monomials(self, x: MatRef<'_, f64>) -> Option<Monomials> {
        let degree = self.degree()?;
        let first: Vec<f64> = x.row(0).iter().copied().collect();
        Some(Monomials::new(degree, &first))
    }
}

/// A mean with its coefficients.
#[derive(Clone, Debug)]
pub(crate) struct Trend {
    /// At the first row, from which products count so that far inputs cost no digits.
    value: f64,
    monomials: Monomials,
    /// Of all products but the 1.
    coefficients: Vec<f64>,
}

impl Trend {
    /// Of coefficients in the order of H's columns, and `origin` added to the constant.
    fn new(origin: f64, coefficients: &[f64], monomials: Option<&Monomials>) -> Self {
        let monomials = monomials.cloned().unwrap_or_else(|| Monomials::new(0, &[]));
        let (constant, rest) = match coefficients.split_first() {
            Some((constant, rest)) => (*constant, rest.to_vec()),
            None => (0.0, Vec::new()),
        };
        Self { value: origin + constant, monomials, coefficients: rest }
    }

    /// m at x = 0.
    pub(crate) fn constant(&self) -> f64 {
        if self.monomials.degree() < 2 {
            return self.value
                - dot(&self.monomials.center()[..self.coefficients.len()], &self.coefficients);
        }
        let mut value = [0.0];
        self.fill(Mat::zeros(1, self.monomials.center().len()).as_ref(), &mut value);
        value[0]
    }

    /// Whether it is no more than a constant and slopes.
    pub(crate) fn is_linear(&self) -> bool {
        self.monomials.degree() < 2
    }

    /// Slopes at the first row, one an input; none of a constant mean.
    pub(crate) fn slopes(&self) -> &[f64] {
        &self.coefficients[..self.coefficients.len().min(self.monomials.center().len())]
    }

    /// Adds the gradient of m at `x`.
    pub(crate) fn add_gradient(&self, x: &[f64], gradient: &mut [f64]) {
        self.monomials.add_gradient(x, &self.coefficients, gradient);
    }

    /// Writes m of every row.
    pub(crate) fn fill(&self, x: MatRef<'_, f64>, mean: &mut [f64]) {
        mean.fill(self.value);
        self.monomials.add(x, &self.coefficients, mean);
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
        root: &impl Root,
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
        let monomials = mean.monomials(x);
        let mut basis = monomials.as_ref().map_or_else(Vec::new, |all| all.columns(x));
        let spread = log_spread(&basis, monomials.as_ref())?;
        let columns = basis.iter_mut().map(Vec::as_mut_slice);
        let mut vectors: Vec<&mut [f64]> =
            std::iter::once(weights.as_mut_slice()).chain(columns).collect();
        root.solve(&mut vectors);
        let mut precision = products(&basis);
        factorize("precision of the mean's coefficients", precision.as_mut())?;
        let mut coefficients: Vec<f64> = basis.iter().map(|column| dot(column, &weights)).collect();
        solve_with(precision.as_ref(), &mut coefficients);
        for (coefficient, column) in coefficients.iter().zip(&basis) {
            add_multiple(&mut weights, -coefficient, column);
        }
        let quadratic = dot(&weights, &weights);
        root.solve_transposed(&mut weights);
        let normalization = (y.len() - basis.len()) as f64 * (2.0 * PI).ln();
        let of_mean = log_determinant(precision.as_ref()) - spread;
        let log_likelihood = -0.5 * (quadratic + root.log_determinant() + of_mean + normalization);
        let trend = Trend::new(origin, &coefficients, monomials.as_ref());
        let deviations = deviations(root, monomials.as_ref(), &basis, precision.as_ref());
        Ok(Self { trend, deviations, weights, log_likelihood })
    }
}

/// From T⁻¹H and the Cholesky factor C of HᵀK⁻¹H: e = C⁻¹h.
fn deviations(
    root: &impl Root,
    monomials: Option<&Monomials>,
    basis: &[Vec<f64>],
    precision: MatRef<'_, f64>,
) -> Vec<Deviation> {
    if basis.is_empty() {
        return Vec::new();
    }
    let turned = inverse(precision).transpose().to_owned();
    let deviation = |c: usize| {
        let coefficients = column(&turned, c);
        let mut weights = vec![0.0; root.n_rows()];
        for (coefficient, column) in coefficients.iter().zip(basis) {
            add_multiple(&mut weights, -coefficient, column);
        }
        root.solve_transposed(&mut weights);
        Deviation { trend: Trend::new(0.0, coefficients, monomials), weights }
    };
    (0..basis.len()).map(deviation).collect()
}

/// ln |HᵀH|.
fn log_spread(basis: &[Vec<f64>], monomials: Option<&Monomials>) -> Result<f64, GpError> {
    let input = |column: usize| monomials.and_then(|all| all.input(column)).unwrap_or(0);
    if basis.first().is_some_and(|column| column.len() < basis.len()) {
        let n_rows = basis[0].len();
        return Err(GpError::UndeterminedSlope { input: input(n_rows), n_rows });
    }
    let mut square = products(basis);
    match factorize("basis of the mean", square.as_mut()) {
        Ok(()) => Ok(log_determinant(square.as_ref())),
        Err(GpError::NotPositiveDefinite { pivot, .. }) if pivot > 0 => {
            Err(GpError::UndeterminedSlope { input: input(pivot), n_rows: basis[0].len() })
        }
        Err(error) => Err(error),
    }
}

/// HᵀH.
fn products(basis: &[Vec<f64>]) -> Mat<f64> {
    Mat::from_fn(basis.len(), basis.len(), |i, j| dot(&basis[i], &basis[j]))
}
