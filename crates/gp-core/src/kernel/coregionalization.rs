//! The covariance of several outputs.

use faer::Mat;

use super::{Kernel, KernelSpec, Parameter, Role};
use crate::checks::{check_count, check_outputs, check_range};
use crate::{GpError, Inputs};

/// k(i, j) = B_ij, the covariance of outputs i and j, which its one input numbers from 0.
///
/// Times a kernel of the other inputs it makes several outputs one function (the intrinsic model of
/// coregionalisation, ICM), and sums of such products the linear one (LMC). Rows may lack outputs: a row
/// of the data is one output at one input (see `stack`). An input between two numbers is the nearest.
/// Where all outputs are at the same inputs, as `stack` puts them without gaps, P factors of N rows stand for
/// one of P·N: of one such product, plus white kernels times covariances of outputs, and common noise.
///
/// B_ij = √(v_i v_j) C_ij. The correlations are C = L Lᵀ with rows of unit length from partial
/// correlations ρ, L_ij = ρ_ij Π_k<j √(1 − ρ_ik²), so that any odds make a covariance; outputs that
/// share fewer functions than there are outputs drive odds to the walls.
/// Of a rank R ([`Self::with_rank`]) outputs share R functions beside one of each of their own: C is L Lᵀ
/// with R columns that all rows have and one a row, L_ir = ρ_ir Π_k<r √(1 − ρ_ik²), and
/// [`GpBuilder::fit_best`](crate::GpBuilder::fit_best) chooses between ranks.
/// Parameters: `coregionalization.variance[i]`, and the odds (1 + ρ)/(1 − ρ), without unit,
/// `coregionalization.odds[i,j]`, of which 1 is no correlation.
///
/// # Source
/// Bonilla, Chai & Williams, Multi-task Gaussian process prediction (2007); Lewandowski, Kurowicka &
/// Joe, Generating random correlation matrices (2009), for the partial correlations.
#[derive(Clone, Debug, PartialEq)]
pub struct Coregionalization {
    variances: Vec<f64>,
    /// Of (1, 0), (2, 0), (2, 1) and so on; of a rank those of each output with the shared functions.
    odds: Vec<f64>,
    rank: Option<usize>,
    /// B by rows, and its slopes by the log-parameters.
    covariance: Vec<f64>,
    slopes: Vec<Vec<f64>>,
}

impl Coregionalization {
    /// Outputs of variance 1 without correlation, which learning starts from.
    pub fn new(n_outputs: usize) -> Self {
        let n_pairs = n_outputs * n_outputs.saturating_sub(1) / 2;
        Self::from_odds(&vec![1.0; n_outputs], &vec![1.0; n_pairs])
    }

    /// Outputs that share nothing: a variance for each, such as that of its noise.
    pub fn independent(n_outputs: usize) -> Self {
        Self::from_odds(&vec![1.0; n_outputs], &[])
    }

    /// Outputs of given variances, and odds of their partial correlations.
    ///
    /// - `odds`: of the pairs (1, 0), (2, 0), (2, 1) and so on; none if they share nothing.
    pub fn from_odds(variances: &[f64], odds: &[f64]) -> Self {
        Self::of(variances, odds, None)
    }

    /// Outputs of variance 1 that share `rank` functions, 1 up to their number, beside one of their own.
    ///
    /// Learning starts from a first function that all share, and others that outputs share with signs in
    /// turn.
    pub fn with_rank(n_outputs: usize, rank: usize) -> Self {
        let pairs = loadings(n_outputs, rank);
        let odds = pairs.into_iter().map(|(i, r)| match (r, i % 2) {
            (0, _) => 3.0,
            (_, 0) => 2.0,
            _ => 0.5,
        });
        Self::of(&vec![1.0; n_outputs], &odds.collect::<Vec<_>>(), Some(rank))
    }

