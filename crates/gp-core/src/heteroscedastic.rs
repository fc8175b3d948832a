//! A Gaussian process whose noise is a function of the input, and its predictions.

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};
use serde::{Deserialize, Serialize};

use crate::checks::{check_count, check_inputs, check_outputs, check_positive};
use crate::cholesky::Cholesky;
use crate::kernel::{column, copy_row, fill_cross, fill_lower_gram, mirror_lower};
use crate::mean::Deviation;
use crate::noise_bound::{NoiseBound, NoisePoint, beta};
use crate::triangle::add_outer;
use crate::vector::{add_square, dot};
use crate::{GpError, JointGaussian, Kernel, KernelSpec, Mean, Posterior};

/// y = f(x) + ε with ε ~ N(0, e^g(x)), f ~ GP(m, k_f) and g ~ GP(μ₀, k_g), conditioned on data.
///
/// The beliefs about f and g are the best Gaussians in the variational sense. The noise predicted
/// at an input is the mean of eᵍ there, E = exp(μ* + σ*²/2); an observation is taken as Gaussian
/// with that variance, though its tails are heavier where g is uncertain.
///
/// # Source
/// Lázaro-Gredilla & Titsias, Variational heteroscedastic Gaussian process regression (2011).
#[derive(Clone, Debug)]
pub struct HeteroscedasticGp {
    kernel: Arc<dyn Kernel>,
    noise_kernel: Arc<dyn Kernel>,
    x: Mat<f64>,
    y: Vec<f64>,
    mean: Mean,
    constant: f64,
    deviations: Vec<Deviation>,
    log_noise_mean: f64,
    precisions: Vec<f64>,
    weights: Vec<f64>,
    /// K_f + R, and I + Λ^½K_gΛ^½.
    cholesky: Cholesky,
    noise_cholesky: Cholesky,
    bound: f64,
}

/// Everything from which `HeteroscedasticGp::from_model` rebuilds the same predictions, bit for bit.
///
/// A text format has to keep all digits (with `serde_json`: its feature `float_roundtrip`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeteroscedasticGpModel {
    /// Version of this format.
    pub version: u32,
    /// The kernel of f.
    pub kernel: KernelSpec,
    /// The kernel of g, the logarithm of the noise variance.
    pub noise_kernel: KernelSpec,
    /// The constant mean of f; an estimated one is estimated again.
    pub mean: Mean,
    /// The constant mean μ₀ of g.
    pub log_noise_mean: f64,
    /// What each row tells about g, as a precision; positive.
    pub precisions: Vec<f64>,
    /// Training inputs, one row a vector.
    pub inputs: Vec<Vec<f64>>,
    /// Training outputs.
    pub outputs: Vec<f64>,
}

impl HeteroscedasticGpModel {
    /// The version that this release writes and reads.
    pub const VERSION: u32 = 1;
}

impl HeteroscedasticGp {
    /// Conditions checked data on known parameters; O(N³).
    pub(crate) fn condition(
        kernel: Arc<dyn Kernel>,
        noise_kernel: Arc<dyn Kernel>,
        x: MatRef<'_, f64>,
        y: &[f64],
        mean: Mean,
        log_noise_mean: f64,
        precisions: Vec<f64>,
    ) -> Result<Self, GpError> {
        let mut bound = NoiseBound::new(x, y, mean);
        let point = NoisePoint {
            kernel: &*kernel,
            noise_kernel: &*noise_kernel,
            log_noise_mean,
            precisions: &precisions,
        };
        let value = bound.value(&point)?;
        check_outputs("bound", &[value], 1)?;
        let (constant, weights, deviations) = (bound.constant, bound.weights, bound.deviations);
        let cholesky = Cholesky::from_factor(bound.factor);
        let noise_cholesky = Cholesky::from_factor(bound.noise_factor);
        Ok(Self {
            x: x.to_owned(),
            y: y.to_vec(),
            kernel,
            noise_kernel,
            mean,
            constant,
            deviations,
            log_noise_mean,
            precisions,
            weights,
            cholesky,
            noise_cholesky,
            bound: value,
        })
    }

    /// The kernel of f, with its parameters in the user's units.
    pub fn kernel(&self) -> &dyn Kernel {
        &*self.kernel
    }

    /// The kernel of g, the logarithm of the noise variance.
    pub fn noise_kernel(&self) -> &dyn Kernel {
        &*self.noise_kernel
    }

