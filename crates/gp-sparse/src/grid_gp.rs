//! The process on a grid and its predictions.

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use gp_core::checks::{check_inputs, check_positive};
use gp_core::kernel::{column, copy_row, mirror_lower};
use gp_core::triangle::{add_outer, inverse};
use gp_core::vector::dot;
use gp_core::{GpError, JointGaussian, Kernel, Mean, Monomials, Posterior};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};

use crate::grid::{Grid, Stencil};
use crate::grid_objective::{GridObjective, in_panels};
use crate::grid_options::{GridOptions, summed};
use crate::grid_report::GridReport;
use crate::grid_sums::GridSums;
use crate::row_sums::Solved;
use crate::sparse_gp::check_data;

/// A Gaussian process of one to four inputs seen through its values at the M nodes of a regular grid,
/// between which it is interpolated by cubes: for up to millions of rows.
///
/// One pass over the rows leaves sums of which every evaluation of the likelihood with its gradient costs
/// O(M³), whatever N is; a mean costs 4ᴰ operations, a variance 16ᴰ. Beyond the nodes, where no data
/// were, predictions are those of the process given the nodes, O(M²).
///
/// - f mean: h*ᵀβ + w*ᵀ f̂, with w* the shares of the nodes and f̂ their posterior mean;
/// - f variance: w*ᵀΣw*, what the data leave open of the nodes; what cubes between the nodes miss of f,
///   k** − 2 w*ᵀk* + w*ᵀKw*; and what the data leave open of a learnt mean.
///
/// # Source
/// Wilson & Nickisch, Kernel interpolation for scalable structured Gaussian processes (2015), KISS-GP;
/// Yadav, Sheldon & Musco, Faster kernel interpolation for Gaussian processes (2021), for the sums.
#[derive(Clone, Debug)]
pub struct GridGp {
    pub(crate) kernel: Arc<dyn Kernel>,
    pub(crate) noise_variance: f64,
    pub(crate) mean: Mean,
    pub(crate) jitter: f64,
    pub(crate) grid: Grid,
    pub(crate) sums: GridSums,
    z: Mat<f64>,
    monomials: Monomials,
    /// Of the mean, then of the deviations of a learnt one.
    functions: Vec<Function>,
    /// K and Σ, both triangles.
    prior: Mat<f64>,
    posterior: Mat<f64>,
    factor_inverse: Mat<f64>,
    log_likelihood: f64,
    pub(crate) report: Option<Arc<GridReport>>,
}

/// c + Σ g h(x) + w(x)ᵀv.
#[derive(Clone, Debug)]
struct Function {
    constant: f64,
    coefficients: Vec<f64>,
    nodes: Vec<f64>,
}

impl GridGp {
    /// Conditions known parameters on rows that have been summed.
    pub(crate) fn condition(
        kernel: Arc<dyn Kernel>,
        noise_variance: f64,
        (grid, sums): (Grid, GridSums),
        mean: Mean,
        jitter: f64,
    ) -> Result<Self, GpError> {
        check_positive("noise variance", noise_variance)?;
        let mut objective = GridObjective::new(&sums, grid.positions(), mean, jitter);
        let log_likelihood = objective.value(&*kernel, noise_variance)?;
        let turned = objective.turn().to_owned();
        let mut posterior = Mat::zeros(turned.nrows(), turned.nrows());
        in_panels(posterior.as_mut(), |panel, start| {
            let right = turned.get(start..start + panel.ncols(), ..).transpose();
            matmul(panel, Accum::Replace, turned.get(start.., ..), right, 1.0, Par::Seq);
        });
        mirror_lower(&mut posterior);
        let mut prior = objective.gram.clone();
        mirror_lower(&mut prior);
        let functions = functions(&objective, sums.origin);
        let (factor_inverse, monomials) =
            (inverse(objective.factor.as_ref()), objective.monomials().clone());
        let z = grid.positions();
        Ok(Self {
            kernel,
            noise_variance,
            mean,
            jitter,
            grid,
            sums,
            z,
            monomials,
            functions,
            prior,
            posterior,
            factor_inverse,
            log_likelihood,
            report: None,
        })
    }

