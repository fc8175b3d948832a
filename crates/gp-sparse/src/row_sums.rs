//! Sums over rows of data, and what they tell of the pseudo-outputs and the mean.

use std::f64::consts::PI;

use faer::{Mat, MatRef};
use gp_core::cholesky::{factorize, log_determinant, solve_with};
use gp_core::kernel::{column, column_mut};
use gp_core::triangle::{inverse, solve_lower};
use gp_core::vector::dot;
use gp_core::{GpError, Mean, Monomials};

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
        let told = Told::new(sums, &of_y, &of_basis)?;
        let (known, factors) = ((&*of_y, &*of_basis), [self.root.as_ref(), factor]);
        let coefficients = match settings.mean {
            Mean::Fixed(value) => vec![value - sums.origin],
            _ => told.best.clone(),
        };
        let quadratic = told.quadratic(&coefficients);
        self.responses = vec![Response::solve((1.0, coefficients), known, factors)];
        let mut determinant = log_determinant(self.root.as_ref()) + sums.log_determinant;
        let mut n_told = sums.n_rows;
        if settings.mean.degree().is_some() {
            let deviations = told.deviations(m, sums)?.into_iter();
            let respond = |coefficients| Response::solve((0.0, coefficients), known, factors);
            self.responses.extend(deviations.map(respond));
            determinant += told.log_determinant(sums)?;
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

/// What is told of the mean, with C the inverse of the covariance of the observations.
struct Told {
    /// yᵀCy.
    y_y: f64,
    /// HᵀCy.
    basis_y: Vec<f64>,
    /// HᵀCH.
    precision: Mat<f64>,
    /// Its Cholesky factor.
    factor: Mat<f64>,
    /// (HᵀCH)⁻¹HᵀCy.
    best: Vec<f64>,
}

impl Told {
    /// - `of_y`, `of_basis`: R⁻¹VᵀD⁻¹(y, H).
    fn new(sums: &RowSums, of_y: &[f64], of_basis: &[Vec<f64>]) -> Result<Self, GpError> {
        let (m, n) = (of_y.len(), of_basis.len());
        let entry = |i: usize, j: usize| sums.square[(m + 1 + i.max(j), m + 1 + i.min(j))];
        let precision = Mat::from_fn(n, n, |i, j| entry(i, j) - dot(&of_basis[i], &of_basis[j]));
        let with_y =
            |(i, basis): (usize, &Vec<f64>)| sums.square[(m + 1 + i, m)] - dot(basis, of_y);
        let basis_y: Vec<f64> = of_basis.iter().enumerate().map(with_y).collect();
        let y_y = sums.square[(m, m)] - dot(of_y, of_y);
        let (mut factor, mut best) = (precision.clone(), basis_y.clone());
        if n == 1 {
            best[0] = basis_y[0] / precision[(0, 0)];
            factor[(0, 0)] = precision[(0, 0)].sqrt();
        } else {
            factorize("precision of the mean", factor.as_mut())
                .map_err(|e| undetermined(e, sums))?;
            solve_with(factor.as_ref(), &mut best);
        }
        Ok(Self { y_y, basis_y, precision, factor, best })
    }

    /// rᵀCr of r = y − H c.
    fn quadratic(&self, c: &[f64]) -> f64 {
        let linear: f64 = c.iter().zip(&self.basis_y).map(|(c, by)| 2.0 * c * by).sum();
        let term = |i: usize| -> f64 {
            c.iter().enumerate().map(|(j, other)| c[i] * other * self.precision[(i, j)]).sum()
        };
        self.y_y - linear + (0..c.len()).map(term).sum::<f64>()
    }

    /// Coefficients of independent directions of variance 1 in which the mean is uncertain.
    fn deviations(&self, m: usize, sums: &RowSums) -> Result<Vec<Vec<f64>>, GpError> {
        for k in 0..self.best.len() {
            let whole = sums.square[(m + 1 + k, m + 1 + k)];
            if self.factor[(k, k)].powi(2).is_nan()
                || self.factor[(k, k)].powi(2) <= m as f64 * f64::EPSILON * whole
            {
                let what = "precision of the mean";
                return Err(GpError::NotPositiveDefinite { what, size: k + 1, pivot: k });
            }
        }
        if let [_] = self.best[..] {
            return Ok(vec![vec![self.precision[(0, 0)].sqrt().recip()]]);
        }
        let turned = inverse(self.factor.as_ref()).transpose().to_owned();
        Ok((0..self.best.len()).map(|c| column(&turned, c).to_vec()).collect())
    }

    /// ln |HᵀCH| − ln |HᵀH|.
    fn log_determinant(&self, sums: &RowSums) -> Result<f64, GpError> {
        if self.best.len() == 1 {
            return Ok((self.precision[(0, 0)] / sums.n_rows as f64).ln());
        }
        let mut spread = sums.spread.clone();
        factorize("basis of the mean", spread.as_mut()).map_err(|e| undetermined(e, sums))?;
        Ok(log_determinant(self.factor.as_ref()) - log_determinant(spread.as_ref()))
    }
}

/// Which slope the rows do not tell, where a matrix of the mean has no factor.
fn undetermined(error: GpError, sums: &RowSums) -> GpError {
    match error {
        GpError::NotPositiveDefinite { pivot, .. } => match sums.monomials.input(pivot) {
            Some(input) => GpError::UndeterminedSlope { input, n_rows: sums.n_rows },
            None => error,
        },
        _ => error,
    }
}