    /// The constant mean m of f, in the unit of the output.
    pub fn mean(&self) -> f64 {
        self.constant
    }

    /// The constant mean μ₀ of g: far from all data the noise variance has the median e^μ₀.
    pub fn log_noise_mean(&self) -> f64 {
        self.log_noise_mean
    }

    /// The lower bound of ln p(y | X) that was maximised, in nats.
    pub fn bound(&self) -> f64 {
        self.bound
    }

    /// Mean and variance of g, the logarithm of the noise variance, at each row.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch` or `NotFinite` if `x_star` is not a finite M×D matrix.
    pub fn predict_log_noise(
        &self,
        x_star: MatRef<'_, f64>,
    ) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        let beta = beta(&self.precisions);
        let scales: Vec<f64> = self.precisions.iter().map(|precision| precision.sqrt()).collect();
        let belief = Belief {
            kernel: &*self.noise_kernel,
            x: self.x.as_ref(),
            constant: self.log_noise_mean,
            deviations: &[],
            weights: &beta,
            scales: Some(&scales),
            cholesky: &self.noise_cholesky,
        };
        belief.predict(x_star)
    }

    fn belief(&self) -> Belief<'_> {
        Belief {
            kernel: &*self.kernel,
            x: self.x.as_ref(),
            constant: self.constant,
            deviations: &self.deviations,
            weights: &self.weights,
            scales: None,
            cholesky: &self.cholesky,
        }
    }

    /// The process as plain data.
    ///
    /// # Errors
    /// `NotSerializable` for a user's kernel without a `KernelSpec`.
    pub fn to_model(&self) -> Result<HeteroscedasticGpModel, GpError> {
        let spec = |kernel: &dyn Kernel| {
            let unknown = || GpError::NotSerializable { kernel: format!("{kernel:?}") };
            kernel.spec().ok_or_else(unknown)
        };
        let row = |i: usize| (0..self.x.ncols()).map(|d| self.x[(i, d)]).collect();
        Ok(HeteroscedasticGpModel {
            version: HeteroscedasticGpModel::VERSION,
            kernel: spec(&*self.kernel)?,
            noise_kernel: spec(&*self.noise_kernel)?,
            mean: self.mean,
            log_noise_mean: self.log_noise_mean,
            precisions: self.precisions.clone(),
            inputs: (0..self.y.len()).map(row).collect(),
            outputs: self.y.clone(),
        })
    }

    /// The process that `to_model` described.
    ///
    /// # Errors
    /// `UnsupportedVersion`; else what is wrong with an edited file.
    pub fn from_model(model: &HeteroscedasticGpModel) -> Result<Self, GpError> {
        if model.version != HeteroscedasticGpModel::VERSION {
            let supported = HeteroscedasticGpModel::VERSION;
            return Err(GpError::UnsupportedVersion { found: model.version, supported });
        }
        let (kernel, noise_kernel) = (model.kernel.build()?, model.noise_kernel.build()?);
        let d = kernel.n_inputs();
        check_count("inputs of the noise kernel", d, noise_kernel.n_inputs())?;
        for row in &model.inputs {
            check_count("columns of the inputs", d, row.len())?;
        }
        let x = Mat::from_fn(model.inputs.len(), d, |i, j| model.inputs[i][j]);
        check_inputs("inputs", x.as_ref(), d)?;
        check_outputs("outputs", &model.outputs, x.nrows())?;
        model.mean.check_constant()?;
        check_outputs("log_noise_mean", &[model.log_noise_mean], 1)?;
        check_count("precisions", x.nrows(), model.precisions.len())?;
        for precision in &model.precisions {
            check_positive("precision", *precision)?;
        }
        Self::condition(
            Arc::from(kernel),
            Arc::from(noise_kernel),
            x.as_ref(),
            &model.outputs,
            model.mean,
            model.log_noise_mean,
            model.precisions.clone(),
        )
    }
}

impl Posterior for HeteroscedasticGp {
    fn n_inputs(&self) -> usize {
        self.kernel.n_inputs()
    }

    fn predict_mean(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        let mut mean = vec![0.0; x_star.nrows()];
        mean.par_chunks_mut(BLOCK).enumerate().for_each(|(block, mean)| {
            let mut values = vec![0.0; self.y.len()];
            let mut row = vec![0.0; x_star.ncols()];
            for (j, mean) in mean.iter_mut().enumerate() {
                copy_row(x_star, block * BLOCK + j, &mut row);
                self.kernel.column(self.x.as_ref(), &row, &mut values);
                *mean = self.constant + dot(&values, &self.weights);
            }
        });
        Ok(mean)
    }