    /// The kernel, with its parameters in the user's units.
    pub fn kernel(&self) -> &dyn Kernel {
        &*self.kernel
    }

    /// The variance of the noise on an observation, in the squared unit of the output.
    pub fn noise_variance(&self) -> f64 {
        self.noise_variance
    }

    /// The nodes, M×D.
    pub fn nodes(&self) -> MatRef<'_, f64> {
        self.z.as_ref()
    }

    /// The number of rows N.
    pub fn n_rows(&self) -> usize {
        self.sums.n_rows
    }

    /// ln p(y | X) of the interpolated process, in nats; of what a learnt mean does not touch.
    pub fn log_marginal_likelihood(&self) -> f64 {
        self.log_likelihood
    }

    /// Shares of all nodes in one input, and whether it lies among those that are kept.
    fn shares(&self, x: &[f64], stencil: &mut Stencil) -> bool {
        if self.grid.stencil(x, stencil) {
            return true;
        }
        let m = self.z.nrows();
        let mut known = vec![0.0; m];
        self.kernel.column(self.z.as_ref(), x, &mut known);
        let whitened: Vec<f64> =
            (0..m).map(|i| (0..=i).map(|j| self.factor_inverse[(i, j)] * known[j]).sum()).collect();
        stencil.nodes = (0..m as u32).collect();
        stencil.weights =
            (0..m).map(|j| dot(&column(&self.factor_inverse, j)[j..], &whitened[j..])).collect();
        false
    }

    /// Mean and variance at one input.
    fn predict_one(&self, x: &[f64], prior: f64, stencil: &mut Stencil) -> (f64, f64) {
        self.shares(x, stencil);
        let mut variance = self.quadratic(&self.posterior, stencil).max(0.0);
        variance += self.missed(x, prior, stencil);
        let mut values = self.functions.iter().map(|function| self.value(function, x, stencil));
        let mean = values.next().expect("the mean is always there");
        values.for_each(|moved| variance += moved * moved);
        (mean, variance)
    }

    /// w*ᵀ A w*.
    fn quadratic(&self, matrix: &Mat<f64>, stencil: &Stencil) -> f64 {
        let terms = || stencil.nodes.iter().zip(&stencil.weights);
        let row = |a: u32| {
            let column = column(matrix, a as usize);
            terms().map(|(&b, weight)| weight * column[b as usize]).sum::<f64>()
        };
        terms().map(|(&a, weight)| weight * row(a)).sum()
    }

    /// The prior variance of what cubes between the nodes miss of f: k** − 2 w*ᵀk* + w*ᵀKw*.
    fn missed(&self, x: &[f64], prior: f64, stencil: &Stencil) -> f64 {
        let mut node = vec![0.0; x.len()];
        let mut with_nodes = 0.0;
        for (&a, weight) in stencil.nodes.iter().zip(&stencil.weights) {
            copy_row(self.z.as_ref(), a as usize, &mut node);
            with_nodes += weight * self.kernel.value(x, &node);
        }
        // Rounding alone can make it negative.
        (prior - 2.0 * with_nodes + self.quadratic(&self.prior, stencil)).max(0.0)
    }

    fn value(&self, function: &Function, x: &[f64], stencil: &Stencil) -> f64 {
        let mut value = [function.constant];
        let row = MatRef::from_row_major_slice(x, 1, x.len());
        self.monomials.add(row, &function.coefficients, &mut value);
        let terms = stencil.nodes.iter().zip(&stencil.weights);
        value[0] + terms.map(|(&a, weight)| weight * function.nodes[a as usize]).sum::<f64>()
    }

    /// Prior variances of rows.
    fn prior_variances(&self, x_star: MatRef<'_, f64>) -> Vec<f64> {
        let mut variances = vec![0.0; x_star.nrows()];
        self.kernel.diagonal(x_star, &mut variances);
        variances
    }
}

