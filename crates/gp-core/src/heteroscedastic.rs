//! A Gaussian process whose noise is a function of the input, and its predictions.

use std::sync::Arc;

use faer::MatRef;
use serde::{Deserialize, Serialize};

use crate::checks::{check_count, check_outputs, check_positive};
use crate::kernel::check_kernel_and_inputs;
use crate::model::matrix;
use crate::noise::Noise;
use crate::noise_bound::{NoiseBound, NoisePoint};
use crate::{Gp, GpError, JointGaussian, Kernel, KernelSpec, Mean, Posterior, saved_as};

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
    /// f, with the noise of each row.
    gp: Gp,
    /// g. To it each row is an observation with the noise 1/λ.
    log_noise: Gp,
    precisions: Vec<f64>,
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
        let noise = Noise { common: 0.0, of_rows: &bound.noise };
        let gp = Gp::condition(kernel.clone(), x, y, noise, mean)?;
        // Observations of g for which (K_g + Λ⁻¹)⁻¹(y − μ₀) = β.
        let observed: Vec<f64> = bound
            .noise_mean(&point)
            .iter()
            .zip(&precisions)
            .map(|(m, p)| m + 1.0 - 0.5 / p)
            .collect();
        let spread: Vec<f64> = precisions.iter().map(|precision| precision.recip()).collect();
        let noise = Noise { common: 0.0, of_rows: &spread };
        let known = Mean::Fixed(log_noise_mean);
        let log_noise = Gp::condition(noise_kernel.clone(), x, &observed, noise, known)?;
        Ok(Self { gp, log_noise, precisions, bound: value })
    }

    /// The kernel of f, with its parameters in the user's units.
    pub fn kernel(&self) -> &dyn Kernel {
        self.gp.kernel()
    }

    /// The kernel of g, the logarithm of the noise variance.
    pub fn noise_kernel(&self) -> &dyn Kernel {
        self.log_noise.kernel()
    }

    /// The constant mean m of f, in the unit of the output.
    pub fn mean(&self) -> f64 {
        self.gp.mean()
    }

    /// The constant mean μ₀ of g: far from all data the noise variance has the median e^μ₀.
    pub fn log_noise_mean(&self) -> f64 {
        self.log_noise.mean()
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
        self.log_noise.predict(x_star)
    }

    /// The process as plain data.
    ///
    /// # Errors
    /// `NotSerializable` for a user's kernel without a `KernelSpec`.
    pub fn to_model(&self) -> Result<HeteroscedasticGpModel, GpError> {
        let gp = self.gp.to_model()?;
        Ok(HeteroscedasticGpModel {
            version: HeteroscedasticGpModel::VERSION,
            kernel: gp.kernel,
            noise_kernel: self.log_noise.to_model()?.kernel,
            mean: gp.mean,
            log_noise_mean: self.log_noise_mean(),
            precisions: self.precisions.clone(),
            inputs: gp.inputs,
            outputs: gp.outputs,
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
        let (kernel, noise_kernel) = (model.kernel.build(), model.noise_kernel.build());
        let x = matrix(&model.inputs)?;
        check_kernel_and_inputs(&*kernel, x.as_ref())?;
        noise_kernel.check(x.ncols())?;
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

saved_as!(HeteroscedasticGp => HeteroscedasticGpModel, HeteroscedasticGp::to_model);

impl Posterior for HeteroscedasticGp {
    fn n_inputs(&self) -> usize {
        self.gp.n_inputs()
    }

    fn predict_mean(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        self.gp.predict_mean(x_star)
    }

    fn predict(&self, x_star: MatRef<'_, f64>) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        self.gp.predict(x_star)
    }

    fn predict_joint(&self, x_star: MatRef<'_, f64>) -> Result<JointGaussian, GpError> {
        self.gp.predict_joint(x_star)
    }

    fn predict_noise(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        let (mean, variance) = self.predict_log_noise(x_star)?;
        Ok(mean.iter().zip(&variance).map(|(m, v)| (m + 0.5 * v).exp()).collect())
    }
}