    pub(super) fn of(variances: &[f64], odds: &[f64], rank: Option<usize>) -> Self {
        let n = variances.len();
        let factor = Factor::new(n, odds, rank);
        let width = factor.width;
        let covariance = |left: &[f64], right: &[f64]| -> Vec<f64> {
            let entry = |i: usize, j: usize| {
                let row = |of: usize| of * width..(of + 1) * width;
                let (a, b) = (&left[row(i)], &right[row(j)]);
                let correlation: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
                (variances[i] * variances[j]).sqrt() * correlation
            };
            (0..n * n).map(|k| entry(k / n, k % n)).collect()
        };
        let whole = covariance(&factor.entries, &factor.entries);
        let by_variance = |v: usize| {
            let share = |k: usize| 0.5 * (f64::from(k / n == v) + f64::from(k % n == v));
            whole.iter().enumerate().map(|(k, b)| share(k) * b).collect()
        };
        let by_odds = |slope: &Vec<f64>| {
            let (one, other) =
                (covariance(slope, &factor.entries), covariance(&factor.entries, slope));
            one.iter().zip(&other).map(|(a, b)| a + b).collect()
        };
        let of_variances = (0..n).map(by_variance);
        let slopes = of_variances.chain(factor.slopes.iter().map(by_odds)).collect();
        let (variances, odds) = (variances.to_vec(), odds.to_vec());
        Self { variances, odds, rank, covariance: whole, slopes }
    }

    /// The number of outputs.
    pub fn n_outputs(&self) -> usize {
        self.variances.len()
    }

    /// B_ij.
    ///
    /// # Panics
    /// If there is no output `i` or `j`.
    pub fn covariance(&self, i: usize, j: usize) -> f64 {
        self.covariance[i * self.n_outputs() + j]
    }

    /// Rows of one output each: the inputs with the output's number behind them, and the outputs that
    /// are there.
    ///
    /// - `x`: inputs, N×D; - `outputs`: N of each output, and none where one is missing.
    ///
    /// # Errors
    /// `ShapeMismatch` if there is not one a row; `Empty` without any output.
    pub fn stack<'a>(
        x: impl Into<Inputs<'a>>,
        outputs: &[Vec<Option<f64>>],
    ) -> Result<(Mat<f64>, Vec<f64>), GpError> {
        let x = x.into().matrix();
        let mut rows: Vec<(usize, usize)> = Vec::new();
        let mut y = Vec::new();
        for (number, output) in outputs.iter().enumerate() {
            check_count("outputs", x.nrows(), output.len())?;
            for (i, value) in output.iter().enumerate() {
                if let Some(value) = value {
                    rows.push((i, number));
                    y.push(*value);
                }
            }
        }
        if y.is_empty() {
            return Err(GpError::Empty { what: "outputs" });
        }
        check_outputs("outputs", &y, y.len())?;
        let entry = |k: usize, d: usize| match d == x.ncols() {
            true => rows[k].1 as f64,
            false => x[(rows[k].0, d)],
        };
        Ok((Mat::from_fn(y.len(), x.ncols() + 1, entry), y))
    }

    /// Inputs at which to predict an output: `x` with its number behind each row.
    pub fn inputs_of<'a>(x: impl Into<Inputs<'a>>, output: usize) -> Mat<f64> {
        let x = x.into().matrix();
        let entry = |i: usize, d: usize| if d == x.ncols() { output as f64 } else { x[(i, d)] };
        Mat::from_fn(x.nrows(), x.ncols() + 1, entry)
    }

    /// The place of two outputs in B; the nearest number counts.
    fn place(&self, a: &[f64], b: &[f64]) -> usize {
        let last = self.n_outputs().saturating_sub(1) as f64;
        let number = |input: f64| input.round().clamp(0.0, last) as usize;
        number(a[0]) * self.n_outputs() + number(b[0])
    }
}

/// Which output has odds with which shared function. An output with a smaller number than the rank has none
/// with later functions, which would turn the functions into each other and no more.
fn loadings(n: usize, rank: usize) -> Vec<(usize, usize)> {
    (0..n).flat_map(|i| (0..rank.min(i + 1)).map(move |r| (i, r))).collect()
}