    fn predict(&self, x_star: MatRef<'_, f64>) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        self.belief().predict(x_star)
    }

    fn predict_multi_contact(&self, x_star: MatRef<'_, f64>) -> Result<JointGaussian, GpError> {
        let mean = self.predict_mean(x_star)?;
        let mut cross = Mat::zeros(self.y.len(), x_star.nrows());
        fill_cross(&*self.kernel, self.x.as_ref(), x_star, cross.as_mut());
        let moved = moved(&self.deviations, &cross, x_star);
        self.cholesky.solve_lower(cross.as_mut());
        let mut covariance = Mat::zeros(x_star.nrows(), x_star.nrows());
        fill_lower_gram(&*self.kernel, x_star, &mut covariance);
        matmul(covariance.as_mut(), Accum::Add, cross.transpose(), &cross, -1.0, Par::Seq);
        for j in 0..covariance.ncols() {
            covariance[(j, j)] = covariance[(j, j)].max(0.0);
        }
        moved.iter().for_each(|moved| add_outer(&mut covariance, moved));
        mirror_lower(&mut covariance);
        JointGaussian::new(mean, covariance)
    }

    fn predict_noise(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        let (mean, variance) = self.predict_log_noise(x_star)?;
        Ok(mean.iter().zip(&variance).map(|(m, v)| (m + 0.5 * v).exp()).collect())
    }
}

/// The Gaussian belief about f or about g.
struct Belief<'a> {
    kernel: &'a dyn Kernel,
    x: MatRef<'a, f64>,
    constant: f64,
    deviations: &'a [Deviation],
    weights: &'a [f64],
    /// What multiplies the rows of k(X, x*) before the factor divides them; 1 if there are none.
    scales: Option<&'a [f64]>,
    cholesky: &'a Cholesky,
}

impl Belief<'_> {
    fn predict(&self, x_star: MatRef<'_, f64>) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        check_inputs("inputs", x_star, self.kernel.n_inputs())?;
        let mut mean = vec![0.0; x_star.nrows()];
        let mut variance = vec![0.0; x_star.nrows()];
        mean.par_chunks_mut(BLOCK).zip(variance.par_chunks_mut(BLOCK)).enumerate().for_each(
            |(block, (mean, variance))| {
                let rows = x_star.subrows(block * BLOCK, mean.len());
                self.predict_block(rows, mean, variance);
            },
        );
        Ok((mean, variance))
    }

    fn predict_block(&self, x_star: MatRef<'_, f64>, mean: &mut [f64], variance: &mut [f64]) {
        let mut cross = Mat::zeros(self.x.nrows(), x_star.nrows());
        fill_cross(self.kernel, self.x, x_star, cross.as_mut());
        for (j, mean) in mean.iter_mut().enumerate() {
            *mean = self.constant + dot(column(&cross, j), self.weights);
        }
        let moved = moved(self.deviations, &cross, x_star);
        if let Some(scales) = self.scales {
            for j in 0..cross.ncols() {
                let values = crate::kernel::column_mut(&mut cross, j);
                values.iter_mut().zip(scales).for_each(|(value, scale)| *value *= scale);
            }
        }
        self.cholesky.solve_lower(cross.as_mut());
        self.kernel.diagonal(x_star, variance);
        for (j, variance) in variance.iter_mut().enumerate() {
            let explained = dot(column(&cross, j), column(&cross, j));
            // Rounding alone can make the difference of two nearly equal variances negative.
            *variance = (*variance - explained).max(0.0);
        }
        moved.iter().for_each(|moved| add_square(variance, 1.0, moved));
    }
}

/// The deviations of the mean at each row, from k(X, X*).
fn moved(deviations: &[Deviation], cross: &Mat<f64>, x_star: MatRef<'_, f64>) -> Vec<Vec<f64>> {
    let at_rows = |Deviation { trend, weights }: &Deviation| {
        let mut moved = vec![0.0; x_star.nrows()];
        trend.fill(x_star, &mut moved);
        for (j, moved) in moved.iter_mut().enumerate() {
            *moved += dot(column(cross, j), weights);
        }
        moved
    };
    deviations.iter().map(at_rows).collect()
}

/// Inputs predicted together; the results do not depend on who computes which block.
const BLOCK: usize = 64;
