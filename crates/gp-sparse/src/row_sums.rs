//! Sums over rows of data, and what they tell of the pseudo-outputs and the mean.

use std::f64::consts::PI;

use faer::{Mat, MatRef};
use gp_core::cholesky::{factorize, log_determinant};
use gp_core::kernel::{column, column_mut};
use gp_core::triangle::solve_lower;
use gp_core::vector::dot;
use gp_core::{GeneralizedLeastSquares, GpError, Mean, Monomials};

use crate::SparseSettings;
use crate::block::{Response, Sums};
use crate::deviation::Deviation;

pub(crate) const PRECISION: &str = "precision of the pseudo-outputs";

/// All that a sparse process needs of the rows, for given parameters and pseudo-inputs.
#[derive(Clone, Debug)]
pub(crate) struct RowSums {
    pub(crate) n_rows: usize,
    /// Subtracted from all outputs, so that far offsets cost no digits.
    pub(crate) origin: f64,
    /// What the mean is a sum of, about the center of the inputs.
    pub(crate) monomials: Monomials,
    /// (V, y, H)ᵀ D⁻¹ (V, y, H), the lower triangle.
    pub(crate) square: Mat<f64>,
    /// HᵀH.
    pub(crate) spread: Mat<f64>,
    pub(crate) log_determinant: f64,
    pub(crate) penalty: f64,
}

impl RowSums {
    /// Of rows, before parameters are known, with `m` pseudo-inputs.
    pub(crate) fn new(x: MatRef<'_, f64>, y: &[f64], m: usize, mean: Mean) -> Self {
        let center: Vec<f64> =
            (0..x.ncols()).map(|d| x.col(d).iter().sum::<f64>() / x.nrows() as f64).collect();
        let monomials = Monomials::new(mean.degree().unwrap_or(0), &center);
        let width = m + 1 + monomials.count();
        Self {
            n_rows: y.len(),
            origin: y.iter().sum::<f64>() / y.len() as f64,
            square: Mat::zeros(width, width),
            spread: spread(&monomials, x),
            monomials,
            log_determinant: 0.0,
            penalty: 0.0,
        }
    }

    /// Takes the place of what was there by the sums of parts.
    pub(crate) fn merge<'a>(&mut self, parts: impl Iterator<Item = &'a Sums> + Clone) {
        merge_lower(&mut self.square, parts.clone().map(|part| &part.square));
        self.log_determinant = parts.clone().map(|part| part.log_determinant).sum();
        self.penalty = parts.map(|part| part.penalty).sum();
    }

    /// Moves the products by a share of the way to `scale` times those of parts.
    pub(crate) fn move_to<'a>(
        &mut self,
        parts: impl Iterator<Item = &'a Sums> + Clone,
        scale: f64,
        share: f64,
    ) {
        let mut square = Mat::zeros(self.square.nrows(), self.square.ncols());
        merge_lower(&mut square, parts.map(|part| &part.square));
        for j in 0..square.ncols() {
            for (old, new) in column_mut(&mut self.square, j).iter_mut().zip(column(&square, j)) {
                *old += share * (scale * new - *old);
            }
        }
    }

    /// (y, H)ᵀC(y, H) with C the inverse of the covariance of the observations, the lower triangle.
    ///
    /// - `of_y`, `of_basis`: R⁻¹VᵀD⁻¹(y, H).
    fn unexplained(&self, of_y: &[f64], of_basis: &[Vec<f64>]) -> Mat<f64> {
        let (m, n) = (of_y.len(), of_basis.len());
        let explained = |i: usize| if i == 0 { of_y } else { of_basis[i - 1].as_slice() };
        let entry = |i: usize, j: usize| match i < j {
            true => 0.0,
            false => self.square[(m + i, m + j)] - dot(explained(i), explained(j)),
        };
        Mat::from_fn(1 + n, 1 + n, entry)
    }

    /// Adds `sign` times the sums of other rows.
    pub(crate) fn add(&mut self, other: &Self, sign: f64) {
        self.square += faer::Scale(sign) * &other.square;
        self.spread += faer::Scale(sign) * &other.spread;
        self.log_determinant += sign * other.log_determinant;
        self.penalty += sign * other.penalty;
    }
}

/// The sum of lower triangles.
pub(crate) fn merge_lower<'a>(sum: &mut Mat<f64>, parts: impl Iterator<Item = &'a Mat<f64>>) {
    sum.fill(0.0);
    for part in parts {
        for j in 0..part.ncols() {
            let column_sum = &mut column_mut(sum, j)[j..];
            for (sum, part) in column_sum.iter_mut().zip(&column(part, j)[j..]) {
                *sum += part;
            }
        }
    }
}