/// L by rows, and its slopes by the logarithms of the odds.
struct Factor {
    width: usize,
    entries: Vec<f64>,
    slopes: Vec<Vec<f64>>,
}

impl Factor {
    fn new(n: usize, odds: &[f64], rank: Option<usize>) -> Self {
        let width = n + rank.unwrap_or(0);
        let mut entries = vec![0.0; n * width];
        let mut slopes = vec![vec![0.0; n * width]; odds.len()];
        let mut first = 0;
        for i in 0..n {
            // Columns that the row shares, and the one that takes the length that is left of it.
            let shared = rank.map_or(i, |rank| rank.min(i + 1));
            let own = i + rank.unwrap_or(0);
            let mut rest = 1.0;
            for j in 0..=shared {
                let number = first + j;
                let has_odds = j < shared && number < odds.len();
                // dρ/d ln odds = ½ (1 − ρ²), and d ln √(1 − ρ²)/d ln odds = −½ ρ.
                let rho = if has_odds { (0.5 * odds[number].ln()).tanh() } else { 0.0 };
                let share = if j < shared { rho } else { 1.0 };
                let place = i * width + if j < shared { j } else { own };
                entries[place] = share * rest;
                for (k, slope) in slopes.iter_mut().enumerate().take(number).skip(first) {
                    let before = (0.5 * odds[k].ln()).tanh();
                    slope[place] = -0.5 * before * share * rest;
                }
                if has_odds {
                    slopes[number][place] = 0.5 * (1.0 - rho * rho) * rest;
                }
                rest *= (1.0 - rho * rho).sqrt();
            }
            first += shared;
        }
        Self { width, entries, slopes }
    }
}

impl Kernel for Coregionalization {
    fn check_n_inputs(&self, n_inputs: usize) -> Result<(), GpError> {
        let n = self.n_outputs();
        if n == 0 {
            return Err(GpError::Empty { what: "variances of outputs" });
        }
        if let Some(rank) = self.rank {
            check_range("rank of the coregionalization", rank as f64, 1.0, n as f64)?;
            check_count("odds of shared functions", loadings(n, rank).len(), self.odds.len())?;
        } else if !self.odds.is_empty() {
            check_count("odds of pairs of outputs", n * (n - 1) / 2, self.odds.len())?;
        }
        check_count("columns of the inputs", 1, n_inputs)
    }

    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        self.covariance.get(self.place(a, b)).copied().unwrap_or(0.0)
    }

    fn parameters(&self) -> Vec<Parameter> {
        let variance = |(i, &value): (usize, &f64)| {
            Parameter::new(format!("coregionalization.variance[{i}]"), value, Role::Variance)
        };
        let pairs: Vec<(usize, usize)> = match self.rank {
            Some(rank) => loadings(self.n_outputs(), rank),
            None => (1..self.n_outputs()).flat_map(|i| (0..i).map(move |j| (i, j))).collect(),
        };
        let odds = pairs.into_iter().zip(&self.odds).map(|((i, j), &value)| {
            Parameter::new(format!("coregionalization.odds[{i},{j}]"), value, Role::Odds)
        });
        self.variances.iter().enumerate().map(variance).chain(odds).collect()
    }

    fn with_values(&self, values: &[f64]) -> Box<dyn Kernel> {
        let (variances, odds) = values.split_at(self.n_outputs());
        Box::new(Self::of(variances, odds, self.rank))
    }

    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let place = self.place(a, b);
        gradient.iter_mut().zip(&self.slopes).for_each(|(slope, by)| *slope = by[place]);
    }

    fn input_gradient(&self, _a: &[f64], _b: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
    }

    fn spec(&self) -> Option<KernelSpec> {
        let (variances, odds) = (self.variances.clone(), self.odds.clone());
        Some(KernelSpec::Coregionalization { variances, odds, rank: self.rank })
    }
}