/// Of the mean and its deviations.
fn functions(objective: &GridObjective<'_>, origin: f64) -> Vec<Function> {
    let Solved { responses, .. } = &objective.solved;
    let function = |(i, response): (usize, &crate::block::Response)| {
        let (constant, rest) = response.coefficients.split_first().expect("1 is in every basis");
        let constant = if i == 0 { origin + constant } else { *constant };
        let nodes = objective.node_values(response);
        Function { constant, coefficients: rest.to_vec(), nodes }
    };
    responses.iter().enumerate().map(function).collect()
}

impl Posterior for GridGp {
    fn n_inputs(&self) -> usize {
        self.z.ncols()
    }

    fn predict_mean(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        let mut mean = vec![0.0; x_star.nrows()];
        mean.par_chunks_mut(ROWS).enumerate().for_each(|(block, mean)| {
            let (mut stencil, mut row) = (Stencil::default(), vec![0.0; x_star.ncols()]);
            for (i, mean) in mean.iter_mut().enumerate() {
                copy_row(x_star, block * ROWS + i, &mut row);
                self.shares(&row, &mut stencil);
                *mean = self.value(&self.functions[0], &row, &stencil);
            }
        });
        Ok(mean)
    }

    fn predict(&self, x_star: MatRef<'_, f64>) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        let (mut mean, mut variance) = (vec![0.0; x_star.nrows()], self.prior_variances(x_star));
        let blocks = mean.par_chunks_mut(ROWS).zip(variance.par_chunks_mut(ROWS));
        blocks.enumerate().for_each(|(block, (mean, variance))| {
            let (mut stencil, mut row) = (Stencil::default(), vec![0.0; x_star.ncols()]);
            for (i, (mean, variance)) in mean.iter_mut().zip(variance).enumerate() {
                copy_row(x_star, block * ROWS + i, &mut row);
                (*mean, *variance) = self.predict_one(&row, *variance, &mut stencil);
            }
        });
        Ok((mean, variance))
    }

    /// What cubes miss between the nodes counts at each input alone.
    fn predict_joint(&self, x_star: MatRef<'_, f64>) -> Result<JointGaussian, GpError> {
        let mean = self.predict_mean(x_star)?;
        let (n, m) = (x_star.nrows(), self.z.nrows());
        let (mut stencil, mut row) = (Stencil::default(), vec![0.0; x_star.ncols()]);
        let mut shares = Mat::zeros(n, m);
        let mut missed = self.prior_variances(x_star);
        let mut moved = vec![vec![0.0; n]; self.functions.len() - 1];
        for i in 0..n {
            copy_row(x_star, i, &mut row);
            self.shares(&row, &mut stencil);
            for (&a, weight) in stencil.nodes.iter().zip(&stencil.weights) {
                shares[(i, a as usize)] = *weight;
            }
            missed[i] = self.missed(&row, missed[i], &stencil);
            for (moved, function) in moved.iter_mut().zip(&self.functions[1..]) {
                moved[i] = self.value(function, &row, &stencil);
            }
        }
        let mut covariance = &shares * &self.posterior * shares.transpose();
        for (i, missed) in missed.iter().enumerate() {
            covariance[(i, i)] = covariance[(i, i)].max(0.0) + missed;
        }
        moved.iter().for_each(|moved| add_outer(&mut covariance, moved));
        mirror_lower(&mut covariance);
        JointGaussian::new(mean, covariance)
    }

    fn predict_noise(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        Ok(vec![self.noise_variance; x_star.nrows()])
    }
}

impl GridGp {
    /// Conditions known parameters on data; O(N 16ᴰ + M³).
    ///
    /// - `x`: inputs, N×D; `y`: outputs, N; `noise_variance`: positive, in the squared unit of the output.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch`, `NotFinite`, `NotPositive`; `OutOfRange` for more than four inputs or a
    /// mean of a degree above 2; `NotPositiveDefinite` where nodes are too close for the jitter.
    pub fn fit(
        kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        noise_variance: f64,
        options: &GridOptions,
    ) -> Result<Self, GpError> {
        check_data(&kernel, x, y)?;
        let summed = summed(&kernel, x, y, options)?;
        Self::condition(Arc::new(kernel), noise_variance, summed, options.mean, options.jitter)
    }
}

/// Rows that are predicted together.
const ROWS: usize = 256;