/// HᵀH of some rows.
pub(crate) fn spread(monomials: &Monomials, x: MatRef<'_, f64>) -> Mat<f64> {
    let columns = monomials.columns(x);
    Mat::from_fn(columns.len(), columns.len(), |i, j| dot(&columns[i], &columns[j]))
}

/// What the sums tell.
#[derive(Clone)]
pub(crate) struct Solved {
    /// The Cholesky factor R of B = I + VᵀD⁻¹V.
    pub(crate) root: Mat<f64>,
    /// That of the mean, less the data's origin, and those of the deviations of a learnt mean.
    pub(crate) responses: Vec<Response>,
    /// The objective, in nats.
    pub(crate) value: f64,
}

impl Solved {
    pub(crate) fn new(m: usize) -> Self {
        Self { root: Mat::zeros(m, m), responses: Vec::new(), value: 0.0 }
    }

    /// Solves for the weights and the mean; `factor` is L.
    ///
    /// With a learnt mean the value is a density of what the mean does not touch, as in
    /// [`gp_core::Gp::log_marginal_likelihood`].
    ///
    /// # Errors
    /// `NotPositiveDefinite`; `UndeterminedSlope`.
    pub(crate) fn solve(
        &mut self,
        sums: &RowSums,
        factor: MatRef<'_, f64>,
        settings: SparseSettings,
    ) -> Result<(), GpError> {
        let m = self.root.nrows();
        self.root.copy_from(sums.square.as_ref().get(..m, ..m));
        for a in 0..m {
            self.root[(a, a)] += 1.0;
        }
        factorize(PRECISION, self.root.as_mut())?;
        let row = |i: usize| (0..m).map(|a| sums.square[(i, a)]).collect::<Vec<f64>>();
        let mut of_y = row(m);
        let mut of_basis: Vec<Vec<f64>> = (m + 1..sums.square.nrows()).map(row).collect();
        let mut vectors = vec![of_y.as_mut_slice()];
        vectors.extend(of_basis.iter_mut().map(Vec::as_mut_slice));
        solve_lower(self.root.as_ref(), &mut vectors);
        let products = sums.unexplained(&of_y, &of_basis);
        let (monomials, n_rows) = (&sums.monomials, sums.n_rows);
        let told = GeneralizedLeastSquares::new(products.as_ref(), 1.0, monomials, n_rows)?;
        let (known, factors) = ((&*of_y, &*of_basis), [self.root.as_ref(), factor]);
        let coefficients = match settings.mean {
            Mean::Fixed(value) => vec![value - sums.origin],
            _ => told.best().to_vec(),
        };
        let quadratic = told.quadratic(&coefficients);
        self.responses = vec![Response::solve((1.0, coefficients), known, factors)];
        let mut determinant = log_determinant(self.root.as_ref()) + sums.log_determinant;
        let mut n_told = sums.n_rows;
        if settings.mean.degree().is_some() {
            let whole: Vec<f64> =
                (m + 1..sums.square.nrows()).map(|k| sums.square[(k, k)]).collect();
            let deviations = told.deviations(&whole, m)?.into_iter();
            let respond = |coefficients| Response::solve((0.0, coefficients), known, factors);
            self.responses.extend(deviations.map(respond));
            determinant += told.log_determinant(sums.spread.as_ref())?;
            n_told -= of_basis.len();
        }
        let normalization = n_told as f64 * (2.0 * PI).ln();
        let penalty = (1.0 - settings.approximation.alpha()) * sums.penalty;
        self.value = -0.5 * (quadratic + determinant + normalization + penalty);
        Ok(())
    }

    /// The mean at x is c + Σ g_k h_k(x) + k(x, Z) w.
    pub(crate) fn mean(&self, origin: f64) -> Deviation {
        let mut mean = function(&self.responses[0]);
        mean.constant += origin;
        mean
    }

    /// By how much the function moves with a standard deviation of each learnt coefficient.
    pub(crate) fn deviations(&self) -> Vec<Deviation> {
        self.responses[1..].iter().map(function).collect()
    }
}

fn function(response: &Response) -> Deviation {
    let Response { coefficients, weights, .. } = response;
    let (constant, coefficients) = coefficients.split_first().expect("1 is in every basis");
    Deviation { constant: *constant, coefficients: coefficients.to_vec(), weights: weights.clone() }
}
